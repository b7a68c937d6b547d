//! Beard-Maxwell: facets counted by a zero-bistatic scan, with shadowing and obscuration, over a volume that depolarises.
//!
//! `f_r = R(beta) Xi(theta_h) SO / (4 cos_theta_i cos_theta_r) + rho_D + 2 rho_V / (cos_theta_i + cos_theta_r)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `scan` | zero-bistatic scan: `0:9.5;10:2.1;...` (deg, 1/sr) or a CSV file with `theta_deg,f_r_per_sr` | | required |
//! | `n`, `k` or `material` | interface | | see [`super::smooth`] |
//! | `tau` | bistatic angle over which shadowing fades in, default 0.25 rad | angle | 0.001 to 10 rad |
//! | `omega` | facet tilt beyond which obscuration is complete, default 0.7 rad | angle | 0.001 to 100 rad |
//! | `rho_D` | Lambertian volume scatter | 1/sr | 0 to 1 / pi |
//! | `rho_V` | directional volume scatter | 1/sr | 0 to 0.1 |
//!
//! `Xi(theta_h) = 4 f_zb(theta_h) cos^2 theta_h / R(0)`, `SO = (1 + (theta_h / Omega) exp(-2 beta / tau)) / (1 + theta_h /
//! Omega)`. `rho_D` and `rho_V` are BRDF values, not divided by pi: a volume alone has the albedo `pi rho_D + 4 pi rho_V
//! (1 - cos_theta_i ln(1 + 1 / cos_theta_i))`.
//!
//! Energy: not conserving near grazing, where `1 / (cos_theta_i cos_theta_r)` grows without bound and SO does not fade;
//! `bounded=true` mends it. Reciprocal.
//!
//! Sampling: a facet or a cosine-weighted direction, with the probability of their albedos; pdf of the mixture. The tilt
//! of the facet follows its law, its azimuth the area it shows to the source, `(a + b cos phi)+` with `a = cos_theta_i
//! cos_theta_h`, `b = sin_theta_i sin_theta_h`.
//!
//! Sources: Maxwell, Beard, Weiner, Ladd, Bidirectional model validation and utilization, AFAL-TR-73-303, 1973; Westlund, Meyer, Hunt, J.
//! Res. NIST 107, 247, 2002, equations 3 and 4. The further shape functions of the report's volume term are not in it.

use super::albedo::{AlbedoTable, half_vector_average};
use super::facet_normals::FacetNormals;
use super::lambert::cosine_direction;
use super::parameter::{Parameter, Unit, Word};
use super::registry::Entry;
use super::smooth::{EXTINCTION, INDEX};
use super::zero_bistatic::ZeroBistatic;
use crate::math::{direction, half_vector, reflect};
use crate::optics::{Brdf, BrdfSample, Material};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::sync::OnceLock;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "beard-maxwell",
    summary: "facets counted by a zero-bistatic scan, over a volume that depolarises",
    formula: "f_r = R(beta)/R(0) f_zb(theta_h) cos^2 theta_h SO/(cos_theta_i cos_theta_r) + rho_D + 2 rho_V/(cos_theta_i + cos_theta_r)",
    parameters: &[INDEX, EXTINCTION, TAU_PARAMETER, OMEGA, RHO_D, RHO_V],
    words: &[SCAN],
    interface: true,
    exceeds_one: true,
    energy: "exceeds 1 near grazing: shadowing has no limit there",
    source: "Maxwell, Beard, Weiner, Ladd 1973; Westlund, Meyer, Hunt 2002, equations 3-4",
    example: "beard-maxwell:scan=0:0.12;5:0.05;15:0.008;40:0.001;80:0.0003,n=1.5,rho_D=0.05",
    build: |a| {
        let scan = a.word("scan").ok_or_else(|| a.error("`scan` is missing"))?;
        let scan = ZeroBistatic::parse(scan)?;
        let material = a.material()?;
        let normal_reflectance = material.reflectance(1.0);
        if normal_reflectance <= 0.0 {
            return Err(a.error("a material that reflects nothing at normal incidence has no facets to count"));
        }
        let normals = FacetNormals::Scan { scan, normal_reflectance };
        let shadowing = Shadowing { tau: a.required("tau")?, omega: a.required("omega")? };
        let volume = Volume { lambertian: a.required("rho_D")?, directional: a.required("rho_V")? };
        Ok(Box::new(BeardMaxwell::new(normals, material, shadowing, volume)))
    },
    ..Entry::PLAIN
};

/// Parameter `tau`.
pub const TAU_PARAMETER: Parameter =
    Parameter::number("tau", "bistatic angle over which shadowing fades in", 1e-3, 10.0)
        .unit(Unit::Angle)
        .decades(0.05, 2.0)
        .or(0.25);
/// Parameter `omega`.
pub const OMEGA: Parameter = Parameter::number("omega", "facet tilt at which obscuration is half", 1e-3, 100.0)
    .unit(Unit::Angle)
    .decades(0.1, 5.0)
    .or(0.7);
