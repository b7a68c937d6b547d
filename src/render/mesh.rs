//! Triangle meshes: an indexed list of triangles behind a bounding volume hierarchy.

use super::shape::Ray;
use super::triangle::ShearedRay;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use crate::sample::AliasTable;
use glam::{DAffine3, DMat3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::ray::{Ray as BoxRay, RayHit};
use obvhs::{Boundable, BvhBuildParams};

/// Boxes are widened by this share of the mesh, which covers the rounding of rays to f32.
const SLACK: f64 = 2e-6;

/// Triangles over shared vertices, seen from both sides; the front of a triangle turns counterclockwise.
pub struct Mesh {
    vertices: Vec<DVec3>,
    /// Unit vectors at the vertices, or none for flat triangles.
    normals: Option<Vec<DVec3>>,
    triangles: Vec<[u32; 3]>,
    bvh: Bvh2,
    /// Boxes are about this point, so that a small mesh far away keeps its digits in f32.
    centre: DVec3,
    radius: f64,
    area: f64,
    dropped: usize,
    axis: DVec3,
}

/// Where a ray meets a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeshHit {
    pub t: f64,
    pub triangle: u32,
    /// Weights of the second and third corner.
    pub weights: [f64; 2],
}

struct Bounds(Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Mesh {
    /// A mesh of flat triangles, or of smooth ones if `normals` gives a vector for every vertex. Lengths in metres.
    /// Triangles without area are left out, see [`Mesh::dropped`].
    ///
    /// # Errors
    /// `Error::Parameter` naming the first triangle with an index beyond the vertices or the first vertex that is not
    /// finite, or if no triangle has an area.
    pub fn new(vertices: Vec<DVec3>, normals: Option<Vec<DVec3>>, mut triangles: Vec<[u32; 3]>) -> Result<Self> {
        check(&vertices, normals.as_deref(), &triangles)?;
        let before = triangles.len();
        let corners = |t: &[u32; 3]| t.map(|k| vertices[k as usize]);
        triangles.retain(|t| cross(corners(t)).length() > 0.0);
        if triangles.is_empty() {
            return Err(Error::parameter("the mesh has no triangle with an area", "export it again"));
        }
        let used = || triangles.iter().flat_map(&corners);
        let (low, high) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        let centre = 0.5 * (low + high);
        let radius = 0.5 * (high - low).length();
        let slack = DVec3::splat(SLACK * radius);
        let bounds: Vec<Bounds> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = corners(t).map(|p| p - centre);
                let (low, high) = (a.min(b).min(c) - slack, a.max(b).max(c) + slack);
                Bounds(Aabb::new(low.as_vec3a(), high.as_vec3a()))
            })
            .collect();
        let bvh = build_bvh2(&bounds, BvhBuildParams::medium_build(), &mut std::time::Duration::default());
        // In the order of the leaves, so that a leaf names its triangles without a detour.
        let triangles: Vec<[u32; 3]> = bvh.primitive_indices.iter().map(|&k| triangles[k as usize]).collect();
        let area = triangles.iter().map(|t| 0.5 * cross(corners(t)).length()).sum();
        let dropped = before - triangles.len();
        let normals = normals.map(|n| n.into_iter().map(|v| v.normalize_or_zero()).collect());
        Ok(Mesh { vertices, normals, triangles, bvh, centre, radius, area, dropped, axis: DVec3::Z })
    }

    /// Unit normals at the vertices: the mean of the normals of the triangles around, weighted by their angles there
    /// (Thuermer and Wuethrich, J. Graphics Tools 3(1), 1998).
    pub fn vertex_normals(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; vertices.len()];
        for t in triangles {
            let Some(corners) = corners_of(vertices, t) else { continue };
            let normal = cross(corners).normalize_or_zero();
            for k in 0..3 {
                let (p, q, r) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
                let (a, b) = (q - p, r - p);
                let angle = a.cross(b).length().atan2(a.dot(b));
                normals[t[k] as usize] += angle * normal;
            }
        }
        normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        normals
    }

    /// The mesh moved, turned and scaled.
    ///
    /// # Errors
    /// As [`Mesh::new`] if the transform squeezes it flat.
    pub fn transformed(&self, transform: &DAffine3) -> Result<Self> {
        let turn: DMat3 = transform.matrix3.inverse().transpose();
        let mirrored = transform.matrix3.determinant() < 0.0;
        let normals = self.normals.as_ref().map(|n| n.iter().map(|v| turn * *v).collect());
        let flip = |t: &[u32; 3]| if mirrored { [t[0], t[2], t[1]] } else { *t };
        let vertices = self.vertices.iter().map(|p| transform.transform_point3(*p)).collect();
        let mesh = Mesh::new(vertices, normals, self.triangles.iter().map(flip).collect())?;
        let axis = (transform.matrix3 * self.axis).normalize_or(DVec3::Z);
        Ok(Mesh { dropped: mesh.dropped + self.dropped, axis, ..mesh })
    }

    /// Triangles without area that were left out.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Never true: an empty mesh is refused.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Area of all triangles [m2].
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The axis that the x direction of materials turns about: z, turned with the mesh.
    #[inline]
    pub(super) fn axis(&self) -> DVec3 {
        self.axis
    }

    /// Centre of the box around it \[m\].
    pub(super) fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Radius of a ball about the centre that holds it \[m\].
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|k| self.vertices[k as usize])
    }

    #[inline]
    fn box_ray(&self, ray: &Ray, t_max: f64) -> BoxRay {
        BoxRay::new((ray.origin - self.centre).as_vec3a(), ray.direction.as_vec3a(), 0.0, later(t_max))
    }

    /// First triangle before `t_max` but the one that is left.
    #[inline(never)]
    pub(super) fn closest(&self, ray: &Ray, t_max: f64, leaving: Option<u32>) -> Option<MeshHit> {
        let sheared = ShearedRay::new(ray);
        let mut best = None;
        let mut nearest = t_max;
        self.bvh.ray_traverse(self.box_ray(ray, t_max), &mut RayHit::none(), |_, k| {
            let triangle = k as u32;
            match sheared.meet(self.corners(triangle), nearest) {
                Some(m) if leaving != Some(triangle) => {
                    nearest = m.t;
                    best = Some(MeshHit { t: m.t, triangle, weights: m.weights });
                    later(m.t)
                }
                _ => f32::INFINITY,
            }
        });
        best
    }

    /// Whether any triangle but `leaving` and `target` stands before `distance`.
    #[inline(never)]
    pub(super) fn blocks(&self, ray: &Ray, distance: f64, leaving: Option<u32>, target: Option<u32>) -> bool {
        let sheared = ShearedRay::new(ray);
        !self.bvh.ray_traverse_miss(self.box_ray(ray, distance), |_, k| {
            let triangle = k as u32;
            let met = sheared.meet(self.corners(triangle), distance).is_some();
            if met && leaving != Some(triangle) && target != Some(triangle) { 0.0 } else { f32::INFINITY }
        })
    }

    /// Unit normal of the plane of a triangle and the interpolated unit normal at a point of it, both on its front.
    #[inline]
    pub(super) fn normals(&self, triangle: u32, weights: [f64; 2]) -> (DVec3, DVec3) {
        let plane = cross(self.corners(triangle)).normalize();
        let Some(normals) = &self.normals else { return (plane, plane) };
        let [a, b, c] = self.triangles[triangle as usize].map(|k| normals[k as usize]);
        let smooth = (1.0 - weights[0] - weights[1]) * a + weights[0] * b + weights[1] * c;
        (plane, smooth.try_normalize().unwrap_or(plane))
    }

    /// Draws of triangles in proportion to their areas.
    pub(super) fn area_table(&self) -> Result<AliasTable> {
        let areas: Vec<f64> = (0..self.triangles.len() as u32).map(|t| 0.5 * cross(self.corners(t)).length()).collect();
        AliasTable::new(&areas)
    }

    /// A point of a triangle, uniform over its area, and its unit normal.
    #[inline]
    pub(super) fn point(&self, triangle: u32, [u, v]: [f64; 2]) -> (DVec3, DVec3) {
        let corners = self.corners(triangle);
        let root = u.sqrt();
        let [a, b, c] = corners;
        ((1.0 - root) * a + root * (1.0 - v) * b + root * v * c, cross(corners).normalize())
    }

    /// Whether a point lies inside the closed surface: a ray from it leaves through an odd number of triangles, in each
    /// of three directions.
    pub(super) fn holds(&self, point: DVec3) -> bool {
        [DVec3::new(0.31, 0.22, 0.92), DVec3::new(-0.83, 0.41, -0.37), DVec3::new(0.12, -0.91, 0.39)].iter().all(|d| {
            let direction = d.normalize();
            let mut ray = Ray { origin: point, direction };
            let (mut count, mut leaving) = (0, None);
            while let Some(hit) = self.closest(&ray, f64::INFINITY, leaving) {
                count += 1;
                ray.origin = ray.at(hit.t);
                leaving = Some(hit.triangle);
                if count > 10_000 {
                    break;
                }
            }
            count % 2 == 1
        })
    }
}

