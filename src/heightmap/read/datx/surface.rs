//! The surface in a `.datx` file: which data set, which unit, which pitch.
//!
//! `/MetaData` is a list of edges (source, link, destination): Root -Measurement-> m -Surface-> s -Path-> data set. Its
//! attribute `Unit` says what a height is; Fringes become lengths by wavelength, scale factor and obliquity. The second
//! parameter of `X Converter` and `Y Converter` is metres per pixel. Row 0 is the top row.
//! Source: files of Mx as Gwyddion, prysm and SurfaceTopography read them.

use super::NAME;
use crate::archive::EXPANSION;
use crate::error::Fault;
use crate::heightmap::RawMap;
use crate::heightmap::read::ReadOptions;
use crate::heightmap::read::fields::{Sample, into_grid};
use crate::heightmap::read::units::metres;
use hdf5_reader::messages::datatype::{Datatype, VarLenKind};
use hdf5_reader::{Attribute, Dataset, Hdf5File, OpenOptions};

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    // Chunks that are absent count as filled, so a few bytes could announce any size; measured heights never deflate so
    // far, and no floor is needed for synthetic ones.
    let limit = bytes.len().saturating_mul(EXPANSION as usize);
    let open = OpenOptions::default()
        .with_max_read_bytes(limit)
        .with_max_chunk_bytes(limit)
        .with_max_object_header_bytes(bytes.len())
        .with_chunk_cache_bytes(0);
    let file = Hdf5File::from_bytes_with_options(bytes, open).map_err(broken)?;
    let surface = surface(&file)?;
    let &[rows, columns] = surface.shape() else {
        return Err(corrupt(format!("the surface has {} dimensions", surface.ndim())));
    };
    let (rows, columns) = (rows as usize, columns as usize);
    let unit = match unit(&surface) {
        Some(unit) => unit,
        None => options.unit_or_missing(NAME)?,
    };
    let stated = pixel_size(&surface, "X Converter").zip(pixel_size(&surface, "Y Converter"));
    let [pitch_x, pitch_y] = options.pitch_or(NAME, stated.map(|(x, y)| [x, y]))?;
    let sample = match surface.dtype() {
        Datatype::FloatingPoint { size: 8, .. } => Sample::F64,
        Datatype::FloatingPoint { size: 4, .. } => Sample::F32,
        Datatype::FixedPoint { size: 4, signed: true, .. } => Sample::I32,
        other => return Err(corrupt(format!("heights of type {other:?}"))),
    };
    let native = surface.read_native_bytes().map_err(broken)?;
    let no_data = number(&surface, "No Data").unwrap_or(f64::INFINITY);
    let measured = |h: f64| h.is_finite() && h != no_data && !(no_data > 1e30 && h >= no_data);
    let heights = sample.decode_all(&native, cfg!(target_endian = "big"));
    let heights = heights.into_iter().map(|h| if measured(h) { h * unit } else { f64::NAN }).collect();
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes: vec![] })
}

/// The data set that the graph names, or the only place where Mx puts surfaces.
fn surface(file: &Hdf5File) -> Result<Dataset, Fault> {
    let named = surface_path(file).and_then(|path| file.dataset(&path).ok());
    let first = || file.group("/Data/Surface").ok()?.datasets().ok()?.into_iter().next();
    named.or_else(first).ok_or_else(|| Fault::Unsupported {
        format: NAME,
        what: "an HDF5 file without a Zygo surface".to_owned(),
        advice: "save the surface in Mx as .datx, or export the matrix as .npy".to_owned(),
    })
}

fn surface_path(file: &Hdf5File) -> Option<String> {
    let edges = file.dataset("/MetaData").ok()?;
    let Datatype::Compound { size, fields } = edges.dtype() else { return None };
    let raw = edges.read_raw_bytes().ok()?;
    let edge = |row: &[u8]| -> Option<[String; 3]> {
        let text = |i: usize| {
            let field = fields.get(i)?;
            text_of(&edges, row.get(field.byte_offset as usize..)?, &field.datatype)
        };
        Some([text(0)?, text(1)?, text(2)?])
    };
    let graph: Vec<[String; 3]> = raw.chunks_exact((*size).max(1) as usize).filter_map(edge).collect();
    let follow = |source: &str, link: &str| graph.iter().find(|e| e[0] == source && e[1] == link).map(|e| &e[2]);
    follow(follow(follow("Root", "Measurement")?, "Surface")?, "Path").cloned()
}

/// Metres per stored height, if the file says so.
fn unit(surface: &Dataset) -> Option<f64> {
    let name = surface.attribute("Unit").ok()?.read_strings().ok()?.into_iter().next()?;
    if name.eq_ignore_ascii_case("fringes") {
        let factors = ["Wavelength", "Interferometric Scale Factor", "Obliquity Factor"];
        return factors.iter().try_fold(1.0, |product, factor| Some(product * number(surface, factor)?));
    }
    metres(&name)
}

fn number(surface: &Dataset, name: &str) -> Option<f64> {
    surface.attribute(name).ok()?.read_as_f64().ok()
}

/// Metres per pixel from a lateral converter: (category, base unit, parameters), the second parameter.
fn pixel_size(surface: &Dataset, converter: &str) -> Option<f64> {
    let Attribute { datatype: Datatype::Compound { fields, .. }, raw_data, .. } = surface.attribute(converter).ok()?
    else {
        return None;
    };
    let field = |name: &str| fields.iter().find(|f| f.name == name);
    let at = |offset: u32| raw_data.get(offset as usize..);
    let text = |name: &str| field(name).and_then(|f| text_of(surface, at(f.byte_offset)?, &f.datatype));
    if text("Category")? != "LateralCat" || text("BaseUnit")? != "Pixels" {
        return None;
    }
    let parameters = field("Parameters")?;
    let reference = at(parameters.byte_offset)?.get(..surface.vlen_reference_size())?;
    let values = surface.resolve_vlen_reference_bytes(reference, 8).ok()?;
    Sample::F64.decode_all(&values, false).get(1).copied()
}

/// A string member of a compound, stored in place or as a reference into the file's heap.
fn text_of(dataset: &Dataset, bytes: &[u8], datatype: &Datatype) -> Option<String> {
    use hdf5_reader::messages::datatype::StringSize;
    let content = match datatype {
        Datatype::String { size: StringSize::Fixed(n), .. } => bytes.get(..*n as usize)?.to_vec(),
        Datatype::String { size: StringSize::Variable, .. } | Datatype::VarLen { kind: VarLenKind::String, .. } => {
            dataset.resolve_vlen_reference_bytes(bytes.get(..dataset.vlen_reference_size())?, 1).ok()?
        }
        _ => return None,
    };
    Some(crate::heightmap::read::units::decode_text(&content))
}

fn broken(error: hdf5_reader::error::Error) -> Fault {
    corrupt(format!("the HDF5 structure cannot be read ({error})"))
}

fn corrupt(what: String) -> Fault {
    Fault::Corrupt { format: NAME, what }
}