/// Parameter `rho_D`.
pub const RHO_D: Parameter =
    Parameter::number("rho_D", "Lambertian volume scatter", 0.0, FRAC_1_PI).unit(Unit::PerSteradian).or(0.0);
/// Parameter `rho_V`.
pub const RHO_V: Parameter =
    Parameter::number("rho_V", "directional volume scatter", 0.0, 0.1).unit(Unit::PerSteradian).or(0.0);
/// Word `scan`.
pub const SCAN: Word =
    Word { name: "scan", meaning: "zero-bistatic scan, deg:1/sr;deg:1/sr;... or a CSV file", options: &[] };

/// `SO = (1 + (theta_h / Omega) exp(-2 beta / tau)) / (1 + theta_h / Omega)`; both angles in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shadowing {
    pub tau: f64,
    pub omega: f64,
}

impl Shadowing {
    /// `SO` for a facet at `theta_h` lit at `beta` \[rad\]; 1 if either is 0.
    #[inline]
    pub fn at(&self, theta_h: f64, beta: f64) -> f64 {
        let tilt = theta_h / self.omega;
        (1.0 + tilt * (-2.0 * beta / self.tau).exp()) / (1.0 + tilt)
    }
}

/// `rho_D + 2 rho_V / (cos_theta_i + cos_theta_r)` [1/sr].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// `rho_D` [1/sr].
    pub lambertian: f64,
    /// `rho_V` [1/sr].
    pub directional: f64,
}

impl Volume {
    /// `f_r` [1/sr].
    #[inline]
    pub fn at(&self, ci: f64, co: f64) -> f64 {
        self.lambertian + 2.0 * self.directional / (ci + co)
    }

    /// `pi rho_D + 4 pi rho_V (1 - ci ln(1 + 1 / ci))`.
    pub fn albedo(&self, ci: f64) -> f64 {
        let rest = if ci > 0.0 { ci * (1.0 / ci).ln_1p() } else { 0.0 };
        PI * self.lambertian + 4.0 * PI * self.directional * (1.0 - rest)
    }
}

/// Facets of any law over a volume: what Beard-Maxwell and NEF-BM share.
#[derive(Debug, Clone)]
pub struct BeardMaxwell {
    normals: FacetNormals,
    material: Material,
    shadowing: Shadowing,
    volume: Volume,
    /// Smooth law over which the albedo is integrated: that of the facets, or one as wide as their scan.
    smooth: FacetNormals,
    first_surface: OnceLock<AlbedoTable>,
}

/// Azimuths of facets of one tilt by the area they show to the source: density `(a + b cos phi)+`.
struct Facing {
    a: f64,
    b: f64,
    /// Where the facets turn away.
    limit: f64,
}

impl Facing {
    fn new(a: f64, b: f64) -> Self {
        Facing { a, b, limit: if a >= b { PI } else { (-a / b).acos() } }
    }

    /// `int_0^phi a + b cos`.
    fn up_to(&self, phi: f64) -> f64 {
        self.a * phi + self.b * phi.sin()
    }

    /// Integral of the density over all azimuths.
    fn whole(&self) -> f64 {
        2.0 * self.up_to(self.limit)
    }

    /// Azimuth of the draw `u` in `[0, 1)`, from the source's: Newton's method on one half, kept between bounds.
    fn draw(&self, u: f64) -> f64 {
        let side = 2.0 * u - 1.0;
        let wanted = side.abs() * self.up_to(self.limit);
        let (mut low, mut high) = (0.0, self.limit);
        let mut phi = side.abs() * self.limit;
        for _ in 0..60 {
            let excess = self.up_to(phi) - wanted;
            if excess > 0.0 {
                high = phi;
            } else {
                low = phi;
            }
            let newton = phi - excess / (self.a + self.b * phi.cos());
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            let step = (next - phi).abs();
            phi = next;
            if step < 1e-9 {
                break;
            }
        }
        phi.copysign(side)
    }
}

/// Neither branch of the sampler gets less than this, if both reflect at all.
const LEAST_SHARE: f64 = 0.1;

impl BeardMaxwell {
    /// The model; `tau` and `omega` above 0.
    pub fn new(normals: FacetNormals, material: Material, shadowing: Shadowing, volume: Volume) -> Self {
        let smooth = match &normals {
            FacetNormals::Scan { scan, .. } => FacetNormals::Cauchy { sigma: scan.half_width(), bias: 1.0 },
            law => law.clone(),
        };
        BeardMaxwell { normals, material, shadowing, volume, smooth, first_surface: OnceLock::new() }
    }

    /// First surface alone, `R(beta) Xi SO / (4 cos_theta_i cos_theta_r)` [1/sr], both directions above the surface.
    fn facets(&self, wi: DVec3, wo: DVec3) -> f64 {
        let wh = half_vector(wi, wo);
        let cos_beta = wi.dot(wh).min(1.0);
        let theta_h = wh.z.min(1.0).acos();
        let xi = self.normals.xi_at(wh.z.min(1.0), theta_h);
        self.material.reflectance(cos_beta) * xi * self.shadowing.at(theta_h, cos_beta.acos()) / (4.0 * wi.z * wo.z)
    }

