//! The keys of a scene file.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    pub length_unit: Option<Spanned<String>>,
    pub camera: Spanned<Camera>,
    pub image: Option<Spanned<Image>>,
    pub sky: Option<Spanned<Sky>>,
    #[serde(default)]
    pub materials: BTreeMap<String, Spanned<Material>>,
    #[serde(default)]
    pub shapes: Vec<Spanned<Shape>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub kind: CameraKind,
    pub position: [f64; 3],
    pub look_at: [f64; 3],
    #[serde(default = "z")]
    pub up: [f64; 3],
    pub field_of_view_deg: Option<f64>,
    pub height: Option<f64>,
}

fn z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

#[derive(Deserialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum CameraKind {
    Perspective,
    Orthographic,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub struct Image {
    pub width: Option<usize>,
    pub height: Option<usize>,
    pub samples: Option<u32>,
    pub error_percent: Option<f64>,
    pub depth: Option<u32>,
    pub seed: Option<u64>,
    pub exposure: Option<f64>,
    pub estimator: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sky {
    pub radiance: Option<Colour>,
    pub environment: Option<String>,
    pub scale: Option<f64>,
    #[serde(default)]
    pub turn_deg: f64,
}

/// Three linear sRGB channels, or one number for all.
#[derive(Deserialize, Clone, Copy)]
#[serde(untagged, expecting = "expected a number or [r, g, b]")]
pub enum Colour {
    Grey(f64),
    Rgb([f64; 3]),
}

impl Colour {
    pub fn rgb(self) -> [f64; 3] {
        match self {
            Colour::Grey(x) => [x; 3],
            Colour::Rgb(rgb) => rgb,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    pub source: Option<String>,
    pub rgb: Option<Colour>,
    pub checker: Option<Checker>,
    pub metallic: Option<Metallic>,
    pub coat: Option<String>,
    pub tint: Option<Colour>,
    pub wavelength_nm: Option<f64>,
    pub method: Option<String>,
    pub surface: Option<String>,
    #[serde(default)]
    pub flags: Vec<String>,
}

/// Tristimulus values at three angles from the mirror direction.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metallic {
    pub xyz_15: [f64; 3],
    pub xyz_45: [f64; 3],
    pub xyz_110: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checker {
    pub a: Cell,
    pub b: Cell,
    pub size: f64,
}

/// What a cell of a checker is made of.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the name of a material, a number or [r, g, b]")]
pub enum Cell {
    Name(String),
    Colour(Colour),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    pub kind: Kind,
    pub material: Option<String>,
    pub radiance: Option<Colour>,
    pub power: Option<Colour>,
    pub transform: Option<Transform>,
    pub centre: Option<[f64; 3]>,
    pub radius: Option<f64>,
    pub inner_radius: Option<f64>,
    pub normal: Option<[f64; 3]>,
    pub corner: Option<[f64; 3]>,
    pub edge_u: Option<[f64; 3]>,
    pub edge_v: Option<[f64; 3]>,
    pub file: Option<String>,
    pub profile: Option<Vec<[f64; 2]>>,
    pub smooth: Option<bool>,
}

#[derive(Deserialize, Clone, Copy, PartialEq, Eq, Debug)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    Sphere,
    Quad,
    Disc,
    Mesh,
    Revolution,
}

impl Kind {
    /// As written in the file.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Sphere => "sphere",
            Kind::Quad => "quad",
            Kind::Disc => "disc",
            Kind::Mesh => "mesh",
            Kind::Revolution => "revolution",
        }
    }

    /// Keys that only some shapes have.
    pub fn keys(self) -> &'static [&'static str] {
        match self {
            Kind::Sphere => &["centre", "radius"],
            Kind::Quad => &["corner", "edge_u", "edge_v"],
            Kind::Disc => &["centre", "radius", "inner_radius", "normal"],
            Kind::Mesh => &["file", "smooth"],
            Kind::Revolution => &["profile", "smooth"],
        }
    }
}

impl Shape {
    /// Keys that are set among those that only some shapes have.
    pub fn set(&self) -> Vec<&'static str> {
        [
            ("centre", self.centre.is_some()),
            ("radius", self.radius.is_some()),
            ("inner_radius", self.inner_radius.is_some()),
            ("normal", self.normal.is_some()),
            ("corner", self.corner.is_some()),
            ("edge_u", self.edge_u.is_some()),
            ("edge_v", self.edge_v.is_some()),
            ("file", self.file.is_some()),
            ("profile", self.profile.is_some()),
            ("smooth", self.smooth.is_some()),
        ]
        .into_iter()
        .filter_map(|(key, set)| set.then_some(key))
        .collect()
    }
}

#[derive(Deserialize, Default, Clone, Copy)]
#[serde(deny_unknown_fields, default)]
pub struct Transform {
    pub scale: Option<f64>,
    pub rotate_deg: [f64; 3],
    pub translate: [f64; 3],
}
