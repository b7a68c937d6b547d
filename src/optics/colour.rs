//! Spectra to colour: the CIE 1931 observer, illuminants, CIELAB.

use crate::error::{Error, Result};

/// Colour-matching functions of the CIE 1931 standard observer and the illuminants A, C, D65, 380-780 nm in 5 nm steps.
/// CIE 018:2019 and CIE 015:2018, as tabulated in colour-science (C interpolated from 10 nm to 5 nm there).
const TABLE: &str = include_str!("cie_1931_5nm.csv");

/// Step of the sums over wavelengths, in rows of the table: 10 nm, the narrower of the two intervals of ASTM E308.
const STEP: usize = 2;

/// What the light of the source is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Illuminant {
    /// Equal energy.
    E,
    /// Tungsten lamp, 2856 K.
    A,
    /// Average daylight, the light of ISO 2813.
    C,
    /// Daylight, 6504 K.
    D65,
}

impl Illuminant {
    /// Reads `E`, `A`, `C` or `D65`.
    ///
    /// # Errors
    /// `Error::Parameter` for any other name.
    pub fn parse(name: &str) -> Result<Self> {
        match name.to_ascii_lowercase().as_str() {
            "e" => Ok(Illuminant::E),
            "a" => Ok(Illuminant::A),
            "c" => Ok(Illuminant::C),
            "d65" => Ok(Illuminant::D65),
            _ => Err(Error::parameter(format!("illuminant `{name}` is unknown"), "write E, A, C or D65")),
        }
    }
}

/// One wavelength of a sum: its share in X, Y and Z. The Y of all sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// \[m\]
    pub wavelength: f64,
    pub xyz: [f64; 3],
}

/// Weights of the wavelengths under `illuminant` for the CIE 1931 observer: `X = sum x_k R_k`, and so on; a perfect
/// diffuser has Y = 1.
pub fn nodes(illuminant: Illuminant) -> Vec<Node> {
    let mut nodes: Vec<Node> = TABLE
        .lines()
        .skip(1)
        .step_by(STEP)
        .map(|line| {
            let v: Vec<f64> = line.split(',').map(|f| f.parse().expect("the embedded table is complete")).collect();
            let light = match illuminant {
                Illuminant::E => 1.0,
                Illuminant::A => v[4],
                Illuminant::C => v[5],
                Illuminant::D65 => v[6],
            };
            Node { wavelength: v[0] * 1e-9, xyz: [1, 2, 3].map(|k| light * v[k]) }
        })
        .collect();
    let y: f64 = nodes.iter().map(|n| n.xyz[1]).sum();
    nodes.iter_mut().for_each(|n| n.xyz = n.xyz.map(|x| x / y));
    nodes
}

/// Tristimulus values of the perfect diffuser.
pub fn white(illuminant: Illuminant) -> [f64; 3] {
    nodes(illuminant).iter().fold([0.0; 3], |sum, n| [0, 1, 2].map(|k| sum[k] + n.xyz[k]))
}

/// `L* = 116 f(Y/Yn) - 16`, `a* = 500 (f(X/Xn) - f(Y/Yn))`, `b* = 200 (f(Y/Yn) - f(Z/Zn))`, `f = t^(1/3)` above
/// (24/116)^3, linear below (CIE 015:2018, section 8.2.1).
pub fn lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let f = |k: usize| {
        let t = xyz[k] / white[k];
        if t > (24f64 / 116.0).powi(3) { t.cbrt() } else { 841.0 / 108.0 * t + 16.0 / 116.0 }
    };
    [116.0 * f(1) - 16.0, 500.0 * (f(0) - f(1)), 200.0 * (f(1) - f(2))]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White points as computed by colour-science from 5 nm tables.
    #[test]
    fn white_points() {
        for (illuminant, want) in [
            (Illuminant::A, [1.09849, 1.0, 0.355825]),
            (Illuminant::C, [0.980717, 1.0, 1.182249]),
            (Illuminant::D65, [0.950430, 1.0, 1.088801]),
        ] {
            // 10 nm steps against 5 nm.
            assert!(white(illuminant).iter().zip(want).all(|(a, b)| (a - b).abs() < 2e-3), "{:?}", white(illuminant));
        }
        assert!(Illuminant::parse("d50").unwrap_err().to_string().contains("D65"));
    }

    /// colour-science: XYZ 0.20654008 0.12197225 0.05136952 under D65 is L* 41.52787529, a* 52.63858304, b* 26.92317922.
    #[test]
    fn lab_of_a_red() {
        let got = lab([0.20654008, 0.12197225, 0.05136952], [0.3127 / 0.329, 1.0, 0.3583 / 0.329]);
        for (a, b) in got.iter().zip([41.52787529, 52.63858304, 26.92317922]) {
            assert!((a - b).abs() < 1e-4, "{got:?}");
        }
        let black = lab([0.0; 3], [0.95, 1.0, 1.09]);
        assert!(black.iter().all(|v| v.abs() < 1e-12));
    }
}
