//! Readers, one file each, chosen by the first bytes of the file and never by its name.

mod al3d;
mod bcrf;
mod datx;
mod exr;
mod fields;
mod gwy;
mod metropro;
mod nms;
mod npy;
mod npz;
mod plu;
mod png;
mod sdf;
mod sur;
mod text;
mod tiff;
mod units;
mod wyko;
mod x3p;
mod zygo_text;

use super::RawMap;
use crate::error::{Error, Fault, Result};
use std::path::Path;

pub(crate) use png::{PITCH_KEYWORD as PNG_PITCH, RANGE_KEYWORD as PNG_RANGE};

/// What the user knows and the file may not say.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadOptions {
    /// Sampling distance along x and y \[m\], for formats that carry none.
    pub pitch: Option<[f64; 2]>,
    /// Metres per stored height, for formats that carry no unit.
    pub unit: Option<f64>,
    /// Which layer of a file with several, counted from 0; the first if not given.
    pub layer: Option<usize>,
    /// Heights \[m\] of the lowest and highest integer a picture can hold.
    pub height_range: Option<[f64; 2]>,
}

impl ReadOptions {
    /// The pitch the file states if it is usable, else the user's.
    ///
    /// The file wins because one `--pitch` may be given for a whole folder of maps.
    fn pitch_or(&self, format: &'static str, stated: Option<[f64; 2]>) -> std::result::Result<[f64; 2], Fault> {
        let usable = |p: &[f64; 2]| p.iter().all(|v| v.is_finite() && *v > 0.0);
        stated.filter(usable).or(self.pitch).ok_or_else(|| Fault::MetadataMissing {
            format,
            what: "the pitch".to_owned(),
            advice: "give the sampling distance, for example --pitch 0.5um".to_owned(),
        })
    }

    /// The user's metres per stored height.
    fn unit_or_missing(&self, format: &'static str) -> std::result::Result<f64, Fault> {
        self.unit.ok_or_else(|| Fault::MetadataMissing {
            format,
            what: "the unit of the heights".to_owned(),
            advice: "give it, for example --unit um".to_owned(),
        })
    }

    /// What an unsigned level up to `highest` means: a share of the height range, else so many units.
    fn height_of_level(
        &self,
        format: &'static str,
        highest: f64,
    ) -> std::result::Result<impl Fn(f64) -> f64 + use<>, Fault> {
        let [low, step] = match (self.height_range, self.unit) {
            (Some([low, high]), _) => [low, (high - low) / highest],
            (None, Some(unit)) => [0.0, unit],
            (None, None) => {
                return Err(Fault::MetadataMissing {
                    format,
                    what: "the range of the heights".to_owned(),
                    advice: "give the heights of black and white, for example --height-range 0um,2.5um".to_owned(),
                });
            }
        };
        Ok(move |level| low + level * step)
    }
}

type Reader = fn(&[u8], &ReadOptions) -> std::result::Result<RawMap, Fault>;

/// One format: a line in [`FORMATS`] and a file beside this one.
struct Format {
    name: &'static str,
    recognises: fn(&[u8]) -> bool,
    read: Reader,
    /// Only height maps look like this. Pictures, text and archives hold other things as well.
    heights_only: bool,
}

macro_rules! reader {
    ($module:ident, heights only) => {
        Format { name: $module::NAME, recognises: $module::recognises, read: $module::read, heights_only: true }
    };
    ($module:ident, anything) => {
        Format { name: $module::NAME, recognises: $module::recognises, read: $module::read, heights_only: false }
    };
}

/// Every format we read, most specific magic first.
const FORMATS: &[Format] = &[
    reader!(npz, anything),
    reader!(x3p, heights only),
    reader!(metropro, heights only),
    reader!(wyko, heights only),
    reader!(sur, heights only),
    reader!(sdf, heights only),
    reader!(al3d, heights only),
    reader!(gwy, heights only),
    reader!(bcrf, heights only),
    reader!(npy, heights only),
    reader!(plu, heights only),
    reader!(nms, heights only),
    reader!(datx, heights only),
    reader!(zygo_text, heights only),
    reader!(png, anything),
    reader!(tiff, anything),
    reader!(exr, anything),
    reader!(text, anything),
];

/// Names of the formats that can be read.
pub fn format_names() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().map(|f| f.name)
}

/// Reads a height map, recognised by its content.
///
/// # Errors
/// `Error::Io`, `Error::File` (unknown, unsupported, corrupt, metadata missing) or `Error::Content`
/// (fewer than 2 x 2 points, all missing), each naming the file.
pub fn read(path: &Path, options: &ReadOptions) -> Result<RawMap> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
    let map = read_bytes(&bytes, options).map_err(|fault| match fault {
        Fault::NotThisFormat(_) if bytes.is_empty() => {
            Error::content(path, "the file is empty", "copy or export it again")
        }
        Fault::NotThisFormat(_) => {
            let known: Vec<_> = format_names().collect();
            Error::content(
                path,
                "the content is of no known height-map format",
                format!("export it as one of: {}", known.join(", ")),
            )
        }
        fault => Error::File { path: path.to_owned(), fault },
    })?;
    map.check().map_err(|e| match e {
        Error::Parameter { what, advice } => Error::content(path, what, advice),
        other => other,
    })?;
    Ok(map)
}

/// Reads a height map from memory. The result is not yet checked by [`RawMap::check`].
///
/// Takes at most 100 bytes of memory for a byte of an uncompressed file, whatever that announces (triples with gaps are
/// the dearest), and 32 for every byte that a compressed one may unpack to: see [`crate::archive::unpack_limit`].
///
/// # Errors
/// The fault of the reader whose magic fits; `Fault::NotThisFormat` if none does.
pub fn read_bytes(bytes: &[u8], options: &ReadOptions) -> std::result::Result<RawMap, Fault> {
    let format = FORMATS.iter().find(|f| (f.recognises)(bytes)).ok_or(Fault::NotThisFormat("height-map"))?;
    let mut map = (format.read)(bytes, options)?;
    // A stored number and the unit may each be fine and their product beyond every float.
    map.heights.iter_mut().filter(|h| h.is_infinite()).for_each(|h| *h = f64::NAN);
    Ok(map)
}

/// As many first bytes as any format needs to be recognised.
pub const RECOGNITION_BYTES: usize = 4096;

/// Whether a file that begins with `first_bytes` (at least [`RECOGNITION_BYTES`], if it has as many) is a height map.
///
/// Used to pick the maps out of a folder. Pictures, text and `.npz` archives may be anything: name them one by one.
pub fn is_recognised(first_bytes: &[u8]) -> bool {
    FORMATS.iter().find(|f| (f.recognises)(first_bytes)).is_some_and(|f| f.heights_only)
}

/// Extensions that announce a height map; only used to decide whether an unreadable file in a folder is worth an error.
const EXTENSIONS: [&str; 15] =
    ["x3p", "dat", "datx", "opd", "npy", "sdf", "sur", "gwy", "al3d", "plu", "nms", "bcrf", "bcr", "asc", "xyz"];

/// Whether a file in a folder of maps is one, or claims to be one by its name.
pub fn is_candidate(path: &Path) -> bool {
    use std::io::Read;
    let claims = path.extension().is_some_and(|e| EXTENSIONS.iter().any(|x| e.eq_ignore_ascii_case(x)));
    let mut first = Vec::new();
    let start = std::fs::File::open(path).and_then(|f| f.take(RECOGNITION_BYTES as u64).read_to_end(&mut first));
    claims || (start.is_ok() && is_recognised(&first))
}
