//! The native file: a ZIP of NumPy arrays (`numpy.load` opens it), version 3.
//!
//! Every member `NAME.npy` is stored by Deflate, dated 1980-01-01, and unpacks to the bytes `93 4E 55 4D 50 59 01 00` (NPY
//! 1.0), the length of what follows up to the data as u16, the text `{'descr': '<f8', 'fortran_order': False, 'shape': (T, P,
//! K), }` with the member's own type and shape, filled with spaces to a multiple of 64 bytes and ended by a line feed,
//! then the values, little-endian, last index fastest. Index k of a cell in column i and row j of the grid is
//! `j (2 half_1 + 1) + i`; its formula is that of [`HalfVectorCells`]. Version 1 had other cells and is refused.
//!
//! | member | type, shape | what |
//! |---|---|---|
//! | `header_json` | u8, bytes of UTF-8 JSON | `format` = "asperity table", `version`, `isotropic`, `material`, `provenance` |
//! | `theta_i_deg` | f64 \[T\] | incident polar angles of the nodes, rising |
//! | `phi_i_deg` | f64 \[P\] | source azimuths of the nodes, rising; one if isotropic |
//! | `slope_centre` | f64 \[2\] | slope (p, q) at the centre of the cells |
//! | `slope_cell_width` | f64 \[2\] | slope across a core cell along the two axes |
//! | `axis_angle_deg` | f64 \[1\] | direction of the first axis from +x |
//! | `cells_per_axis` | u32 \[2,3\] | per axis: equal cells on each side of the central one, tail cells per doubling of the width, cells in all on each side; K = (2 last\[0\] + 1) (2 last\[1\] + 1) |
//! | `density` | f64 \[T,P,K\] | T of [`Table`]'s formula at the cell centres, per unit slope area |
//! | `density_relative_se` | f64 \[T,P,K\] | its standard error, relative |
//! | `subarea_ratio` | f64 \[S,K\] | density of each sub-area over that of the map |
//! | `diffuse_albedo` | f64 \[T,P\] | albedo F of the diffuse floor, `f_r = F / pi` |
//! | `speckle_ratio` | f64 \[U,K\] | the same for nodes of the wave calculation: parts of the speckle |
//! | `specular_core_share` | f64 \[T,P\] | share of the light that stays a mirror beam (before Fresnel) |
//! | `masking` | f64 \[129\] | `cos Lambda(cos)` of G in [`Table`]'s formula at the cosines 0, 1/128 .. 1; not in version 2, where G = 1 |
//! | `wave`, `specular_core_relative_se` | f64 \[T,P\] | 1 where the wave calculation served; error of its mirror beam |
//! | `one_ray_share` | f64 \[T,P\] | share of the incident energy that one counted ray carried, 0 without rays; not in version 2 |
//! | `height_steps` | f64 \[3\] | only if the heights come in steps and were spread evenly within them: step \[m\], angle between glints one step apart \[deg\], share of the facets that are the core with the heights as they are, less that of the table |
//! | `height_steps_change` | f64 \[K\] | slope density with the heights as they are, less that of the table; with `height_steps` |
//! | `albedo`, `albedo_se`, `absorbed`, `lost`, `multiple_bounce`, `shadowed` | f64 \[T,P\] | energy book |
//!
//! All little-endian, C order. Same table, same bytes.

use super::masking::Masking;
use super::nodes::Nodes;
use super::{Node, Provenance, Steps, Table, balance::Balance, core::Cores};
use crate::archive::{self, Archive};
use crate::error::{Error, Fault, Result};
use crate::npy;
use crate::optics::Material;
use crate::output;
use crate::scatter::HalfVectorCells;
use crate::scatter::axis::Axis;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version written and read.
pub const FORMAT_VERSION: u32 = 3;

/// Oldest version read: it has no masking of its own.
const OLDEST: u32 = 2;

const NAME: &str = "asperity table";

/// Longest array a table may claim: a file may not ask for more memory than a very fine table needs.
const MOST_VALUES: usize = 1 << 27;

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    isotropic: bool,
    material: Material,
    provenance: Provenance,
}

