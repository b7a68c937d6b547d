//! Surfaces of revolution: a profile turned about the z axis.

use super::mesh::Mesh;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use std::f64::consts::TAU;

/// Meridians of the mesh; a facet of 1/256 of a turn departs from the circle by 8e-5 of its radius.
const MERIDIANS: u32 = 256;
/// Pieces of a smooth profile between two of its points.
const PIECES: usize = 24;

/// The profile `[r, z]` \[m\] turned about z. `smooth` runs a centripetal Catmull-Rom curve through the points, without it
/// the pieces are straight and meet in edges. The front is on the outside where the profile rises.
///
/// # Errors
/// `Error::Parameter` if there are fewer than two points, one has a negative or no finite radius, or two that follow each
/// other are the same.
pub fn revolution(profile: &[[f64; 2]], smooth: bool) -> Result<Mesh> {
    check(profile)?;
    let rings = if smooth { curve(profile) } else { profile.windows(2).flat_map(|w| straight(w[0], w[1])).collect() };
    let mut vertices = Vec::new();
    let mut normals = Vec::new();
    for ring in &rings {
        for k in 0..MERIDIANS {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(MERIDIANS)).sin_cos();
            vertices.push(DVec3::new(ring.at[0] * cos, ring.at[0] * sin, ring.at[1]));
            normals.push(DVec3::new(ring.normal[0] * cos, ring.normal[0] * sin, ring.normal[1]));
        }
    }
    let mut triangles = Vec::new();
    for lower in (0..rings.len() - 1).filter(|&k| !rings[k].ends) {
        let (a, b) = (lower as u32 * MERIDIANS, (lower as u32 + 1) * MERIDIANS);
        for k in 0..MERIDIANS {
            let next = (k + 1) % MERIDIANS;
            triangles.push([a + k, a + next, b + next]);
            triangles.push([a + k, b + next, b + k]);
        }
    }
    Mesh::new(vertices, Some(normals), triangles)
}

/// A circle of the mesh; `ends` if nothing joins it to the next.
struct Ring {
    at: [f64; 2],
    normal: [f64; 2],
    ends: bool,
}

fn check(profile: &[[f64; 2]]) -> Result<()> {
    let refuse = |what: String| Err(Error::parameter(what, "list points [r, z] along the outline, r of at least 0"));
    if profile.len() < 2 {
        return refuse(format!("a profile of {} points turns into nothing", profile.len()));
    }
    if let Some(k) = profile.iter().position(|p| !(p[0] >= 0.0 && p[0].is_finite() && p[1].is_finite())) {
        return refuse(format!("point {k} of the profile, {:?}, is not a radius and a height", profile[k]));
    }
    match profile.windows(2).position(|w| w[0] == w[1]) {
        Some(k) => refuse(format!("points {k} and {} of the profile are the same", k + 1)),
        None => Ok(()),
    }
}

/// Right of the direction `[dr, dz]`: the outside where it rises.
fn outside([dr, dz]: [f64; 2]) -> [f64; 2] {
    let length = dr.hypot(dz);
    if length > 0.0 { [dz / length, -dr / length] } else { [1.0, 0.0] }
}

/// A straight piece with rings of its own, so that it meets its neighbours in an edge. It is cut where it comes near the
/// axis, where the triangles are long.
fn straight(a: [f64; 2], b: [f64; 2]) -> Vec<Ring> {
    let normal = outside([b[0] - a[0], b[1] - a[1]]);
    (0..=8)
        .map(|k| {
            let t = f64::from(k) / 8.0;
            Ring { at: [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])], normal, ends: k == 8 }
        })
        .collect()
}