fn check(vertices: &[DVec3], normals: Option<&[DVec3]>, triangles: &[[u32; 3]]) -> Result<()> {
    let refuse = |what: String| Err(Error::parameter(what, "mend the mesh or export it again"));
    if let Some(k) = vertices.iter().position(|p| !p.is_finite()) {
        return refuse(format!("vertex {k} of the mesh is not finite: {}", vertices[k]));
    }
    if let Some(normals) = normals {
        if normals.len() != vertices.len() {
            return refuse(format!("the mesh has {} vertices and {} normals", vertices.len(), normals.len()));
        }
        if let Some(k) = normals.iter().position(|n| !n.is_finite()) {
            return refuse(format!("normal {k} of the mesh is not finite: {}", normals[k]));
        }
    }
    let bad = |t: &&[u32; 3]| t.iter().any(|&k| k as usize >= vertices.len());
    if let Some(t) = triangles.iter().find(bad) {
        let index = triangles.iter().position(|other| other == t).unwrap_or(0);
        return refuse(format!("triangle {index} of the mesh names vertices {t:?}, but there are {}", vertices.len()));
    }
    Ok(())
}

fn corners_of(vertices: &[DVec3], t: &[u32; 3]) -> Option<[DVec3; 3]> {
    Some([*vertices.get(t[0] as usize)?, *vertices.get(t[1] as usize)?, *vertices.get(t[2] as usize)?])
}

