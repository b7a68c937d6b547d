//! A point of a surface with the frame of its material.

use super::scene::{Frame, Hit, Id, Scene};
use crate::math::frame::{DVec3, reflect, tangents};

/// Least cosine to the surface of the viewer and of the mirror direction about an interpolated normal.
const LEAST: f64 = 1e-3;

/// z is the normal on the side that is seen.
pub(super) struct Spot {
    /// Direction to the viewer in the local frame.
    pub seen: DVec3,
    pub x: DVec3,
    pub z: DVec3,
    /// Unit normal of the surface as rays meet it, on the side that is seen: past an interpolated normal a direction may
    /// leave the frame and not the surface.
    pub plane: DVec3,
}

impl Spot {
    /// `None` if the surface is seen exactly edge-on.
    #[inline(always)]
    pub(super) fn new(scene: &Scene, hit: &Hit, point: DVec3, to_viewer: DVec3) -> Option<Self> {
        let Frame { mut plane, normal: mut z, along } = scene.frame(hit, point);
        if plane.dot(to_viewer) < 0.0 {
            (plane, z) = (-plane, -z);
        }
        let mut x = along;
        if let Id::Triangle { .. } = hit.id {
            z = consistent(z, plane, to_viewer);
            // Any direction will do where the parallels of latitude shrink to a point.
            x = (along - along.dot(z) * z).try_normalize().unwrap_or_else(|| tangents(z).0);
        }
        let mut spot = Spot { seen: DVec3::Z, x, z, plane };
        spot.seen = spot.to_local(to_viewer);
        (spot.seen.z > 0.0).then_some(spot)
    }

    #[inline(always)]
    pub(super) fn to_local(&self, w: DVec3) -> DVec3 {
        DVec3::new(w.dot(self.x), w.dot(self.z.cross(self.x)), w.dot(self.z))
    }
}

/// An interpolated normal bent, where it must be, until the viewer and the mirror image of the viewer are above the surface:
/// silhouettes of smooth meshes then neither turn black nor let light through (after Keller et al., The Iray light
/// transport simulation and rendering system, 2017, A.3).
#[inline]
fn consistent(mut normal: DVec3, plane: DVec3, to_viewer: DVec3) -> DVec3 {
    if normal == plane {
        return normal;
    }
    if normal.dot(plane) < 0.0 {
        normal = -normal;
    }
    let seen = normal.dot(to_viewer);
    if seen < LEAST {
        normal = (normal + (LEAST - seen) * to_viewer).normalize_or(plane);
    }
    let mirror = reflect(to_viewer, normal);
    let above = mirror.dot(plane);
    if above < LEAST {
        let lifted = (mirror + (LEAST - above) * plane).normalize_or(plane);
        normal = (to_viewer + lifted).normalize_or(plane);
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;

    #[test]
    fn a_bent_normal_reflects_above_the_surface() {
        let plane = DVec3::Z;
        for k in 0..2000 {
            let t = f64::from(k);
            let to_viewer = direction(1.5705 * (t * 0.618).fract(), 7.0 * t);
            let normal = direction(1.5 * (t * 0.755).fract(), 5.0 * t);
            let bent = consistent(normal, plane, to_viewer);
            assert!((bent.length() - 1.0).abs() < 1e-12 && bent.dot(to_viewer) > 0.0);
            let mirror = reflect(to_viewer, bent);
            assert!(mirror.z > 0.9 * LEAST.min(to_viewer.z), "{to_viewer} {normal}: {mirror}");
            let untouched = normal.dot(to_viewer) > LEAST && reflect(to_viewer, normal).z > LEAST;
            assert!(!untouched || bent == normal);
        }
    }
}
