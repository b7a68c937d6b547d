//! From the tables of a scene file to a scene, a camera and the options of the picture.

use super::Description;
use super::materials::{Materials, mend, said};
use super::schema::{Camera as CameraTable, CameraKind, Shape};
use super::shapes;
use crate::error::{Error, Result};
use crate::math::quantity;
use crate::render::{Camera, Environment, Estimator, Film, Paint, RenderOptions, Scene};
use glam::DVec3;
use std::ops::Range;

/// What a scene file says about the picture; `None` where it says nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Picturing {
    pub width: Option<usize>,
    pub height: Option<usize>,
    pub samples: Option<u32>,
    /// Share of a block's radiance at which it stops.
    pub error: Option<f64>,
    /// Straight pieces of the longest path.
    pub depth: Option<u32>,
    pub seed: Option<u64>,
    /// \[m2 sr/W\]
    pub exposure: Option<f64>,
    pub estimator: Option<Estimator>,
}

/// A scene file, built.
pub struct Described<'m> {
    pub scene: Scene<'m>,
    pub notes: Vec<String>,
}

impl Picturing {
    /// The options of the renderer, defaults where nothing was said.
    pub fn options(&self) -> RenderOptions {
        let default = RenderOptions::default();
        RenderOptions {
            width: self.width.unwrap_or(default.width),
            height: self.height.unwrap_or(default.height),
            samples_per_pixel: self.samples.unwrap_or(default.samples_per_pixel),
            seed: self.seed.unwrap_or(default.seed),
            max_reflections: self.depth.map_or(default.max_reflections, |d| d - 1),
            estimator: self.estimator.unwrap_or(default.estimator),
            error: self.error,
        }
    }
}

impl Description {
    /// Metres per unit of length.
    pub(super) fn unit(&self) -> Result<f64> {
        let Some(unit) = &self.file.length_unit else { return Ok(1.0) };
        quantity::length_unit(unit.get_ref()).map_err(|advice| {
            self.place.error_at(
                unit.span().start,
                format!("key `length_unit`: `{}` is no unit", unit.get_ref()),
                advice,
            )
        })
    }

    /// What the file says about the picture.
    ///
    /// # Errors
    /// `Error::Content` naming line and key of a number that cannot be.
    pub fn picturing(&self) -> Result<Picturing> {
        let Some(table) = &self.file.image else { return Ok(Picturing::default()) };
        let (image, span) = (table.get_ref(), table.span());
        let bad = |key: &str, what: String, advice: &str| {
            Err(self.place.error_in(&span, key, format!("key `{key}`: {what}"), advice))
        };
        for (key, value) in [("width", image.width), ("height", image.height)] {
            if value.is_some_and(|v| !(1..=65536).contains(&v)) {
                return bad(key, "a side is from 1 to 65536 pixels".into(), "try 640");
            }
        }
        if image.samples == Some(0) {
            return bad("samples", "a picture needs at least one sample per pixel".into(), "try 256");
        }
        if image.depth == Some(0) {
            return bad("depth", "a path has at least one piece".into(), "1 shows lamps only, 2 direct light; try 9");
        }
        if image.error_percent.is_some_and(|e| !(e > 0.0 && e < 100.0)) {
            return bad("error_percent", "an error is above 0 and below 100 %".into(), "try 2");
        }
        if image.exposure.is_some_and(|e| !(e > 0.0 && e.is_finite())) {
            return bad("exposure", "an exposure is above 0".into(), "leave it out to have it chosen");
        }
        let estimator = match image.estimator.as_deref().map(Estimator::parse).transpose() {
            Ok(estimator) => estimator,
            Err(e) => return bad("estimator", said(&e), &mend(&e)),
        };
        Ok(Picturing {
            width: image.width,
            height: image.height,
            samples: image.samples,
            error: image.error_percent.map(|e| e / 100.0),
            depth: image.depth,
            seed: image.seed,
            exposure: image.exposure,
            estimator,
        })
    }

