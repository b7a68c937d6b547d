//! NEF-BM: Beard-Maxwell as the Nonconventional Exploitation Factors database parametrises it.
//!
//! `f_r = R(beta) Xi(theta_h) SO / (4 cos_theta_i cos_theta_r) + rho_D + 2 rho_V / (cos_theta_i + cos_theta_r)`
//!
//! | parameter | meaning | unit | range |
//! |---|---|---|---|
//! | `distribution` | `cauchy` (default) or `gaussian` | | |
//! | `sigma` | width of the facet slopes | | 0.001 to 2 |
//! | `bias` | B, factor of the law; default: projected facet area 1 | | 1e-6 to 100 |
//! | `scan` | instead of a law: a tabulated zero-bistatic scan, see [`super::beard_maxwell`] | | |
//! | `n`, `k`, `material`, `tau`, `omega`, `rho_D`, `rho_V` | see [`super::beard_maxwell`] | | |
//!
//! Cauchy: `Xi = B / (cos_theta_h (sigma^2 + tan^2 theta_h))`; its projected area is 1 at
//! `B = a / (2 pi (artanh(sqrt a) / sqrt a - 1))`, `a = 1 - sigma^2`.
//! Gaussian: `Xi = B exp(-tan^2 theta_h / (2 sigma^2)) / (2 pi sigma^2 cos^3 theta_h)`, default `B = 1`.
//!
//! Energy: not conserving near grazing. For sigma 0.05, tau 0.25, omega 0.7 and n 1.5 the albedo is 0.031 at normal
//! incidence, 0.64 at 88 and 1.14 at 89 deg; with a perfect mirror's Fresnel term it is 4.0 there. `bounded=true` mends
//! it. Reciprocal.
//!
//! Sampling: facet normals in closed form mixed with the cosine; see [`super::beard_maxwell`].
//!
//! Sources: Westlund, Meyer, Hunt, J. Res. NIST 107, 247, 2002, section 3; forms of the laws: Shell 2005; Priest and Germer
//! 2000.

use super::beard_maxwell::{BeardMaxwell, OMEGA, RHO_D, RHO_V, SCAN, Shadowing, TAU_PARAMETER, Volume};
use super::facet_normals::{FacetNormals, cauchy_bias};
use super::parameter::{Parameter, Word};
use super::registry::Entry;
use super::smooth::{EXTINCTION, INDEX};
use super::zero_bistatic::ZeroBistatic;

/// Registry line.
pub static ENTRY: Entry = Entry {
    name: "nef-bm",
    summary: "Beard-Maxwell as the NEF database has it: Cauchy or Gaussian facets, or a scan, over a volume",
    formula: "f_r = R(beta) Xi(theta_h) SO/(4 cos_theta_i cos_theta_r) + rho_D + 2 rho_V/(cos_theta_i + cos_theta_r)",
    parameters: &[
        Parameter::number("sigma", "width of the facet slopes", 1e-3, 2.0).decades(0.01, 0.7),
        Parameter::number("bias", "factor B of the facet law", 1e-6, 100.0).decades(0.005, 1.0).optional(),
        INDEX,
        EXTINCTION,
        TAU_PARAMETER,
        OMEGA,
        RHO_D,
        RHO_V,
    ],
    words: &[
        Word { name: "distribution", meaning: "law of the facet normals", options: &["cauchy", "gaussian"] },
        SCAN,
    ],
    interface: true,
    exceeds_one: true,
    energy: "exceeds 1 near grazing (1.14 to 4.0 at 89 deg for sigma 0.05): shadowing has no limit there",
    source: "Westlund, Meyer, Hunt 2002, section 3; Shell 2005; Priest and Germer 2000",
    example: "nef-bm:sigma=0.05,n=1.5,tau=15deg,omega=40deg,rho_D=0.05,rho_V=0.01",
    build: |a| {
        let material = a.material()?;
        let normals = match (a.word("scan"), a.get("sigma")) {
            (Some(_), Some(_)) => return Err(a.error("give either `sigma` or `scan`, not both")),
            (Some(scan), None) => {
                let normal_reflectance = material.reflectance(1.0);
                if normal_reflectance <= 0.0 {
                    return Err(a.error("a material that reflects nothing at normal incidence has no facets to count"));
                }
                FacetNormals::Scan { scan: ZeroBistatic::parse(scan)?, normal_reflectance }
            }
            (None, _) => {
                let (sigma, bias) = (a.required("sigma")?, a.get("bias"));
                if a.word("distribution") == Some("gaussian") {
                    FacetNormals::Gaussian { sigma, bias: bias.unwrap_or(1.0) }
                } else {
                    FacetNormals::Cauchy { sigma, bias: bias.unwrap_or_else(|| cauchy_bias(sigma)) }
                }
            }
        };
        let shadowing = Shadowing { tau: a.required("tau")?, omega: a.required("omega")? };
        let volume = Volume { lambertian: a.required("rho_D")?, directional: a.required("rho_V")? };
        Ok(Box::new(BeardMaxwell::new(normals, material, shadowing, volume)))
    },
    ..Entry::PLAIN
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use crate::model::albedo::half_vector_average;
    use crate::model::parse;

    const SHAPE: &str = "sigma=0.05,tau=0.25rad,omega=0.7rad";

    /// Known defect of the unbounded form (TV39 at 89 deg with a mirror), and its cure.
    #[test]
    fn grazing_energy_unbounded_and_bounded() {
        let albedo = |text: &str, angle: f64| parse(text, 550e-9).unwrap().albedo(angle.to_radians());
        let glass = format!("nef-bm:{SHAPE},n=1.5");
        for (angle, e) in [(0.0, 0.031), (60.0, 0.064), (85.0, 0.338), (88.0, 0.644), (89.0, 1.143)] {
            let found = albedo(&glass, angle);
            assert!((found - e).abs() < 6e-4, "{angle}: {found} instead of {e}");
        }
        let mirror = format!("nef-bm:{SHAPE},material=mirror");
        assert!((albedo(&mirror, 85.0) - 1.19).abs() < 0.005, "{}", albedo(&mirror, 85.0));
        assert!((albedo(&mirror, 89.0) - 4.0212).abs() < 0.02, "{}", albedo(&mirror, 89.0));
        // The bounded albedo by the quadrature of the unbounded one.
        let normals = FacetNormals::Cauchy { sigma: 0.05, bias: 1.0 };
        for model in [&glass, &mirror] {
            let bounded = parse(&format!("{model},bounded=true"), 550e-9).unwrap();
            for angle in [0.0, 60.0, 85.0, 88.0, 89.0, 89.9] {
                let held = half_vector_average(
                    [1.0, 1.0],
                    direction(f64::to_radians(angle), 0.0),
                    |c| (normals.draw(c).powi(-2) - 1.0).max(0.0).sqrt(),
                    |t| normals.distribution(t),
                    |wh, wo| {
                        let wi = direction(f64::to_radians(angle), 0.0);
                        bounded.eval(wi, wo) * wo.z * 4.0 * wi.dot(wh) / normals.density(wh.z)
                    },
                );
                let free = albedo(model, angle);
                assert!(held <= free.min(1.0) + 1e-4, "{model} at {angle}: {held} against {free}");
                // Where nothing exceeds 1 nothing changes.
                assert!(angle > 60.0 || (held / free - 1.0).abs() < 0.05, "{model} at {angle}: {held} against {free}");
            }
        }
    }
}
