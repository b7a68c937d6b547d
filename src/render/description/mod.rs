//! A scene as a TOML file: one page of reference.
//!
//! ```toml
//! length_unit = "mm"              # of every length in the file: m, mm, um, nm; left out: m
//!
//! [camera]
//! kind = "perspective"            # or "orthographic"
//! position = [0, -700, 400]
//! look_at = [0, 0, 0]
//! up = [0, 0, 1]                  # left out: z
//! field_of_view_deg = 12          # full vertical angle of a perspective camera
//! # height = 200                  # what an orthographic camera shows from bottom to top, a length
//!
//! [image]                         # every key may be left out; flags of the command win
//! width = 640                     # pixels
//! height = 480
//! samples = 256                   # paths per pixel, or the most of them with error_percent
//! error_percent = 2.0             # a block of pixels stops when its estimated error is this share of its radiance
//! depth = 9                       # longest path in straight pieces: 1 shows lamps only, 2 direct light, 3 one reflection of it
//! seed = 1
//! exposure = 0.1                  # display = sRGB(exposure x radiance) [m2 sr/W]; left out: chosen from the picture
//! estimator = "mis"               # mis, brdf, lights, uniform, direct
//!
//! [sky]                           # left out: black
//! radiance = 0.2                  # W/(m2 sr), a number or [r, g, b]
//! # environment = "sky.exr"       # or a picture by longitude and latitude, z up, its middle towards +x, W/(m2 sr)
//! # scale = 1.0                   # factor on the picture
//! # turn_deg = 90                 # turns it about z, counterclockwise seen from above
//!
//! [materials.tile]                # what reflects: exactly one of source, rgb, checker
//! source = "ward:rho_s=0.045,alpha=0.02"  # height map, table, foreign file, model, material:NAME
//! tint = [1, 0.9, 0.8]            # factor on it, 0 to 1; left out: 1
//! wavelength_nm = 550             # left out: 550 for maps, the whole visible spectrum for models that depend on it
//! method = "kirchhoff"            # how a height map scatters; left out: as the command says
//! surface = "n=1.5"               # what a height map is made of; left out: as the command says
//!
//! [materials.wall]
//! rgb = [0.8, 0.7, 0.6]           # matt (Lambert), reflectance of the three linear sRGB channels; also a number
//!
//! [materials.floor]
//! checker = { a = "wall", b = 0.1, size = 50 }   # of two materials, by name or colour; side of a cell
//!
//! [[shapes]]
//! kind = "sphere"                 # centre, radius
//! centre = [0, 0, 30]
//! radius = 30
//! material = "tile"
//! transform = { scale = 1.0, rotate_deg = [0, 0, 45], translate = [0, 0, 0] }   # in this order; about x, then y, then z
//!
//! [[shapes]]
//! kind = "quad"                   # a parallelogram; its front looks along edge_u x edge_v
//! corner = [-500, -500, 0]
//! edge_u = [1000, 0, 0]
//! edge_v = [0, 1000, 0]
//! material = "floor"
//!
//! [[shapes]]
//! kind = "disc"                   # centre, normal (its front), radius, inner_radius (left out: 0)
//! centre = [0, 0, 500]
//! normal = [0, 0, -1]
//! radius = 50
//! radiance = 40                   # a lamp: W/(m2 sr), a number or [r, g, b]
//! # power = 2.0                   # or what it sends out in all [W], a number or [r, g, b]
//!
//! [[shapes]]
//! kind = "mesh"                   # triangles from .ply or .obj, lengths in length_unit
//! file = "bunny.ply"              # beside the scene
//! smooth = true                   # normals interpolated between vertices; left out: true if the file has normals
//! material = "tile"
//!
//! [[shapes]]
//! kind = "revolution"             # a profile [r, z] turned about z, front to the left of its direction: outside if it rises
//! profile = [[0, 0], [30, 0], [20, 40], [25, 60]]
//! smooth = true                   # a curve through the points instead of straight pieces (Catmull-Rom)
//! material = "tile"
//! ```
//!
//! A lamp is black and shines from its front only: spheres outwards. A shape has a material or is a lamp. The frame of a
//! material: z is the normal on the side that is seen; x runs along `edge_u` of a quad, along the parallels of latitude of
//! spheres and bodies of revolution, along an axis of discs. A checker counts cells from the corner of a quad in its plane;
//! on other shapes it is solid.
//!
//! Nothing refracts: shapes are opaque, and both sides of a surface reflect alike.

mod build;
mod materials;
mod schema;
mod shapes;

pub use build::{Described, Picturing};
pub use materials::{Materials, Wanted};

use crate::error::{Error, Result};
use schema::File;
use std::path::{Path, PathBuf};

/// A scene file that was read but not yet built.
pub struct Description {
    file: File,
    place: Place,
}

/// Where the text came from: what errors name.
pub(super) struct Place {
    /// The scene file; files in it are looked for beside it.
    path: PathBuf,
    text: String,
}

impl Description {
    /// Reads a scene file.
    ///
    /// # Errors
    /// `Error::Io` naming the file, or as [`Description::parse`].
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::parse(&text, path)
    }

    /// Reads a scene from text; `path` is named in errors, and other files are looked for beside it.
    ///
    /// # Errors
    /// `Error::Content` naming `path`, the line and the key.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let place = Place { path: path.to_owned(), text: text.to_owned() };
        let file: File = toml::from_str(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            place.error_at(
                at,
                e.message().replace('\n', " "),
                "`asperity render --help` shows where scenes are explained",
            )
        })?;
        Ok(Description { file, place })
    }
}

impl Place {
    /// Line number of a byte of the text, from 1.
    fn line(&self, byte: usize) -> usize {
        self.text.get(..byte).map_or(1, |before| before.matches('\n').count() + 1)
    }

    /// An error at a byte of the text.
    fn error_at(&self, byte: usize, what: impl std::fmt::Display, advice: impl Into<String>) -> Error {
        Error::content(&self.path, format!("line {}: {what}", self.line(byte)), advice)
    }

    /// An error about a key of the table that fills the bytes `table`: at the line of the key, if it is there.
    fn error_in(
        &self,
        table: &std::ops::Range<usize>,
        key: &str,
        what: impl std::fmt::Display,
        advice: impl Into<String>,
    ) -> Error {
        self.error_at(self.key(table, key), what, advice)
    }

    /// First byte of the line that sets `key` in the table that starts with the bytes `table`.
    fn key(&self, table: &std::ops::Range<usize>, key: &str) -> usize {
        let mut at = table.start;
        for (number, line) in self.text.get(table.start..).unwrap_or("").split_inclusive('\n').enumerate() {
            let trimmed = line.trim_start();
            if number > 0 && trimmed.starts_with('[') {
                break;
            }
            if trimmed.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('=')) {
                return at;
            }
            at += line.len();
        }
        table.start
    }

    /// A file that the scene names.
    fn beside(&self, name: &str) -> PathBuf {
        self.path.parent().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
    }
}
