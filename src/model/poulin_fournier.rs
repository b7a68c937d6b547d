//! Poulin-Fournier: parallel cylinders on a floor, for brushed metal, cloth and hair.
//!
//! `f_r = 1 / (d cos_theta_i cos_theta_r) [ int_a^b F(N) dpsi + l_f F(z) ]`,
//! `F(N) = rho_d / pi (N . wi)(N . wo) + rho_s (n + 2) / (8 pi) (N . wh)^n`
//!
//! Cylinders of radius 1 along y, centres `d` apart, rise out of a floor at height `h` over their centres. `psi` is the
//! angle of the cylinder's normal `N = (sin psi, 0, cos psi)`, `[a, b]` the part both lit and seen, `l_f` the length of
//! floor both lit and seen; a neighbour's shadow is exact.
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `d` | distance of the centres in radii; below 2 the cylinders cut into each other | | 0.1 to 20 |
//! | `h` | height of the floor in radii: 0 half a cylinder shows, 1 none | | 0 to 1 |
//! | `rho_d` | diffuse albedo of the material, default 0 | | 0 to 1 |
//! | `rho_s` | albedo of its specular lobe, default 0 | | 0 to 1 |
//! | `exponent` | sharpness n of that lobe | | 1 to 1e4 |
//!
//! The diffuse integral is closed: `r_i r_o / 2 [cos(a_i - a_o) (b - a) + cos(b + a - a_i - a_o) sin(b - a)]`, `r` the
//! lengths and `a_i`, `a_o` the angles of both directions in the cross-section. The specular one needs `int cos^n`, which is
//! tabulated when the model is built (Poulin and Fournier used Chebyshev polynomials).
//!
//! Ours, not the paper's: the specular lobe is written as facets, `D / 4` with Blinn's D of unit projected area, which
//! makes it reciprocal and conserving near normal incidence; cylinders stand out of the floor by at most half.
//!
//! Energy: light that meets a second cylinder is lost; with a glossy lobe facets seen at grazing have no Smith factor, so
//! the albedo exceeds rho_s there. Reciprocal.
//!
//! Sampling: a mixture: cosine for the diffuse part; a normal anywhere on the part of the cylinder that is lit, with `(N .
//! wh)^n` about it; the same about the floor's normal. Density of the mixture.
//!
//! Picture: `asperity lobe poulin-fournier:d=2,h=0.5,rho_s=0.5,exponent=100,rho_d=0.1 -o cylinders.svg`
//!
//! Source: P. Poulin and A. Fournier, A model for anisotropic reflection, SIGGRAPH 1990, sections 3 and 4.

use super::albedo::{AlbedoTable, DRAWS, sampled_average};
use super::lambert::cosine_direction;
use super::parameter::Parameter;
use super::phong::about_axis;
use super::registry::Entry;
use crate::math::{half_vector, reflect};
use crate::optics::{Brdf, BrdfSample};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "poulin-fournier",
    summary: "parallel cylinders on a floor: brushed metal, cloth, hair",
    formula: "f_r = [int rho_d/pi (N.wi)(N.wo) + rho_s (n+2)/(8 pi) (N.wh)^n] / (d cos_theta_i cos_theta_r)",
    parameters: &[
        Parameter::number("d", "distance of the centres, in radii", 0.1, 20.0).usual(1.0, 4.0),
        Parameter::number("h", "height of the floor over the centres, in radii", 0.0, 1.0).usual(0.0, 0.9),
        Parameter::number("rho_d", "diffuse albedo of the material", 0.0, 1.0).usual(0.0, 0.5).or(0.0),
        Parameter::number("rho_s", "albedo of its specular lobe", 0.0, 1.0).usual(0.1, 0.5).or(0.0),
        Parameter::number("exponent", "sharpness n of that lobe", 1.0, 1e4).decades(5.0, 500.0).or(50.0),
    ],
    exceeds_one: true,
    energy: "second hits are lost; a glossy lobe exceeds rho_s towards grazing",
    source: "Poulin and Fournier 1990, specular lobe rewritten as facets",
    example: "poulin-fournier:d=2,h=0.5,rho_s=0.5,exponent=100,rho_d=0.1",
    build: |v| {
        let [rho_d, rho_s] = v.floor_and_lobe()?;
        let [d, h, n] = ["d", "h", "exponent"].map(|key| v.required(key));
        Ok(Box::new(PoulinFournier::new(d?, h?, rho_d, rho_s, n?)))
    },
    ..Entry::PLAIN
};