#[inline]
fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// A distance in f32 that is not before the one in f64.
#[inline]
fn later(t: f64) -> f32 {
    (t as f32) * (1.0 + 4.0 * f32::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron far from the origin.
    fn tetrahedron(at: DVec3) -> Mesh {
        let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p + at).to_vec();
        Mesh::new(vertices, None, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    #[test]
    fn a_ray_meets_the_near_face_and_leaves_by_the_far_one() {
        let at = DVec3::new(1e4, -2e4, 3e3);
        let mesh = tetrahedron(at);
        assert!((mesh.area() - (1.5 + 0.75f64.sqrt())).abs() < 1e-12);
        let ray = Ray { origin: at + DVec3::new(0.2, 0.3, -4.0), direction: DVec3::Z };
        let hit = mesh.closest(&ray, f64::INFINITY, None).unwrap();
        assert!((hit.t - 4.0).abs() < 1e-9);
        let again = mesh.closest(&Ray { origin: ray.at(hit.t), ..ray }, f64::INFINITY, Some(hit.triangle)).unwrap();
        assert!((again.t - 0.5).abs() < 1e-9);
        assert!(mesh.blocks(&ray, 4.1, None, None) && !mesh.blocks(&ray, 3.9, None, None));
        assert!(!mesh.blocks(&ray, 4.1, None, Some(hit.triangle)));
        assert!(mesh.holds(at + DVec3::splat(0.2)) && !mesh.holds(at + DVec3::splat(0.4)));
        let (plane, smooth) = mesh.normals(hit.triangle, hit.weights);
        assert_eq!((plane, smooth), (-DVec3::Z, -DVec3::Z));
    }

    #[test]
    fn every_ray_finds_what_a_plain_search_finds() {
        let n = 24;
        let height = |i: usize, j: usize| 0.3 * (0.7 * i as f64).sin() * (0.4 * j as f64).cos();
        let vertices: Vec<DVec3> =
            (0..n * n).map(|k| DVec3::new((k % n) as f64, (k / n) as f64, height(k % n, k / n))).collect();
        let mut triangles = Vec::new();
        for k in (0..n * (n - 1)).filter(|k| k % n != n - 1) {
            let k = k as u32;
            triangles.push([k, k + 1, k + 1 + n as u32]);
            triangles.push([k, k + 1 + n as u32, k + n as u32]);
        }
        let mesh = Mesh::new(vertices, None, triangles).unwrap();
        let mut rng = crate::math::random::CounterRng::new(3, 0, 0);
        let mut hits = 0;
        for _ in 0..2000 {
            let mut random = |scale: f64| scale * rng.uniform();
            let origin = DVec3::new(random(23.0), random(23.0), 3.0 - random(6.0));
            let target = DVec3::new(random(23.0), random(23.0), 0.2 - random(0.4));
            let ray = Ray { origin, direction: (target - origin).normalize() };
            let sheared = ShearedRay::new(&ray);
            let plain = (0..mesh.len() as u32)
                .filter_map(|t| sheared.meet(mesh.corners(t), f64::INFINITY).map(|m| m.t))
                .fold(f64::INFINITY, f64::min);
            let found = mesh.closest(&ray, f64::INFINITY, None).map_or(f64::INFINITY, |h| h.t);
            assert_eq!(plain, found);
            hits += u32::from(found.is_finite());
            assert_eq!(mesh.blocks(&ray, 2.0, None, None), plain < 2.0);
        }
        assert!(hits > 500);
    }

    #[test]
    fn meshes_that_cannot_be_are_refused() {
        let square = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let message = |r: Result<Mesh>| r.err().unwrap().to_string();
        assert!(message(Mesh::new(square.clone(), None, vec![[0, 1, 2], [0, 1, 7]])).contains("triangle 1"));
        assert!(message(Mesh::new(square.clone(), None, vec![[0, 1, 1]])).contains("area"));
        assert!(message(Mesh::new(square.clone(), Some(vec![DVec3::Z]), vec![[0, 1, 2]])).contains("1 normals"));
        assert!(message(Mesh::new(vec![DVec3::NAN; 3], None, vec![[0, 1, 2]])).contains("vertex 0"));
        assert_eq!(Mesh::new(square, None, vec![[0, 1, 2], [0, 0, 2]]).unwrap().dropped(), 1);
    }

    #[test]
    fn normals_of_vertices_weigh_by_angle() {
        // A corner of a cube, one face of it cut into two triangles: all three faces weigh the same.
        let vertices = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y, DVec3::Z];
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 4, 1], [0, 3, 4]];
        let normal = Mesh::vertex_normals(&vertices, &triangles)[0];
        assert!((normal - DVec3::ONE.normalize()).length() < 1e-12);
    }
}
