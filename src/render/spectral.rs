//! Spectra to the three channels of a picture: a BRDF at seven wavelengths, weighed by the CIE 1931 observer.
//!
//! `f_r,RGB = M sum over wavelengths of xyz(lambda) f_r(lambda)` under D65, with `M` from XYZ to linear sRGB (IEC 61966-2-1);
//! white is `(1, 1, 1)`. Between the seven wavelengths `f_r` is taken as linear, beyond the first and last as constant.

use super::shares::Shares;
use crate::error::Result;
use crate::optics::colour::{self, Illuminant, nodes};
use crate::optics::{Brdf, BrdfSample};
use glam::{DMat3, DVec3};

/// Wavelengths at which a spectral BRDF is asked \[m\]: from where the eye begins to see to where it ends.
const WAVELENGTHS: [f64; 7] = [430e-9, 465e-9, 500e-9, 535e-9, 570e-9, 605e-9, 645e-9];

/// Layers of BRDFs, such as one per wavelength, with the share of each in red, green and blue.
pub struct Spectral {
    parts: Vec<(Box<dyn Brdf>, DVec3)>,
    shares: Shares,
}

/// A direction drawn by [`Spectral::sample`].
pub(super) struct ColourDraw {
    pub wo: DVec3,
    pub weight: DVec3,
    pub pdf: f64,
    pub specular: bool,
}

impl From<BrdfSample> for ColourDraw {
    #[inline(always)]
    fn from(draw: BrdfSample) -> Self {
        ColourDraw { wo: draw.wo, weight: DVec3::splat(draw.weight), pdf: draw.pdf, specular: draw.specular }
    }
}

impl Spectral {
    /// Builds the BRDF at every wavelength \[m\] by `build`.
    ///
    /// # Errors
    /// Those of `build`.
    pub fn new(build: &dyn Fn(f64) -> Result<Box<dyn Brdf>>) -> Result<Self> {
        let parts = weights().into_iter().map(|(wavelength, rgb)| Ok((build(wavelength)?, rgb)));
        Ok(Self::sum(vec![parts.collect::<Result<_>>()?]))
    }

    /// The sum of layers, each the sum of BRDFs with their shares in red, green and blue. Sampling draws from
    /// every layer by the root of the energy that it sends out, its specular core included.
    pub fn sum(layers: Vec<Vec<(Box<dyn Brdf>, DVec3)>>) -> Self {
        // Shares of one layer may cancel, as those of X, Y and Z do: they divide what the layer as a whole makes of white.
        let grey = |rgb: DVec3| rgb.abs().element_sum() / 3.0;
        let weighed = layers.iter().map(|layer| {
            let white = grey(layer.iter().map(|part| part.1).sum());
            let total: f64 = layer.iter().map(|part| grey(part.1)).sum();
            let of_white = white / total.max(f64::MIN_POSITIVE);
            layer.iter().map(|(brdf, rgb)| (&**brdf, of_white * grey(*rgb))).collect()
        });
        let shares = Shares::new(&weighed.collect::<Vec<_>>());
        Spectral { parts: layers.into_iter().flatten().collect(), shares }
    }

    /// `f_r` per channel and the density of [`Self::sample`], the mean of those of the parts by their shares.
    #[inline]
    pub(super) fn eval_and_pdf(&self, wi: DVec3, wo: DVec3) -> (DVec3, f64) {
        let (mut colour, mut density) = (DVec3::ZERO, 0.0);
        for ((brdf, rgb), share) in self.parts.iter().zip(self.shares.at(wi.z)) {
            let (f_r, pdf) = brdf.eval_and_pdf(wi, wo);
            colour += f_r * *rgb;
            density += share * pdf;
        }
        (colour, density)
    }

    /// Draws by one part, counts for all.
    #[inline]
    pub(super) fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<ColourDraw> {
        let (chosen, rest) = self.shares.choose(wi.z, u[0]);
        let brdf = &self.parts[chosen].0;
        let draw = brdf.sample(wi, [rest, u[1]])?;
        if draw.specular {
            // Drawn with its own probability p, weight core / p: scaled to the core of all parts, each of which with a core
            // may have drawn it.
            let cored = self.parts.iter().zip(self.shares.at(wi.z)).filter(|(part, _)| part.0.specular_core(wi) > 0.0);
            let chance: f64 = cored.map(|(_, share)| share).sum();
            let weight = self.specular_core(wi) * (draw.weight / (brdf.specular_core(wi) * chance));
            return Some(ColourDraw { wo: draw.wo, weight, pdf: f64::INFINITY, specular: true });
        }
        let (f_r, pdf) = self.eval_and_pdf(wi, draw.wo);
        (pdf > 0.0).then(|| ColourDraw { wo: draw.wo, weight: f_r * (draw.wo.z / pdf), pdf, specular: false })
    }

