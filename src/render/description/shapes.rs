//! The shapes of a scene file, built and placed.

use super::Place;
use super::materials::{mend, said};
use super::schema::{Kind, Shape, Transform};
use crate::error::Result;
use crate::render::shape;
use crate::render::{Disc, Mesh, Quad, Sphere, revolution};
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::PI;
use std::ops::Range;

/// A shape in metres, and its area that shines [m2].
pub struct Built {
    pub shape: shape::Shape,
    pub area: f64,
    /// Triangles of a mesh that have no area.
    pub dropped: usize,
}

/// Builds the shape of the table at `span`; `unit` is the length of one unit \[m\].
pub fn build(s: &Shape, span: &Range<usize>, unit: f64, place: &Place) -> Result<Built> {
    let who = s.kind.name();
    if let Some(key) = s.set().into_iter().find(|key| !s.kind.keys().contains(key)) {
        let advice = format!("a {who} has {}, and material, radiance, power, transform", s.kind.keys().join(", "));
        return Err(place.error_in(span, key, format!("key `{key}` does not belong to a {who}"), advice));
    }
    let missing = |key: &str| {
        place.error_in(
            span,
            "kind",
            format!("the {who} has no `{key}`"),
            format!("a {who} has {}", s.kind.keys().join(", ")),
        )
    };
    let transform = transform(s.transform.unwrap_or_default(), unit);
    let scale = s.transform.unwrap_or_default().scale.unwrap_or(1.0);
    if !(scale > 0.0 && scale.is_finite() && transform.is_finite()) {
        let what = format!("key `transform`: a {who} scaled by {scale} or moved without end has no place");
        return Err(place.error_in(span, "transform", what, "give a scale above 0 and finite numbers"));
    }
    let point = |key: &str, value: Option<[f64; 3]>| {
        value.map(|p| transform.transform_point3(unit * DVec3::from(p))).ok_or_else(|| missing(key))
    };
    let vector = |key: &str, value: Option<[f64; 3]>| {
        value.map(|p| transform.transform_vector3(unit * DVec3::from(p))).ok_or_else(|| missing(key))
    };
    let length = |key: &str, value: Option<f64>| value.map(|x| scale * unit * x).ok_or_else(|| missing(key));
    // The key that decides whether there is a surface at all.
    let at = |key: &'static str| {
        move |e: crate::error::Error| place.error_in(span, key, format!("key `{key}`: {}", said(&e)), mend(&e))
    };
    let mut dropped = 0;
    let (shape, area): (shape::Shape, f64) = match s.kind {
        Kind::Sphere => {
            let sphere = Sphere::new(point("centre", s.centre)?, length("radius", s.radius)?).map_err(at("radius"))?;
            (sphere.into(), 4.0 * PI * sphere.radius.powi(2))
        }
        Kind::Quad => {
            let edges = [vector("edge_u", s.edge_u)?, vector("edge_v", s.edge_v)?];
            let quad = Quad::new(point("corner", s.corner)?, edges[0], edges[1]).map_err(at("edge_v"))?;
            (quad.into(), quad.area())
        }
        Kind::Disc => {
            let inner = s.inner_radius.map_or(0.0, |r| scale * unit * r);
            let (centre, normal) = (point("centre", s.centre)?, vector("normal", s.normal)?);
            let disc = Disc::new(centre, normal, length("radius", s.radius)?, inner).map_err(at("radius"))?;
            (disc.into(), disc.area())
        }
        Kind::Mesh => {
            let file = s.file.as_ref().ok_or_else(|| missing("file"))?;
            let mesh = Mesh::load(&place.beside(file), unit, s.smooth).map_err(at("file"))?;
            let mesh = mesh.transformed(&transform).map_err(at("transform"))?;
            dropped = mesh.dropped();
            let area = mesh.area();
            (mesh.into(), area)
        }
        Kind::Revolution => {
            let profile = s.profile.as_ref().ok_or_else(|| missing("profile"))?;
            let profile: Vec<[f64; 2]> = profile.iter().map(|p| p.map(|x| unit * x)).collect();
            let mesh = revolution(&profile, s.smooth.unwrap_or(false)).map_err(at("profile"))?;
            let mesh = mesh.transformed(&transform).map_err(at("transform"))?;
            let area = mesh.area();
            (mesh.into(), area)
        }
    };
    Ok(Built { shape, area, dropped })
}

/// Scale, then turns about x, y and z, then the move.
fn transform(t: Transform, unit: f64) -> DAffine3 {
    let [x, y, z] = t.rotate_deg.map(f64::to_radians);
    let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
    DAffine3::from_mat3_translation(turn * t.scale.unwrap_or(1.0), unit * DVec3::from(t.translate))
}
