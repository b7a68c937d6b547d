//! Meshes from closed formulas: a car-like shell and the sweep of a photographer's backdrop.

use crate::error::Result;
use crate::render::{Coat, Cover, Disc, Mesh, Quad, Scene};
use glam::{DAffine3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Smooth patches that become one mesh.
#[derive(Default)]
struct Patches {
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

const STEP: f64 = 1e-4;

impl Patches {
    /// Adds the surface `at(u, v)`, `u` and `v` from 0 to 1, as `n[0] x n[1]` cells of two triangles, with the normals of
    /// the formula by central differences. `cut` may move a vertex a little, and triangles for whose vertices it is
    /// negative on average are left out.
    fn add(&mut self, n: [usize; 2], at: &dyn Fn(f64, f64) -> DVec3, cut: &dyn Fn(&mut DVec3) -> f64) {
        let first = self.vertices.len() as u32;
        let mut kept = Vec::new();
        for j in 0..=n[1] {
            for i in 0..=n[0] {
                let (u, v) = (i as f64 / n[0] as f64, j as f64 / n[1] as f64);
                let mut vertex = at(u, v);
                kept.push(cut(&mut vertex));
                self.vertices.push(vertex);
                // At a pole one direction shrinks to a point: the normal is taken beside it.
                let (u, v) = (u.clamp(2.0 * STEP, 1.0 - 2.0 * STEP), v.clamp(2.0 * STEP, 1.0 - 2.0 * STEP));
                let along = at(u + STEP, v) - at(u - STEP, v);
                let across = at(u, v + STEP) - at(u, v - STEP);
                self.normals.push(along.cross(across).normalize_or(DVec3::Z));
            }
        }
        let row = n[0] as u32 + 1;
        let cells = (0..n[1] as u32).flat_map(|j| (0..n[0] as u32).map(move |i| j * row + i));
        let triangles = cells.flat_map(|k| [[k, k + 1, k + row + 1], [k, k + row + 1, k + row]]);
        let left = triangles.filter(|t| t.iter().map(|&k| kept[k as usize]).sum::<f64>() > 0.0);
        self.triangles.extend(left.map(|t| t.map(|k| first + k)));
    }

    fn mesh(self) -> Result<Mesh> {
        Mesh::new(self.vertices, Some(self.normals), self.triangles)
    }
}

/// Adds a floor z = 0 that bends up into a wall at `y = depth` \[m\], as photographers have it.
pub fn add_backdrop<'a>(scene: &mut Scene<'a>, depth: f64, coat: Coat<'a>) -> Result<()> {
    let (radius, near, top, half) = (0.7, -4.0, 4.0, 6.0);
    let width = 2.0 * half * DVec3::X;
    let floor = Quad::new(DVec3::new(-half, near, 0.0), width, (depth - radius - near) * DVec3::Y)?;
    let wall = Quad::new(DVec3::new(-half, depth, radius), width, (top - radius) * DVec3::Z)?;
    let mut bend = Patches::default();
    let quarter = |u: f64, v: f64| {
        let (sin, cos) = (FRAC_PI_2 * v).sin_cos();
        DVec3::new(half * (2.0 * u - 1.0), depth - radius * (1.0 - sin), radius * (1.0 - cos))
    };
    bend.add([1, 48], &quarter, &|_| 1.0);
    scene.add(floor, Cover::Plain(coat));
    scene.add(wall, Cover::Plain(coat));
    scene.add(bend.mesh()?, Cover::Plain(coat));
    Ok(())
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

/// Radius of a wheel arch, and of the wheel in it.
const ARCH: f64 = 0.0320;
const WHEEL: f64 = 0.0285;
/// Between the floor and the sill.
const CLEARANCE: f64 = 0.017;
/// The wheels along the length, from the middle.
const WHEELS: [f64; 2] = [-0.30 * LENGTH, 0.29 * LENGTH];

/// A shell in the shape of a small car body: nose towards -x, centre above the origin, wheels on z = 0 \[m\].
///
/// Superelliptic cross-sections, `y = w(s) sgn(cos t) |cos t|^(2/n)`, `z = h(s) sin(t)^(2/n) + c(s) g(|y| / w)`, along the
/// length `s`; `c` is the cabin, which `g` narrows, and the wings swell over four wheels, which stand in round arches.
pub fn car_shell() -> Result<Mesh> {
    let mut patches = Patches::default();
    // Vertices near an arch are drawn onto it, so that it is cut along a circle.
    let arches = |p: &mut DVec3| {
        let Some(wheel) = wheel_near(*p) else { return 1.0 };
        let (dx, dz) = (p.x - wheel.x, p.z - wheel.z);
        let distance = dx.hypot(dz);
        if (distance - ARCH).abs() < 0.7e-3 {
            (p.x, p.z) = (wheel.x + dx * ARCH / distance, wheel.z + dz * ARCH / distance);
        }
        distance - ARCH
    };
    patches.add([460, 340], &|u, v| body(u, PI * v), &arches);
    patches.mesh()
}

/// Centres of the outer faces of the wheels.
fn wheels() -> [DVec3; 4] {
    let at = |k: usize| {
        let (x, side) = (WHEELS[k / 2], if k.is_multiple_of(2) { -1.0 } else { 1.0 });
        DVec3::new(x, side * (HALF_WIDTH * 0.985), WHEEL)
    };
    [at(0), at(1), at(2), at(3)]
}

/// The tyres of shells at several places as one mesh, and their hubs.
pub fn wheels_of(places: &[DAffine3]) -> Result<(Mesh, Vec<Disc>)> {
    let mut tyres = Patches::default();
    let mut hubs = Vec::new();
    for place in places {
        for wheel in wheels() {
            let outward = wheel.y.signum() * DVec3::Y;
            // A superelliptic ring of 19 to 28.5 mm radius, 20 mm wide.
            let ring = |u: f64, v: f64| {
                let ((s, c), (q, p)) = ((2.0 * PI * u).sin_cos(), (2.0 * PI * v).sin_cos());
                let (a, b) = (p.signum() * p.abs().sqrt(), q.signum() * q.abs().sqrt());
                let radius = WHEEL - 0.00475 * (1.0 - a);
                let local = wheel + radius * DVec3::new(c, 0.0, s) + (0.010 * (b - 1.0)) * outward;
                place.transform_point3(local)
            };
            tyres.add([96, 48], &ring, &|_| 1.0);
            let hub = place.transform_point3(wheel - 0.003 * outward);
            hubs.push(Disc::new(hub, place.transform_vector3(outward), 0.0195, 0.0)?);
        }
    }
    Ok((tyres.mesh()?, hubs))
}

fn wheel_near(p: DVec3) -> Option<DVec3> {
    wheels().into_iter().find(|w| (p.x - w.x).abs() < 2.0 * ARCH && p.y * w.y > 0.0 && p.y.abs() > 0.5 * HALF_WIDTH)
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
    let swell: f64 = WHEELS
        .iter()
        .map(|wheel| {
            let (dx, dz) = ((x - wheel) / LENGTH, (z - 0.35 * BODY) / LENGTH);
            (-(dx * dx) / 0.006 - (dz * dz) / 0.008).exp()
        })
        .sum();
    let y = HALF_WIDTH * plan * waist * (1.0 + 0.085 * swell) * q * t.cos().signum();
    DVec3::new(x, y, CLEARANCE + z + cabin * (1.0 - rise(0.42, 0.97, q)))
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
        assert!((high.x - low.x - LENGTH).abs() < 1e-9 && (low.z - CLEARANCE).abs() < 1e-9, "{low} {high}");
        assert!(high.z - CLEARANCE > BODY + 0.9 * CABIN && high.z - CLEARANCE < 1.1 * (BODY + CABIN), "{high}");
        // Left and right are mirror images.
        for (u, t) in [(0.2, 0.3), (0.5, 1.2), (0.8, 0.9)] {
            let (a, b) = (body(u, t), body(u, PI - t));
            assert!((a - b * DVec3::new(1.0, -1.0, 1.0)).length() < 1e-12);
        }
        let mesh = car_shell().unwrap();
        assert!(mesh.len() > 100_000 && mesh.area() > 0.1 && mesh.area() < 0.3, "{} {}", mesh.len(), mesh.area());
    }
}