    /// Albedo of the first surface by quadrature.
    fn first_surface(&self, wi: DVec3) -> f64 {
        half_vector_average(
            [1.0, 1.0],
            wi,
            |c| {
                let cos = self.smooth.draw(c);
                (1.0 - cos * cos).max(0.0).sqrt() / cos
            },
            |t| self.smooth.distribution(t),
            |wh, wo| self.facets(wi, wo) * wo.z * 4.0 * wi.dot(wh) / self.smooth.density(wh.z),
        )
    }

    /// [`Brdf::albedo`] at one angle \[rad\], without the table of all.
    pub fn integrated(&self, theta_i: f64) -> f64 {
        self.first_surface(direction(theta_i, 0.0)) + self.volume.albedo(theta_i.cos().max(0.0))
    }

    /// Probability of drawing a facet rather than a direction of the volume.
    fn facet_share(&self, ci: f64) -> f64 {
        let first = self.normals.strength() * self.material.reflectance(ci);
        let volume = self.volume.albedo(ci);
        if first <= 0.0 {
            0.0
        } else if volume <= 0.0 {
            1.0
        } else {
            (first / (first + volume)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        }
    }
}

impl Brdf for BeardMaxwell {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.facets(wi, wo) + self.volume.at(wi.z, wo.z)
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let share = self.facet_share(wi.z);
        // The number that chose the branch is stretched back to [0, 1) and used again.
        let wo = if u[0] < share {
            let c = self.normals.draw(u[0] / share);
            let s = (1.0 - c * c).max(0.0).sqrt();
            let across = wi.x.hypot(wi.y);
            let (sin, cos) = Facing::new(wi.z * c, across * s).draw(u[1]).sin_cos();
            // Turned by the azimuth of the source.
            let (x, y) = if across > 0.0 { (wi.x / across, wi.y / across) } else { (1.0, 0.0) };
            reflect(wi, DVec3::new(s * (cos * x - sin * y), s * (cos * y + sin * x), c))
        } else {
            cosine_direction([(u[0] - share) / (1.0 - share), u[1]])
        };
        if wo.z <= 0.0 {
            return None;
        }
        let pdf = self.pdf(wi, wo);
        (pdf > 0.0).then(|| BrdfSample { wo, weight: self.eval(wi, wo) * wo.z / pdf, pdf, specular: false })
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let share = self.facet_share(wi.z);
        let c = half_vector(wi, wo).z.min(1.0);
        let facing = Facing::new(wi.z * c, wi.x.hypot(wi.y) * (1.0 - c * c).max(0.0).sqrt());
        // The area shown to the source cancels the Jacobian 4 cos_beta.
        share * self.normals.density(c) * TAU / (4.0 * facing.whole()) + (1.0 - share) * wo.z * FRAC_1_PI
    }

    /// First surface by quadrature, volume in closed form.
    fn albedo(&self, theta_i: f64) -> f64 {
        let table = self.first_surface.get_or_init(|| AlbedoTable::new(1, |wi| self.first_surface(wi)));
        table.at(theta_i) + self.volume.albedo(theta_i.cos().max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::parse;

    /// TV37.
    #[test]
    fn shadowing_vector() {
        let so = Shadowing { tau: 0.25, omega: 0.7 };
        let r = f64::to_radians;
        assert!((so.at(r(10.0), r(40.0)) - 0.801176373832).abs() < 1e-10);
        assert_eq!((so.at(0.0, 1.0), so.at(1.0, 0.0)), (1.0, 1.0));
    }

    /// Volume albedo 3.85602625314 rho_V at normal incidence, 4 pi rho_V at grazing.
    #[test]
    fn volume_albedo_vectors() {
        let v = Volume { lambertian: 0.0, directional: 1.0 };
        assert!((v.albedo(1.0) - 3.85602625314).abs() < 1e-10);
        assert!((v.albedo(0.0) - 4.0 * PI).abs() < 1e-12);
        let both = Volume { lambertian: 0.1, directional: 0.02 };
        // Against a plain sum over the hemisphere.
        let (ci, n) = (0.3, 20000);
        let sum: f64 = (0..n)
            .map(|k| (f64::from(k) + 0.5) / f64::from(n))
            .map(|co| TAU * co * both.at(ci, co) / f64::from(n))
            .sum();
        assert!((sum / both.albedo(ci) - 1.0).abs() < 1e-6);
    }

    /// In the zero-bistatic geometry the model returns the scan it was made from, whatever tau and omega.
    #[test]
    fn returns_its_own_scan() {
        let text = "beard-maxwell:scan=0:9;10:2;30:0.2;80:0.01,material=al,tau=0.2rad,omega=20deg";
        let brdf = parse(text, 550e-9).unwrap();
        for (angle, f) in [(0.0, 9.0), (10.0, 2.0), (30.0, 0.2), (80.0, 0.01)] {
            let w = direction(f64::to_radians(angle), 0.4);
            assert!((brdf.eval(w, w) / f - 1.0).abs() < 1e-7, "{angle}: {}", brdf.eval(w, w));
        }
    }
}