/// Incident azimuths averaged for the albedo.
const AZIMUTHS: usize = 16;

/// Cylinders on a floor.
#[derive(Debug, Clone)]
pub struct PoulinFournier {
    spacing: f64,
    /// Height of the floor, and half the exposed arc: normals reach from `-arc` to `arc`.
    floor: f64,
    arc: f64,
    rho_d: f64,
    rho_s: f64,
    exponent: f64,
    powers: CosinePower,
    albedo: OnceLock<AlbedoTable>,
}

/// What one direction sees: `[low, high]` of the cylinder's normals, `[left, right]` of the floor, in one period.
#[derive(Debug, Clone, Copy)]
struct View {
    cylinder: [f64; 2],
    floor: [f64; 2],
}

impl View {
    /// What both see.
    fn and(self, other: View) -> View {
        let meet = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        View { cylinder: meet(self.cylinder, other.cylinder), floor: meet(self.floor, other.floor) }
    }

    fn floor_length(&self) -> f64 {
        (self.floor[1] - self.floor[0]).max(0.0)
    }
}

impl PoulinFournier {
    /// Cylinders `spacing` radii apart over a floor at height `floor` (0 to 1), of the given material.
    pub fn new(spacing: f64, floor: f64, rho_d: f64, rho_s: f64, exponent: f64) -> Self {
        // The floor, or the valley where two cylinders meet, ends the arc.
        let arc = floor.acos().min((0.5 * spacing).min(1.0).asin());
        let powers = CosinePower::new(exponent);
        PoulinFournier { spacing, floor, arc, rho_d, rho_s, exponent, powers, albedo: OnceLock::new() }
    }

    /// Half the length on the mean plane that one cylinder covers.
    fn half_width(&self) -> f64 {
        self.arc.sin()
    }

    /// What a direction at the angle `a` from z sees.
    fn view(&self, a: f64) -> View {
        let (side, a) = (a < 0.0, a.abs());
        let s = self.half_width();
        let mut view = View { cylinder: [(a - FRAC_PI_2).max(-self.arc), self.arc], floor: [s, self.spacing - s] };
        // The next cylinder hides something only if its outline is above its foot: the ray is flatter than the steepest
        // facet.
        if a > FRAC_PI_2 - self.arc {
            let (sin, cos) = a.sin_cos();
            let limit = self.spacing * cos - 1.0;
            view.cylinder[1] = self.arc.min(a + limit.clamp(-1.0, 1.0).asin());
            view.floor[1] = view.floor[1].min((limit + self.floor * sin) / cos);
        }
        if side {
            view.cylinder = [-view.cylinder[1], -view.cylinder[0]];
            view.floor = [self.spacing - view.floor[1], self.spacing - view.floor[0]];
        }
        view
    }

    /// `int_low^high (N . wh)^n dpsi`.
    fn lobe(&self, [low, high]: [f64; 2], wh: DVec3) -> f64 {
        if low >= high {
            return 0.0;
        }
        let length = (wh.x * wh.x + wh.z * wh.z).sqrt();
        if length < self.powers.faintest {
            return 0.0;
        }
        let a = wh.x.atan2(wh.z);
        let sum = self.powers.integral(high - a) - self.powers.integral(low - a);
        if sum > 0.0 { length.powf(self.exponent) * sum } else { 0.0 }
    }

    /// `floor (z . wh)^n`.
    fn flat(&self, floor: f64, wh: DVec3) -> f64 {
        if floor > 0.0 && wh.z > self.powers.faintest { floor * wh.z.powf(self.exponent) } else { 0.0 }
    }

    /// Shares of the draws: diffuse, cylinder, floor.
    fn shares(&self, view: &View, wi: DVec3) -> [f64; 3] {
        let floor = self.rho_s * view.floor_length() * wi.z;
        let cylinder = self.rho_s * (view.cylinder[1] - view.cylinder[0]).max(0.0);
        let diffuse = self.rho_d * self.spacing;
        let total = diffuse + cylinder + floor;
        if total > 0.0 { [diffuse / total, cylinder / total, floor / total] } else { [1.0, 0.0, 0.0] }
    }

    fn density(&self, wi: DVec3, wo: DVec3, view: &View) -> f64 {
        let [diffuse, cylinder, floor] = self.shares(view, wi);
        let wh = half_vector(wi, wo);
        let [low, high] = view.cylinder;
        let about = if cylinder > 0.0 { cylinder * self.lobe([low, high], wh) / (high - low) } else { 0.0 };
        let flat = self.flat(floor, wh);
        let normals = (self.exponent + 1.0) / TAU * (about + flat);
        diffuse * wo.z * FRAC_1_PI + normals / (4.0 * wi.dot(wh))
    }
}