/// Accessors of [`Node`] in the order they are stored.
type Field = (&'static str, fn(&mut Node) -> &mut f64);
const NODE_FIELDS: [Field; 11] = [
    ("diffuse_albedo", |n| &mut n.diffuse),
    ("specular_core_share", |n| &mut n.core_share),
    ("albedo", |n| &mut n.albedo),
    ("albedo_se", |n| &mut n.albedo_error),
    ("absorbed", |n| &mut n.absorbed),
    ("lost", |n| &mut n.lost),
    ("multiple_bounce", |n| &mut n.multiple),
    ("shadowed", |n| &mut n.shadowed),
    ("wave", |n| &mut n.wave),
    ("specular_core_relative_se", |n| &mut n.core_error),
    ("one_ray_share", |n| &mut n.one_ray),
];

impl Table {
    /// Writes the table as `.npz`, atomically.
    ///
    /// # Errors
    /// `Error::Io` naming the file.
    pub fn save(&self, path: &Path) -> Result<()> {
        let bytes = self.to_bytes().map_err(|e| Error::io(path, "write", e))?;
        output::write_bytes(path, &bytes)
    }

    fn to_bytes(&self) -> std::io::Result<Vec<u8>> {
        let header = Header {
            format: NAME.to_owned(),
            version: FORMAT_VERSION,
            isotropic: self.isotropic,
            material: self.material,
            provenance: self.provenance.clone(),
        };
        let json = serde_json::to_vec(&header)?;
        let (t, p, k) = (self.theta_i.len(), self.phi_i.len(), self.cells.len());
        let degrees = |v: &[f64]| v.iter().map(|x| x.to_degrees()).collect::<Vec<_>>();
        let list = |v: Vec<f64>| npy::encode(&[v.len()], v);
        let mut members = vec![
            ("header_json", npy::encode(&[json.len()], json)),
            ("theta_i_deg", list(degrees(&self.theta_i))),
            ("phi_i_deg", list(degrees(&self.phi_i))),
            ("slope_centre", list(self.cells.centre.to_vec())),
            ("slope_cell_width", list(self.cells.width.to_vec())),
            ("axis_angle_deg", list(vec![self.cells.angle.to_degrees()])),
            (
                "cells_per_axis",
                npy::encode(&[2, 3], self.cells.axes.iter().flat_map(|a| [a.core, a.per_octave, a.half])),
            ),
            ("density", npy::encode(&[t, p, k], self.density.iter().copied())),
            ("density_relative_se", npy::encode(&[t, p, k], self.relative_error.iter().copied())),
            (
                "subarea_ratio",
                npy::encode(&[self.subarea_ratio.len(), k], self.subarea_ratio.iter().flatten().copied()),
            ),
            ("masking", list(self.masking.steps().to_vec())),
            (
                "speckle_ratio",
                npy::encode(&[self.speckle_ratio.len(), k], self.speckle_ratio.iter().flatten().copied()),
            ),
        ];
        if let Some(steps) = &self.steps {
            members.push(("height_steps", list(vec![steps.step, steps.glint_spacing.to_degrees(), steps.core])));
            members.push(("height_steps_change", list(steps.change.clone())));
        }
        for (name, field) in NODE_FIELDS {
            members.push((name, npy::encode(&[t, p], self.nodes.iter().map(|n| *field(&mut n.clone())))));
        }
        let names: Vec<String> = members.iter().map(|m| format!("{}.npy", m.0)).collect();
        let members: Vec<(&str, &[u8])> =
            names.iter().zip(&members).map(|(name, m)| (name.as_str(), m.1.as_slice())).collect();
        archive::pack(&members)
    }

    /// Whether the bytes begin like the ZIP of a table and hold its header.
    pub fn recognises(bytes: &[u8]) -> bool {
        bytes.starts_with(b"PK\x03\x04")
            && Archive::open(bytes, NAME).is_ok_and(|a| a.names().iter().any(|n| n == "header_json.npy"))
    }

    /// Reads a table.
    ///
    /// # Errors
    /// `Error::Io`, or `Error::File`: not a table, a newer version, damaged, or with values no table can have.
    pub fn load(path: &Path) -> Result<Table> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        Table::from_bytes(&bytes).map_err(|fault| Error::File { path: path.to_owned(), fault })
    }

    /// Reads a table from memory.
    ///
    /// # Errors
    /// The fault that [`Table::load`] reports with the file's name.
    pub fn from_bytes(bytes: &[u8]) -> std::result::Result<Table, Fault> {
        let mut archive = Archive::open(bytes, NAME)?;
        let json = member::<u8>(&mut archive, "header_json", None)?;
        let header: Header =
            serde_json::from_slice(&json).map_err(|e| corrupt(format!("the header cannot be read ({e})")))?;
        if header.format != NAME {
            return Err(Fault::NotThisFormat(NAME));
        }
        if header.version > FORMAT_VERSION {
            return Err(Fault::Unsupported {
                format: NAME,
                what: format!("version {} (this program reads versions {OLDEST} to {FORMAT_VERSION})", header.version),
                advice: "update asperity, or make the table again from its height map".to_owned(),
            });
        }
        if header.version < OLDEST {
            return Err(Fault::Unsupported {
                format: NAME,
                what: format!("version {} (this program reads versions {OLDEST} to {FORMAT_VERSION})", header.version),
                advice: "make the table again from its height map".to_owned(),
            });
        }
        let angles = |archive: &mut Archive, name: &str, below: f64| {
            let degrees = member::<f64>(archive, name, None)?;
            let rising = degrees.windows(2).all(|w| w[0] < w[1]);
            if degrees.is_empty() || !rising || degrees.iter().any(|d| !(0.0..below).contains(d)) {
                return Err(corrupt(format!("{name} is not a rising list of angles")));
            }
            Ok(degrees.into_iter().map(f64::to_radians).collect::<Vec<_>>())
        };
        let theta_i = angles(&mut archive, "theta_i_deg", 90.0)?;
        let phi_i = angles(&mut archive, "phi_i_deg", 360.0)?;
        let cells = read_cells(&mut archive)?;
        let (k, n) = (cells.len(), theta_i.len() * phi_i.len());
        let size = n.checked_mul(k).filter(|&s| s <= MOST_VALUES);
        let size = size.ok_or_else(|| corrupt("more nodes and cells than any table has".to_owned()))?;
        let density = member::<f64>(&mut archive, "density", Some(size))?;
        let relative_error = member::<f64>(&mut archive, "density_relative_se", Some(size))?;
        let ratios = member::<f64>(&mut archive, "subarea_ratio", None)?;
        let speckle = member::<f64>(&mut archive, "speckle_ratio", None)?;
        for (name, list) in [("subarea_ratio", &ratios), ("speckle_ratio", &speckle)] {
            if list.len() % k != 0 {
                return Err(corrupt(format!("{name} has another number of cells than density")));
            }
        }
        if [&density, &relative_error, &ratios, &speckle]
            .iter()
            .any(|v| v.iter().any(|x| !(*x >= 0.0 && x.is_finite())))
        {
            return Err(corrupt("a density is negative or not finite".to_owned()));
        }
        let masking = if header.version == OLDEST {
            Masking::none()
        } else {
            let steps = member::<f64>(&mut archive, "masking", None)?;
            let sound = steps.iter().all(|s| *s >= 0.0 && s.is_finite());
            Masking::from_steps(steps)
                .filter(|_| sound)
                .ok_or_else(|| corrupt("masking is not 129 finite, non-negative numbers".to_owned()))?
        };
        let steps = read_steps(&mut archive, k)?;
        let mut nodes = vec![Node::default(); n];
        for (name, field) in NODE_FIELDS {
            if header.version == OLDEST && name == "one_ray_share" {
                continue;
            }
            for (node, value) in nodes.iter_mut().zip(member::<f64>(&mut archive, name, Some(n))?) {
                if !(value >= 0.0 && value.is_finite()) {
                    return Err(corrupt(format!("{name} is negative or not finite")));
                }
                *field(node) = value;
            }
        }
        let mut table = Table {
            cells,
            isotropic: header.isotropic,
            material: header.material,
            finder: Nodes::new(&theta_i, &phi_i),
            theta_i,
            phi_i,
            density,
            relative_error,
            subarea_ratio: ratios.chunks(k).map(<[f64]>::to_vec).collect(),
            speckle_ratio: speckle.chunks(k).map(<[f64]>::to_vec).collect(),
            masking,
            nodes,
            balance: Balance::default(),
            cores: Cores::default(),
            steps,
            provenance: header.provenance,
        };
        table.cores = Cores::of(&table);
        table.balance = Balance::of(&table);
        Ok(table)
    }
}

