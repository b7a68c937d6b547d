//! Flags that say how to read and prepare a height map.

use super::quantity;
use super::source::file_name;
use crate::error::{Error, Result};
use crate::heightmap::crop::Region;
use crate::heightmap::despike::Despike;
use crate::heightmap::fill::Fill;
use crate::heightmap::form::Form;
use crate::heightmap::orient::{Orientation, Rotation};
use crate::heightmap::prepare::Report;
use crate::heightmap::read::{ReadOptions, read};
use crate::heightmap::warning::Warning;
use crate::heightmap::{Edges, Preparation, Prepared, RawMap, prepare};
use crate::table::Table;
use clap::{Args, ValueEnum};
use std::io::Read;
use std::path::Path;

/// What the user knows and the file may not say.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Reading the map")]
pub struct Reading {
    /// Sampling distance for files that carry none: 0.5um, or X,Y
    #[arg(long, value_parser = quantity::pitch, value_name = "LENGTH")]
    pitch: Option<[f64; 2]>,
    /// Unit of the heights for files that carry none: m, mm, um, nm
    #[arg(long, value_parser = quantity::length_unit)]
    unit: Option<f64>,
    /// Layer of a file with several, from 0
    #[arg(long)]
    layer: Option<usize>,
    /// Heights of black and white in a picture of integers: LOW,HIGH
    #[arg(long, value_parser = quantity::height_range, value_name = "LOW,HIGH", allow_hyphen_values = true)]
    height_range: Option<[f64; 2]>,
}

impl Reading {
    /// The readers' options.
    pub fn options(&self) -> ReadOptions {
        let Reading { pitch, unit, layer, height_range } = *self;
        ReadOptions { pitch, unit, layer, height_range }
    }
}

#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Reading the map")]
pub struct MapOptions {
    #[command(flatten)]
    reading: Reading,
    /// What lies beyond the border; periodic only for maps made so
    #[arg(long, value_enum, default_value_t = EdgesFlag::Open)]
    edges: EdgesFlag,
    #[command(flatten)]
    preparing: Preparing,
}

/// Above these flags in the help; the order is theirs.
const HEADING: &str = "Preparing the map, in this order";