impl Brdf for PoulinFournier {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let (ai, ao) = (wi.x.atan2(wi.z), wo.x.atan2(wo.z));
        let view = self.view(ai).and(self.view(ao));
        let [low, high] = view.cylinder;
        let floor = view.floor_length();
        let mut sum = 0.0;
        if self.rho_d > 0.0 {
            let mut diffuse = floor * wi.z * wo.z;
            if low < high {
                // Both directions in the cross-section, and the length they have there.
                let level = wi.x * wo.x + wi.z * wo.z;
                let lengths = ((wi.x * wi.x + wi.z * wi.z) * (wo.x * wo.x + wo.z * wo.z)).sqrt();
                let turning = (high + low - ai - ao).cos() * (high - low).sin();
                diffuse += (0.5 * (level * (high - low) + lengths * turning)).max(0.0);
            }
            sum += self.rho_d * FRAC_1_PI * diffuse;
        }
        if self.rho_s > 0.0 {
            let wh = half_vector(wi, wo);
            let flat = self.flat(floor, wh);
            sum += self.rho_s * (self.exponent + 2.0) / (8.0 * PI) * (self.lobe([low, high], wh) + flat);
        }
        sum / (self.spacing * wi.z * wo.z)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let view = self.view(wi.x.atan2(wi.z));
        let [diffuse, cylinder, floor] = self.shares(&view, wi);
        let wo = if u[0] < diffuse {
            cosine_direction([u[0] / diffuse, u[1]])
        } else {
            let (normal, rest) = if u[0] < diffuse + cylinder {
                // One number serves twice: its leading bits choose the normal, the others the angle about it.
                let u = (u[0] - diffuse) / cylinder * f64::from(1 << 26);
                let psi =
                    view.cylinder[0] + (u.floor() + 0.5) / f64::from(1 << 26) * (view.cylinder[1] - view.cylinder[0]);
                (DVec3::new(psi.sin(), 0.0, psi.cos()), u.fract())
            } else {
                (DVec3::Z, ((u[0] - diffuse - cylinder) / floor).clamp(0.0, 1.0 - f64::EPSILON))
            };
            let wh = about_axis(normal, self.exponent, [rest, u[1]]);
            if wi.dot(wh) <= 0.0 {
                return None;
            }
            reflect(wi, wh)
        };
        if wo.z <= 0.0 {
            return None;
        }
        let pdf = self.density(wi, wo, &view);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.density(wi, wo, &self.view(wi.x.atan2(wi.z)))
    }

    fn albedo_towards(&self, wi: DVec3) -> f64 {
        sampled_average(self, wi, DRAWS)
    }

    /// Averaged over the incident azimuth.
    fn albedo(&self, theta_i: f64) -> f64 {
        let integrate = |wi| sampled_average(self, wi, DRAWS / AZIMUTHS);
        self.albedo.get_or_init(|| AlbedoTable::new(AZIMUTHS, integrate)).at(theta_i)
    }
}

/// `int_0^x cos^n t dt`, 0 beyond a right angle, tabulated.
#[derive(Debug, Clone)]
struct CosinePower {
    /// Cosine of the largest angle of the table, where `cos^n` has fallen to 1e-14 or to 90 deg: `cos^n` of a smaller one
    /// counts as nothing.
    faintest: f64,
    /// Steps per radian.
    scale: f64,
    /// Integral and its slope times the spacing, node by node.
    nodes: Vec<[f64; 2]>,
}

impl CosinePower {
    fn new(exponent: f64) -> Self {
        const STEPS: usize = 512;
        let reach = (1e-14f64).powf(1.0 / exponent).acos().min(FRAC_PI_2);
        let step = reach / STEPS as f64;
        let value = |x: f64| x.cos().max(0.0).powf(exponent);
        let mut nodes = vec![[0.0, step]];
        let mut sum = 0.0;
        for k in 1..=STEPS {
            let x = k as f64 * step;
            // Simpson's rule on each half.
            let parts = [value(x - step), 4.0 * value(x - 0.75 * step), 2.0 * value(x - 0.5 * step)];
            let parts = parts.iter().sum::<f64>() + 4.0 * value(x - 0.25 * step) + value(x);
            sum += parts * step / 12.0;
            nodes.push([sum, value(x) * step]);
        }
        CosinePower { faintest: reach.cos(), scale: STEPS as f64 / reach, nodes }
    }