    /// The camera for a picture of the given width over height.
    ///
    /// # Errors
    /// `Error::Content` naming the line if the view is not defined.
    pub fn camera(&self, aspect: f64) -> Result<Camera> {
        let unit = self.unit()?;
        let (c, span): (&CameraTable, Range<usize>) = (self.file.camera.get_ref(), self.file.camera.span());
        let bad = |key: &str, what: &str, advice: &str| {
            Err(self.place.error_in(&span, key, format!("[camera]: {what}"), advice))
        };
        let (eye, target) = (unit * DVec3::from(c.position), unit * DVec3::from(c.look_at));
        let built = match (c.kind, c.field_of_view_deg, c.height) {
            (CameraKind::Perspective, Some(field), None) => {
                Camera::perspective(eye, target, c.up.into(), field.to_radians(), aspect)
            }
            (CameraKind::Orthographic, None, Some(height)) => {
                Camera::orthographic(eye, target, c.up.into(), unit * height, aspect)
            }
            (CameraKind::Perspective, ..) => {
                return bad(
                    "height",
                    "a perspective camera has `field_of_view_deg` and no `height`",
                    "try field_of_view_deg = 30",
                );
            }
            (CameraKind::Orthographic, ..) => {
                return bad(
                    "field_of_view_deg",
                    "an orthographic camera has `height` and no `field_of_view_deg`",
                    "give the height in length_unit",
                );
            }
        };
        built.map_err(|e| self.place.error_in(&span, "position", format!("[camera]: {}", said(&e)), mend(&e)))
    }

    /// The shapes, lamps and the sky.
    ///
    /// # Errors
    /// `Error::Content` naming the line and key of what cannot be.
    pub fn build<'m>(&self, materials: &'m Materials) -> Result<Described<'m>> {
        let unit = self.unit()?;
        let mut scene = self.sky()?;
        let mut notes = Vec::new();
        for table in &self.file.shapes {
            let (s, span) = (table.get_ref(), table.span());
            let built = shapes::build(s, &span, unit, &self.place)?;
            if built.dropped > 0 {
                let line = self.place.line(span.start);
                notes.push(format!(
                    "line {line}: {} triangles of the mesh have no area and are left out",
                    built.dropped
                ));
            }
            match (&s.material, s.radiance, s.power) {
                (Some(name), None, None) => {
                    let cover = materials.cover(name).map_err(|advice| {
                        self.place.error_in(
                            &span,
                            "material",
                            format!("key `material`: there is no material `{name}`"),
                            advice,
                        )
                    })?;
                    scene.add(built.shape, cover);
                }
                (None, Some(_), None) | (None, None, Some(_)) => {
                    let (key, radiance) = lamp(s, built.area);
                    let add = Paint::plain(radiance).and_then(|paint| scene.add_emitter(built.shape, paint));
                    add.map_err(|e| self.place.error_in(&span, key, format!("key `{key}`: {}", said(&e)), mend(&e)))?;
                }
                (None, None, None) => {
                    let what = format!("the {} has neither a material nor a radiance", s.kind.name());
                    return Err(self.place.error_in(
                        &span,
                        "kind",
                        what,
                        "add material = \"NAME\", or radiance or power",
                    ));
                }
                _ => {
                    let what = format!("the {} has more than one of `material`, `radiance` and `power`", s.kind.name());
                    return Err(self.place.error_in(&span, "kind", what, "a lamp is black: keep one of them"));
                }
            }
        }
        if self.file.shapes.is_empty() {
            notes.push("the scene has no [[shapes]]: the picture shows the sky".to_owned());
        }
        Ok(Described { scene, notes })
    }

    /// An empty scene under the sky of the file.
    fn sky(&self) -> Result<Scene<'static>> {
        let Some(table) = &self.file.sky else { return Scene::new(DVec3::ZERO) };
        let (sky, span) = (table.get_ref(), table.span());
        let wrap =
            |key: &str, e: &Error| self.place.error_in(&span, key, format!("[sky]: key `{key}`: {}", said(e)), mend(e));
        let radiance = sky.radiance.map_or([0.0; 3], |c| c.rgb());
        let mut scene = Scene::new(radiance.into()).map_err(|e| wrap("radiance", &e))?;
        match &sky.environment {
            Some(file) => {
                let (film, _) = Film::load_exr(&self.place.beside(file)).map_err(|e| wrap("environment", &e))?;
                let environment = Environment::new(&film, sky.scale.unwrap_or(1.0), sky.turn_deg.to_radians());
                scene.surround(environment.map_err(|e| wrap("environment", &e))?);
            }
            None if sky.scale.is_some() || sky.turn_deg != 0.0 => {
                let what = "[sky]: `scale` and `turn_deg` are for an environment";
                return Err(self.place.error_in(
                    &span,
                    "scale",
                    what,
                    "add environment = \"FILE.exr\" or leave them out",
                ));
            }
            None => {}
        }
        Ok(scene)
    }
}

/// The key that makes the shape a lamp, and its radiance: `Phi / (pi A)` of a power.
fn lamp(s: &Shape, area: f64) -> (&'static str, DVec3) {
    match (s.radiance, s.power) {
        (Some(radiance), _) => ("radiance", radiance.rgb().into()),
        (None, power) => {
            let power: DVec3 = power.map_or([0.0; 3], |p| p.rgb()).into();
            ("power", power / (std::f64::consts::PI * area))
        }
    }
}
