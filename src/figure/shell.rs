//! Meshes from closed formulas: a car-like shell and the sweep of a photographer's backdrop.

use crate::error::Result;
use crate::render::Mesh;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// A surface `at(u, v)`, `u` and `v` from 0 to 1, as a smooth mesh of `n[0] x n[1]` cells of two triangles. Normals are
/// those of the formula, by central differences.
fn surface(n: [usize; 2], at: &dyn Fn(f64, f64) -> DVec3) -> Result<Mesh> {
    let (mut vertices, mut normals) = (Vec::new(), Vec::new());
    for j in 0..=n[1] {
        for i in 0..=n[0] {
            let (u, v) = (i as f64 / n[0] as f64, j as f64 / n[1] as f64);
            vertices.push(at(u, v));
            // At a pole one direction shrinks to a point: the normal is taken beside it.
            let (u, v) = (u.clamp(2.0 * STEP, 1.0 - 2.0 * STEP), v.clamp(2.0 * STEP, 1.0 - 2.0 * STEP));
            let along = at(u + STEP, v) - at(u - STEP, v);
            let across = at(u, v + STEP) - at(u, v - STEP);
            normals.push(along.cross(across).normalize_or(DVec3::Z));
        }
    }
    let row = n[0] as u32 + 1;
    let cells = (0..n[1] as u32).flat_map(|j| (0..n[0] as u32).map(move |i| j * row + i));
    let triangles = cells.flat_map(|k| [[k, k + 1, k + row + 1], [k, k + row + 1, k + row]]).collect();
    Mesh::new(vertices, Some(normals), triangles)
}

const STEP: f64 = 1e-4;

/// Floor z = 0 that bends up into a wall at `y = depth` \[m\].
pub fn backdrop(depth: f64) -> Result<Mesh> {
    // Floor, a quarter of a circle, wall.
    let (radius, near, top, half) = (0.7, -4.0, 4.0, 6.0);
    let floor = depth - radius - near;
    let arc = FRAC_PI_2 * radius;
    let total = floor + arc + top - radius;
    surface([2, 400], &|u, v| {
        let (x, s) = (half * (2.0 * u - 1.0), v * total);
        if s < floor {
            DVec3::new(x, near + s, 0.0)
        } else if s < floor + arc {
            let angle = (s - floor) / radius;
            DVec3::new(x, depth - radius + radius * angle.sin(), radius * (1.0 - angle.cos()))
        } else {
            DVec3::new(x, depth, radius + s - floor - arc)
        }
    })
}

/// Length, half width and height of the body below the windows \[m\].
const LENGTH: f64 = 0.46;
const HALF_WIDTH: f64 = 0.098;
const BODY: f64 = 0.074;
const CABIN: f64 = 0.056;

/// `6 t^5 - 15 t^4 + 10 t^3` from 0 at `a` to 1 at `b`.
fn rise(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

/// A shell in the shape of a small car body: nose towards -x, centre above the origin, resting on z = 0 \[m\].
///
/// Superelliptic cross-sections, `y = w(s) sgn(cos t) |cos t|^(2/n)`, `z = h(s) sin(t)^(2/n) + c(s) g(|y| / w)`, along the
/// length `s`; `c` is the cabin, which `g` narrows, and the wings swell over four wheels.
pub fn car_shell() -> Result<Mesh> {
    surface([260, 200], &|u, v| body(u, PI * v))
}

fn body(u: f64, t: f64) -> DVec3 {
    // Stations crowd at the ends, where the plan is round.
    let s = 0.5 * (1.0 - (PI * u).cos());
    let plan = (1.0 - (2.0 * s - 1.0).abs().powf(3.6)).max(0.0).sqrt();
    let side = (1.0 - (2.0 * s - 1.0).abs().powf(5.0)).max(0.0).sqrt();
    let waist = 1.0 - 0.06 * (PI * s).sin().powi(2);
    // The bonnet rises to the windscreen, the tail is a little higher.
    let height = BODY * side * (0.80 + 0.20 * rise(0.0, 0.40, s) + 0.06 * rise(0.55, 0.95, s));
    let cabin = CABIN * rise(0.27, 0.49, s) * (1.0 - rise(0.60, 0.93, s));
    let power = 2.0 / 2.9;
    let (q, lift) = (t.cos().abs().powf(power), t.sin().abs().powf(power));
    let (x, z) = (LENGTH * (s - 0.5), height * lift);
    let swell: f64 = [-0.30, 0.29]
        .iter()
        .map(|wheel| {
            let (dx, dz) = (x / LENGTH - wheel, (z - 0.55 * BODY) / LENGTH);
            (-(dx * dx) / 0.006 - (dz * dz) / 0.008).exp()
        })
        .sum();
    let y = HALF_WIDTH * plan * waist * (1.0 + 0.085 * swell) * q * t.cos().signum();
    DVec3::new(x, y, z + cabin * (1.0 - rise(0.42, 0.97, q)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shell_has_its_size_and_no_crease() {
        let points: Vec<DVec3> = (0..=200)
            .flat_map(|i| (0..=200).map(move |j| body(f64::from(i) / 200.0, PI * f64::from(j) / 200.0)))
            .collect();
        let (low, high) = points.iter().fold((DVec3::MAX, DVec3::MIN), |(a, b), p| (a.min(*p), b.max(*p)));
        assert!((high.x - low.x - LENGTH).abs() < 1e-9 && low.z.abs() < 1e-9, "{low} {high}");
        assert!(high.z > BODY + 0.9 * CABIN && high.z < 1.1 * (BODY + CABIN), "{high}");
        // Left and right are mirror images.
        for (u, t) in [(0.2, 0.3), (0.5, 1.2), (0.8, 0.9)] {
            let (a, b) = (body(u, t), body(u, PI - t));
            assert!((a - b * DVec3::new(1.0, -1.0, 1.0)).length() < 1e-12);
        }
        let mesh = car_shell().unwrap();
        assert!(mesh.len() > 100_000 && mesh.area() > 0.1 && mesh.area() < 0.3, "{} {}", mesh.len(), mesh.area());
    }
}