/// Centripetal Catmull-Rom through the points (Yuksel, Schaefer, Keyser, Computer-Aided Design 43, 2011): no loops and no
/// overshoot beyond them. At an axis the curve is continued by its mirror image, so that it meets the axis level.
fn curve(profile: &[[f64; 2]]) -> Vec<Ring> {
    let n = profile.len();
    let beyond = |end: [f64; 2], inner: [f64; 2]| {
        if end[0] == 0.0 { [-inner[0], inner[1]] } else { [2.0 * end[0] - inner[0], 2.0 * end[1] - inner[1]] }
    };
    let mut points = vec![beyond(profile[0], profile[1])];
    points.extend_from_slice(profile);
    points.push(beyond(profile[n - 1], profile[n - 2]));
    let knot = |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]).hypot(b[1] - a[1]).sqrt();
    let mut rings = Vec::new();
    for (piece, p) in points.windows(4).enumerate() {
        let d = [knot(p[0], p[1]), knot(p[1], p[2]), knot(p[2], p[3])];
        // Tangents at the two inner points for a parameter from 0 to 1.
        let tangent = |a: [f64; 2], b: [f64; 2], c: [f64; 2], before: f64, after: f64, axis: usize| {
            let (left, right) = ((b[axis] - a[axis]) / before, (c[axis] - b[axis]) / after);
            d[1] * ((left * after + right * before) / (before + after))
        };
        let m = [0, 1]
            .map(|axis| [tangent(p[0], p[1], p[2], d[0], d[1], axis), tangent(p[1], p[2], p[3], d[1], d[2], axis)]);
        let last = piece + 2 == n;
        for k in 0..PIECES + usize::from(last) {
            let t = k as f64 / PIECES as f64;
            let (t2, t3) = (t * t, t * t * t);
            let at = [0, 1].map(|x| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * p[1][x]
                    + (t3 - 2.0 * t2 + t) * m[x][0]
                    + (3.0 * t2 - 2.0 * t3) * p[2][x]
                    + (t3 - t2) * m[x][1]
            });
            let slope = [0, 1].map(|x| {
                (6.0 * t2 - 6.0 * t) * (p[1][x] - p[2][x])
                    + (3.0 * t2 - 4.0 * t + 1.0) * m[x][0]
                    + (3.0 * t2 - 2.0 * t) * m[x][1]
            });
            rings.push(Ring { at: [at[0].max(0.0), at[1]], normal: outside(slope), ends: false });
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::shape::Ray;
    use std::f64::consts::PI;

    #[test]
    fn a_cone_and_a_cylinder_have_their_areas_and_normals() {
        // A polygon of n sides falls short of the circle by (pi/n)^2 / 6 of its perimeter.
        let mesh = revolution(&[[2.0, 0.0], [2.0, 3.0]], false).unwrap();
        assert!((mesh.area() / (12.0 * PI) - 1.0).abs() < 3e-5);
        let cone = revolution(&[[1.0, 0.0], [0.0, 1.0]], false).unwrap();
        assert!((cone.area() / (PI * 2f64.sqrt()) - 1.0).abs() < 1e-4);
        let ray = Ray { origin: DVec3::new(3.0, 0.01, 0.5), direction: -DVec3::X };
        let hit = cone.closest(&ray, f64::INFINITY, None).unwrap();
        let (plane, smooth) = cone.normals(hit.triangle, hit.weights);
        let exact = DVec3::new(1.0, 0.0, 1.0).normalize();
        assert!((smooth - exact).length() < 0.02 && (plane - exact).length() < 0.02);
    }

    /// Points on a half circle: the curve is a sphere to the accuracy of 13 points, and closed at its poles.
    #[test]
    fn a_smooth_profile_turns_into_a_sphere() {
        let profile: Vec<[f64; 2]> = (0..=12)
            .map(|k| {
                let (s, c) = (PI * f64::from(k) / 12.0).sin_cos();
                [if k == 12 { 0.0 } else { s }, -c]
            })
            .collect();
        let mesh = revolution(&profile, true).unwrap();
        assert!((mesh.area() / (4.0 * PI) - 1.0).abs() < 2e-3, "{}", mesh.area());
        assert!(mesh.holds(DVec3::new(0.1, 0.2, 0.3)));
        let mut rng = crate::math::random::CounterRng::new(1, 0, 0);
        for _ in 0..500 {
            let direction = DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, rng.uniform() - 0.5).normalize();
            let hit = mesh.closest(&Ray { origin: DVec3::ZERO, direction }, f64::INFINITY, None).unwrap();
            assert!((hit.t - 1.0).abs() < 2e-3, "{direction}: {}", hit.t);
            let smooth = mesh.normals(hit.triangle, hit.weights).1;
            assert!(smooth.dot(direction) > 0.9995, "{direction}: {smooth}");
        }
    }

    #[test]
    fn profiles_that_turn_into_nothing_are_refused() {
        let message = |p: &[[f64; 2]]| revolution(p, true).err().unwrap().to_string();
        assert!(message(&[[1.0, 0.0]]).contains("1 points"));
        assert!(message(&[[1.0, 0.0], [-1.0, 1.0]]).contains("point 1"));
        assert!(message(&[[1.0, 0.0], [1.0, 0.0], [2.0, 0.0]]).contains("points 0 and 1"));
        assert!(message(&[[f64::NAN, 0.0], [1.0, 0.0]]).contains("point 0"));
        assert!(message(&[[0.0, 0.0], [0.0, 1.0]]).contains("area"));
    }
}