    /// Reflectance of the specular core per channel.
    pub(super) fn specular_core(&self, wi: DVec3) -> DVec3 {
        self.parts.iter().map(|(brdf, rgb)| brdf.specular_core(wi) * *rgb).sum()
    }

    /// Directional-hemispherical reflectance per channel.
    pub(super) fn albedo(&self, theta_i: f64) -> DVec3 {
        self.parts.iter().map(|(brdf, rgb)| brdf.albedo(theta_i) * *rgb).sum()
    }
}

/// From X, Y, Z to linear sRGB (IEC 61966-2-1).
fn to_srgb() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(3.240_454_2, -0.969_266_0, 0.055_643_4),
        DVec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
        DVec3::new(-0.498_531_4, 0.041_556_0, 1.057_225_2),
    )
}

/// Linear sRGB of X, Y, Z under D65, Y = 1 for white; negative channels outside of sRGB.
pub fn to_linear_srgb(xyz: DVec3) -> DVec3 {
    to_srgb() * xyz
}

/// Linear sRGB of each tristimulus value of the perfect diffuser under D65; together they are exactly white.
pub fn tristimulus_shares() -> [DVec3; 3] {
    let white = colour::white(Illuminant::D65);
    let shares = [0, 1, 2].map(|k| white[k] * to_srgb().col(k));
    // Whatever the rounding of the matrix.
    let sum: DVec3 = shares.iter().sum();
    shares.map(|share| share / sum)
}

/// Share of a reflectance at each wavelength in linear sRGB.
fn weights() -> Vec<(f64, DVec3)> {
    let matrix = to_srgb();
    let last = WAVELENGTHS.len() - 1;
    let mut sums = [DVec3::ZERO; WAVELENGTHS.len()];
    for node in nodes(Illuminant::D65) {
        let rgb = matrix * DVec3::from(node.xyz);
        let after = WAVELENGTHS.partition_point(|&w| w < node.wavelength).clamp(1, last);
        let (low, high) = (WAVELENGTHS[after - 1], WAVELENGTHS[after]);
        let t = ((node.wavelength - low) / (high - low)).clamp(0.0, 1.0);
        sums[after - 1] += (1.0 - t) * rgb;
        sums[after] += t * rgb;
    }
    // Exactly white, whatever the rounding of the matrix and the step of the table.
    let white: DVec3 = sums.iter().sum();
    WAVELENGTHS.into_iter().zip(sums).map(|(w, rgb)| (w, rgb / white)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction;
    use crate::model;

    /// Colour of a mirror of metal by all wavelengths of the observer's table.
    fn all_wavelengths(material: &str) -> DVec3 {
        let white = crate::optics::colour::white(Illuminant::D65);
        let mut xyz = DVec3::ZERO;
        for node in nodes(Illuminant::D65) {
            let brdf = model::parse(&format!("conductor:material={material}"), node.wavelength).unwrap();
            xyz += brdf.albedo(0.0) * DVec3::from(node.xyz);
        }
        // Primaries and white of IEC 61966-2-1: the matrix from chromaticities, not from the constants above.
        let column = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let primaries = DMat3::from_cols(column(0.64, 0.33), column(0.30, 0.60), column(0.15, 0.06));
        let scale = primaries.inverse() * DVec3::from(white);
        (primaries.inverse() * xyz) / scale
    }

    #[test]
    fn metals_have_the_colour_of_the_whole_spectrum() {
        for material in ["au", "cu", "al", "fe"] {
            let build = |w: f64| model::parse(&format!("conductor:material={material}"), w);
            let seven = Spectral::new(&build).unwrap().albedo(0.0);
            let all = all_wavelengths(material);
            assert!((seven - all).abs().max_element() < 0.012, "{material}: {seven} against {all}");
        }
    }

    #[test]
    fn a_grey_reflectance_stays_grey_and_draws_integrate_to_the_albedo() {
        let grey = Spectral::new(&|w| model::parse("lambert:rho=0.4", w)).unwrap();
        assert!((grey.albedo(0.3) - DVec3::splat(0.4)).abs().max_element() < 1e-12);
        let copper = Spectral::new(&|w| model::parse("ggx:alpha=0.3,material=cu", w)).unwrap();
        let smooth = Spectral::new(&|w| model::parse("conductor:material=cu", w)).unwrap();
        let wi = direction(0.6, 0.2);
        for brdf in [&copper, &smooth] {
            let n = 1 << 14;
            let mut sum = DVec3::ZERO;
            for k in 0..n {
                let u = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|a| (0.5 + a * f64::from(k)).fract());
                sum += brdf.sample(wi, u).map_or(DVec3::ZERO, |d| d.weight);
            }
            let (mean, albedo) = (sum / f64::from(n), brdf.albedo(0.6));
            assert!((mean - albedo).abs().max_element() < 5e-3, "{mean} against {albedo}");
        }
    }
}