    fn integral(&self, x: f64) -> f64 {
        let s = x.abs() * self.scale;
        let k = s as usize;
        let value = if k + 1 >= self.nodes.len() {
            self.nodes[self.nodes.len() - 1][0]
        } else {
            // Hermite's cubic.
            let (t, [[a, da], [b, db]]) = (s - k as f64, [self.nodes[k], self.nodes[k + 1]]);
            let r = 1.0 - t;
            a * r * r * (1.0 + 2.0 * t) + b * t * t * (3.0 - 2.0 * t) + t * r * (da * r - db * t)
        };
        value.copysign(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;

    #[test]
    fn integrals_of_cosine_powers() {
        // int_0^(pi/2) cos^n: 1, pi/4, 2/3, 8/15.
        for (n, whole) in [(1.0, 1.0), (2.0, PI / 4.0), (3.0, 2.0 / 3.0), (5.0, 8.0 / 15.0)] {
            let table = CosinePower::new(n);
            assert!((table.integral(2.0) - whole).abs() < 1e-9 && (table.integral(-2.0) + whole).abs() < 1e-9);
        }
        let third = CosinePower::new(3.0);
        for x in [0.1f64, 0.77, 1.3] {
            let exact = x.sin() - x.sin().powi(3) / 3.0;
            assert!((third.integral(x) - exact).abs() < 1e-9);
        }
    }

    /// Shadows by brute force: rays from points of the profile, tested against every neighbour.
    #[test]
    fn what_a_direction_sees() {
        for (spacing, floor) in [(2.0, 0.0), (2.0, 0.6), (4.0, 0.2), (1.2, 0.0), (1.2, 0.9), (8.0, 0.0), (2.0, 1.0)] {
            let model = PoulinFournier::new(spacing, floor, 1.0, 0.0, 1.0);
            for a in [-1.5f64, -1.1, -0.4, 0.0, 0.3, 0.9, 1.3, 1.55] {
                let view = model.view(a);
                let dir = [a.sin(), a.cos()];
                let free = |p: [f64; 2]| {
                    (-40..=40).filter(|&j| j != 0).all(|j| {
                        let to = [f64::from(j) * spacing - p[0], -p[1]];
                        let along = to[0] * dir[0] + to[1] * dir[1];
                        let aside = to[0] * dir[1] - to[1] * dir[0];
                        // The hit must lie on the exposed arc.
                        let half = (1.0 - aside * aside).max(0.0).sqrt();
                        let hit = |t: f64| t > 1e-9 && p[1] + t * dir[1] >= model.arc.cos() - 1e-9;
                        aside.abs() >= 1.0 - 1e-12 || !(hit(along - half) || hit(along + half))
                    })
                };
                for k in 0..400 {
                    let psi = model.arc * (f64::from(k) + 0.5) / 200.0 - model.arc;
                    let lit = (psi - a).cos() > 0.0 && free([psi.sin(), psi.cos()]);
                    let [low, high] = view.cylinder;
                    let near_edge = (psi - low).abs().min((psi - high).abs()) < 0.01;
                    assert!(near_edge || lit == (psi > low && psi < high), "d {spacing} h {floor} a {a} psi {psi}");
                    let (s, width) = (model.half_width(), spacing - 2.0 * model.half_width());
                    let x = s + width * (f64::from(k) + 0.5) / 400.0;
                    let seen = free([x, floor]) && {
                        // The cylinder at the origin itself may stand in the way.
                        let aside = -x * dir[1] + floor * dir[0];
                        let along = -x * dir[0] - floor * dir[1];
                        aside.abs() >= 1.0 || along < 0.0 || floor + along * dir[1] < floor - 1.0
                    };
                    let [left, right] = view.floor;
                    let near_edge = (x - left).abs().min((x - right).abs()) < 0.02 * spacing;
                    assert!(
                        width < 1e-9 || near_edge || seen == (x > left && x < right),
                        "d {spacing} h {floor} a {a} x {x}"
                    );
                }
            }
        }
    }

    /// White cylinders in closed form: the diffuse albedo is what is lit, and no more.
    #[test]
    fn a_bare_floor_is_lambert() {
        let model = PoulinFournier::new(3.0, 1.0, 0.7, 0.0, 1.0);
        let f = model.eval(direction(0.9, 1.0), direction(1.2, 3.0));
        assert!((f - 0.7 * FRAC_1_PI).abs() < 1e-12);
    }
}