fn read_steps(archive: &mut Archive, cells: usize) -> std::result::Result<Option<Steps>, Fault> {
    if !archive.names().iter().any(|name| name == "height_steps.npy") {
        return Ok(None);
    }
    let facts = member::<f64>(archive, "height_steps", Some(3))?;
    let change = member::<f64>(archive, "height_steps_change", Some(cells))?;
    if facts.iter().chain(&change).any(|x| !x.is_finite())
        || facts[..2].iter().any(|x| *x < 0.0)
        || facts[2].abs() > 1.0
    {
        return Err(corrupt("height_steps is out of its range".to_owned()));
    }
    let (step, glint_spacing, core) = (facts[0], facts[1].to_radians(), facts[2]);
    Ok(Some(Steps { step, glint_spacing, core, change }))
}

fn read_cells(archive: &mut Archive) -> std::result::Result<HalfVectorCells, Fault> {
    let centre = member::<f64>(archive, "slope_centre", Some(2))?;
    let width = member::<f64>(archive, "slope_cell_width", Some(2))?;
    let angle = member::<f64>(archive, "axis_angle_deg", Some(1))?[0].to_radians();
    let shape = member::<u32>(archive, "cells_per_axis", Some(6))?;
    let axis = |k: usize| Axis { core: shape[3 * k], per_octave: shape[3 * k + 1], half: shape[3 * k + 2] };
    let axes = [axis(0), axis(1)];
    // The reach of the last cell must be a number, too.
    let sound = axes.iter().all(|a| {
        a.per_octave.is_power_of_two()
            && a.half >= 2
            && a.half <= 1 << 14
            && a.core <= a.half
            && a.half / a.per_octave < 512
    }) && centre.iter().chain([&angle]).all(|v| v.is_finite())
        && width.iter().all(|w| w.is_finite() && *w > 0.0);
    if !sound {
        return Err(corrupt("the cells of the slope plane do not fit together".to_owned()));
    }
    Ok(HalfVectorCells::from_parts([centre[0], centre[1]], [width[0], width[1]], angle, axes))
}

