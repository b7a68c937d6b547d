//! A goniometer in numbers: the scans that a planted material would give.

use super::material::Material;
use super::scans::{Bistatic, Polarisation, Scans, Specular, ZeroBistaticRow};
use crate::error::{Error, Result};
use crate::math::Estimate;
use crate::math::random::CounterRng;
use crate::model::beard_maxwell::{Shadowing, Volume};
use crate::model::facet_normals::{FacetNormals, cauchy_bias};
use crate::model::{Definition, Parameter};

/// Gaussian noise of the detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// As a share of the value.
    pub share: f64,
    /// Everywhere [1/sr].
    pub floor: f64,
    pub seed: u64,
}

/// Random stream of the noise.
const STREAM: u32 = 0x6e65;

/// Scans of a `nef-bm` material with a Cauchy or Gaussian law: zero-bistatic 0 to 80 deg, specular within 5 deg at 20,
/// 40, 60 deg in s and p, fixed bistatic at beta 20, 30, 40 deg.
///
/// # Errors
/// `Error::Parameter` if the definition is another model or lacks a number.
pub fn simulate(planted: &Definition, noise: Noise) -> Result<Scans> {
    let material = material_of(planted)?;
    let mut rng = CounterRng::new(noise.seed, STREAM, 0);
    let mut seen = |value: f64| {
        let standard_error = noise.share * value + noise.floor;
        let [normal, _] = rng.normal_pair();
        Estimate { value: value + standard_error * normal, standard_error }
    };
    let mut scans = Scans::default();
    // Steps of half a degree near the lobe, of two beyond.
    let fine = (0..20).map(|k| 0.5 * f64::from(k));
    for theta in fine.chain((5..=40).map(|k| 2.0 * f64::from(k))).map(f64::to_radians) {
        let [first, half] = material.zero_bistatic(theta);
        scans.zero_bistatic.push(ZeroBistaticRow { theta, co: seen(first + half), cross: seen(half) });
    }
    for theta_i in [20.0, 40.0, 60.0] {
        for polarisation in [Polarisation::S, Polarisation::P] {
            for step in -10..=10 {
                let theta_r = f64::to_radians(theta_i + 0.5 * f64::from(step));
                let mut row =
                    Specular { theta_i: theta_i.to_radians(), theta_r, polarisation, f_r: Estimate::exact(0.0) };
                row.f_r = seen(material.specular(&row));
                scans.specular.push(row);
            }
        }
    }
    for beta in [20.0, 30.0, 40.0] {
        for theta_h in (0..=22).map(|k| 2.0 * f64::from(k)).filter(|t| t + beta <= 84.0) {
            let none = Estimate::exact(0.0);
            let mut row =
                Bistatic { beta: f64::to_radians(beta), theta_h: f64::to_radians(theta_h), co: none, cross: none };
            let [first, half] = material.bistatic(&row);
            (row.co, row.cross) = (seen(first + half), seen(half));
            scans.bistatic.push(row);
        }
    }
    Ok(scans)
}

fn material_of(planted: &Definition) -> Result<Material> {
    let bad = |what: String| Error::parameter(what, "write for example nef-bm:sigma=0.05,n=1.5,tau=15deg,omega=40deg");
    if planted.entry().name != "nef-bm" {
        return Err(bad(format!("`{planted}` cannot be simulated: the protocol is that of nef-bm")));
    }
    // Whatever the model itself refuses is refused here too.
    planted.build(550e-9)?;
    let default = |name: &str| planted.entry().parameters.iter().find(|p| p.name == name).and_then(Parameter::default);
    let number = |name: &str| {
        planted.get(name).or_else(|| default(name)).ok_or_else(|| bad(format!("`{name}` of `{planted}` is missing")))
    };
    let sigma = number("sigma")?;
    let bias = planted.get("bias");
    let normals = match planted.word("distribution") {
        Some("gaussian") => FacetNormals::Gaussian { sigma, bias: bias.unwrap_or(1.0) },
        _ => FacetNormals::Cauchy { sigma, bias: bias.unwrap_or_else(|| cauchy_bias(sigma)) },
    };
    Ok(Material {
        n: number("n")?,
        k: planted.get("k").unwrap_or(0.0),
        normals,
        shadowing: Shadowing { tau: number("tau")?, omega: number("omega")? },
        volume: Volume { lambertian: number("rho_D")?, directional: number("rho_V")? },
    })
}
