//! Which quads can stand between two points of a scene.

use super::shape::{Quad, Shape};
use crate::math::frame::DVec3;

/// Share of its distance from the origin by which a shape may lie behind a plane and count as in it.
const FLUSH: f64 = 1e-12;

/// Quads with something on both of their sides. Where everything lies on one side of a quad, such as the wall of a room, no
/// way between two points of the scene leads through it, and it need not be asked.
#[derive(Default)]
pub(super) struct Screens {
    list: Vec<u32>,
    /// Of each quad: whether something lies before it and behind it.
    sides: Vec<[bool; 2]>,
    extents: Vec<Extent>,
    open: bool,
}

/// Room that a shape does not leave.
#[derive(Clone, Copy)]
enum Extent {
    Corners([DVec3; 4]),
    Ball(DVec3, f64),
}

impl Extent {
    fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Quad(q) => {
                let far = q.corner + q.edge_u;
                Extent::Corners([q.corner, far, far + q.edge_v, q.corner + q.edge_v])
            }
            Shape::Sphere(sphere) => Extent::Ball(sphere.centre, sphere.radius),
            Shape::Disc(disc) => Extent::Ball(disc.centre, disc.radius),
            Shape::Mesh(mesh) => Extent::Ball(mesh.centre(), mesh.radius()),
        }
    }

    /// Whether a part of it is before the plane of a quad, and behind it.
    fn sides(&self, quad: &Quad) -> [bool; 2] {
        let flush = |p: DVec3| FLUSH * (p.length() + quad.offset.abs());
        let height = |p: DVec3| quad.normal.dot(p) - quad.offset;
        match self {
            Extent::Corners(corners) => {
                [corners.iter().any(|&p| height(p) > flush(p)), corners.iter().any(|&p| height(p) < -flush(p))]
            }
            Extent::Ball(centre, radius) => {
                [height(*centre) + radius > flush(*centre), height(*centre) - radius < -flush(*centre)]
            }
        }
    }
}

impl Screens {
    /// Numbers of the quads that must be asked.
    #[inline(always)]
    pub(super) fn list(&self) -> &[u32] {
        &self.list
    }

    /// Takes note of a shape among `quads`, the last of which it is itself if it is one.
    pub(super) fn add(&mut self, quads: &[Quad], shape: &Shape) {
        let extent = Extent::of(shape);
        self.extents.push(extent);
        if let Shape::Quad(quad) = shape {
            let both = |sides: [bool; 2], extent: &Extent| join(sides, extent.sides(quad));
            self.sides.push(self.extents.iter().fold([false; 2], both));
        }
        for (sides, quad) in self.sides.iter_mut().zip(quads) {
            *sides = join(*sides, extent.sides(quad));
        }
        self.choose();
    }

    /// Lets light come from infinity: past the edge of any plane.
    pub(super) fn open(&mut self) {
        self.open = true;
        self.choose();
    }

    fn choose(&mut self) {
        let asked = |(_, sides): &(usize, &[bool; 2])| self.open || **sides == [true; 2];
        self.list = self.sides.iter().enumerate().filter(asked).map(|(i, _)| i as u32).collect();
    }
}

fn join(a: [bool; 2], b: [bool; 2]) -> [bool; 2] {
    [a[0] || b[0], a[1] || b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::shape::Sphere;

    #[test]
    fn walls_are_no_screens_until_something_stands_behind_them() {
        let (mut screens, mut quads) = (Screens::default(), Vec::new());
        // A room turned against the axes, from its floor, two walls and ceiling; a board stands in it.
        let (x, y) = (DVec3::new(3.0, 1.7, 0.3), DVec3::new(-1.1, 2.0, -0.334));
        let z = x.cross(y).normalize();
        let corner = DVec3::new(0.3, -7.1, 2.9);
        let mut put = |screens: &mut Screens, shape: Shape| {
            if let Shape::Quad(quad) = &shape {
                quads.push(*quad);
            }
            screens.add(&quads, &shape);
        };
        for (at, u, v) in [(corner, x, y), (corner, y, z), (corner + x, y, z), (corner + z, x, y)] {
            put(&mut screens, Quad::new(at, u, v).unwrap().into());
        }
        assert!(screens.list().is_empty());
        let middle = corner + 0.5 * (x + y + z);
        put(&mut screens, Sphere::new(middle, 0.5).unwrap().into());
        // It touches floor and ceiling.
        assert!(screens.list().is_empty());
        put(&mut screens, Quad::new(middle, 0.1 * x, 0.1 * z).unwrap().into());
        assert_eq!(screens.list(), [4]);
        put(&mut screens, Sphere::new(corner - 0.3 * x + 0.5 * z, 0.01).unwrap().into());
        assert_eq!(screens.list(), [1, 4]);
        screens.open();
        assert_eq!(screens.list(), [0, 1, 2, 3, 4]);
    }
}