/// The elements of one member; `count` if their number is known.
fn member<T: npy::Element>(
    archive: &mut Archive,
    name: &str,
    count: Option<usize>,
) -> std::result::Result<Vec<T>, Fault> {
    let file = format!("{name}.npy");
    let most = count.unwrap_or(MOST_VALUES) as u64 * 8 + 4096;
    let bytes = archive.read(&file, most)?;
    let values: Vec<T> =
        npy::decode(&bytes).and_then(|a| a.to_vec()).map_err(|e| corrupt(format!("member {file}: {e}")))?;
    match count {
        Some(n) if n != values.len() => {
            Err(corrupt(format!("member {file} holds {} values instead of {n}", values.len())))
        }
        _ => Ok(values),
    }
}

fn corrupt(what: String) -> Fault {
    Fault::Corrupt { format: NAME, what }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::{Edges, level, synth};
    use crate::math::{direction, random::CounterRng};
    use crate::scatter::{Options, scatter};

    fn table() -> Table {
        let grid = synth::Grid { width: 96, height: 80, pitch: [1e-6, 1.5e-6] };
        let surface = synth::Gaussian { sq: 0.3e-6, acl: 6e-6, seed: 1, exact: false };
        let map = level::level(&synth::gaussian(grid, surface).unwrap(), Edges::Open).unwrap();
        let provenance = Provenance { source: "a.x3p".into(), sq: 0.3e-6, ..Provenance::default() };
        Table::from_scatter(&scatter(&map, &Options::default(), &|_| ()).unwrap(), provenance)
    }

    #[test]
    fn what_is_saved_is_read_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.npz");
        let table = table();
        table.save(&path).unwrap();
        let back = Table::load(&path).unwrap();
        assert_eq!(back.density, table.density);
        assert_eq!(back.nodes, table.nodes);
        assert_eq!(back.provenance, table.provenance);
        let (wi, wo) = (direction(0.5, 0.1), direction(0.45, 3.3));
        assert!((back.eval(wi, wo) / table.eval(wi, wo) - 1.0).abs() < 1e-12);
        assert!(Table::recognises(&std::fs::read(&path).unwrap()));
    }

    #[test]
    fn damage_is_one_clear_error() {
        let good = table().to_bytes().unwrap();
        for length in [0, 3, 30, good.len() / 2, good.len() - 1] {
            assert!(Table::from_bytes(&good[..length]).is_err(), "{length}");
        }
        let mut rng = CounterRng::new(3, 0, 0);
        for _ in 0..300 {
            let mut bytes = good.clone();
            for _ in 0..4 {
                let at = (rng.uniform() * bytes.len() as f64) as usize;
                bytes[at] = (rng.uniform() * 256.0) as u8;
            }
            // Damage in a name or date may go unnoticed; what is read must still be sound.
            if let Ok(t) = Table::from_bytes(&bytes) {
                assert!(t.eval(direction(0.5, 0.0), direction(0.5, 3.0)).is_finite());
            }
        }
    }

    #[test]
    fn a_newer_version_says_so() {
        let header = r#"{"format":"asperity table","version":99,"isotropic":true,"material":"mirror","provenance":
            {"source":"","Sq_m":0,"Sdq":0,"missing_fraction":0,"wavelength_m":0,"method":"auto","seed":0,"program":""}}"#;
        let bytes = npy::encode(&[header.len()], header.bytes());
        let packed = archive::pack(&[("header_json.npy", &bytes)]).unwrap();
        let text = Table::from_bytes(&packed).unwrap_err().to_string();
        assert!(text.contains("version 99") && text.contains("update"), "{text}");
    }
}