/// The order in which these act is fixed: see [`prepare()`].
#[derive(Args, Clone, Debug)]
struct Preparing {
    /// Exchange left and right
    #[arg(long, help_heading = HEADING)]
    mirror_x: bool,
    /// Exchange top and bottom
    #[arg(long, help_heading = HEADING)]
    mirror_y: bool,
    /// Turn counter-clockwise by so many degrees, after mirroring
    #[arg(long, help_heading = HEADING, value_enum, value_name = "DEG")]
    rotate: Option<RotateFlag>,
    /// Make hills of valleys
    #[arg(long, help_heading = HEADING)]
    invert: bool,
    /// Keep a part: X0,Y0,X1,Y1 from the top left, as fractions or as lengths such as 0,0,50um,50um
    #[arg(long, help_heading = HEADING, value_parser = quantity::region, value_name = "REGION", allow_hyphen_values = true)]
    region: Option<Region>,
    /// Mark spikes beyond so many median absolute deviations as missing, 6 is usual; K,N for a window of N x N points
    #[arg(long, help_heading = HEADING, value_parser = quantity::despike, value_name = "K[,N]")]
    despike: Option<Despike>,
    /// Form to remove: plane, poly:N of total degree N, sphere, none [default: plane]
    #[arg(long, help_heading = HEADING, value_parser = quantity::form)]
    form: Option<Form>,
    /// Keep the tilt: the same as --form none
    #[arg(long, help_heading = HEADING, conflicts_with = "form")]
    keep_tilt: bool,
    /// Fill missing points smoothly, up to this share of the map, such as 5% or 0.05 [default: 5% if no share is given; before a
    /// file name write --fill=5%]
    #[arg(long, help_heading = HEADING, value_parser = quantity::share, value_name = "SHARE", num_args = 0..=1, default_missing_value = "5%")]
    fill: Option<f64>,
    /// Leave holes of more points than this open
    #[arg(long, help_heading = HEADING, value_name = "POINTS", requires = "fill")]
    fill_hole: Option<usize>,
    /// Remove waves shorter than this (Gaussian filter, ISO 16610-61)
    #[arg(long, help_heading = HEADING, value_parser = quantity::length, value_name = "CUT-OFF")]
    s_filter: Option<f64>,
    /// Remove waves longer than this (Gaussian filter, ISO 16610-61)
    #[arg(long, help_heading = HEADING, value_parser = quantity::length, value_name = "CUT-OFF")]
    l_filter: Option<f64>,
    /// Known height noise of the instrument (standard deviation): reports the slopes without it
    #[arg(long, help_heading = HEADING, value_parser = quantity::length, value_name = "LENGTH")]
    noise: Option<f64>,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum EdgesFlag {
    Open,
    Mirrored,
    Periodic,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum RotateFlag {
    #[value(name = "90")]
    By90,
    #[value(name = "180")]
    By180,
    #[value(name = "270")]
    By270,
}

/// Reads a map as it was measured.
///
/// # Errors
/// Those of [`read`], and `Error::Content` for a table, whose file a map may look like.
pub fn read_map(path: &Path, options: &ReadOptions) -> Result<RawMap> {
    let zipped = || {
        let mut first = [0; 2];
        std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut first)).is_ok_and(|()| first == *b"PK")
    };
    if zipped() && std::fs::read(path).is_ok_and(|bytes| Table::recognises(&bytes)) {
        return Err(Error::content(
            path,
            "this is a BRDF table, not a height map",
            "give it to gloss, scan, eval, sample, check, lobe, fit, tiles or render, or give the map that it was made of",
        ));
    }
    read(path, options)
}

impl MapOptions {
    /// Reads and prepares one map; its report is for [`print_report`] once no progress bar is in the way.
    pub fn load(&self, path: &Path) -> Result<Prepared> {
        let options = self.reading.options();
        let raw = read_map(path, &options)?;
        let stated = [raw.pitch_x, raw.pitch_y];
        let mut prepared = prepare(raw, &self.preparation()).map_err(|e| match e {
            Error::Parameter { what, advice } => Error::content(path, what, advice),
            other => other,
        })?;
        if let Some(given) = options.pitch.filter(|given| *given != stated) {
            prepared.report.warnings.insert(0, Warning::PitchOfFile { stated, given });
        }
        Ok(prepared)
    }

    fn preparation(&self) -> Preparation {
        let p = &self.preparing;
        Preparation {
            edges: match self.edges {
                EdgesFlag::Open => Edges::Open,
                EdgesFlag::Mirrored => Edges::Mirrored,
                EdgesFlag::Periodic => Edges::Periodic,
            },
            orientation: Orientation {
                mirror_x: p.mirror_x,
                mirror_y: p.mirror_y,
                rotation: match p.rotate {
                    None => Rotation::None,
                    Some(RotateFlag::By90) => Rotation::By90,
                    Some(RotateFlag::By180) => Rotation::By180,
                    Some(RotateFlag::By270) => Rotation::By270,
                },
                invert: p.invert,
            },
            region: p.region,
            despike: p.despike,
            form: if p.keep_tilt { Form::None } else { p.form.unwrap_or_default() },
            fill: p.fill.map(|limit| Fill { limit, largest_hole: p.fill_hole }),
            s_filter: p.s_filter,
            l_filter: p.l_filter,
            noise: p.noise,
        }
    }
}

/// One line on stderr with what was done to the map, and one for each warning.
pub fn print_report(path: &Path, report: &Report) {
    let name = file_name(path);
    eprintln!("{name}: {report}");
    for warning in &report.warnings {
        eprintln!("warning: {name}: {warning}");
    }
}
