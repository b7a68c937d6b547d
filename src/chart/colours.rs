//! Colours for heights and for lines.

use super::raster::Colour;
use crate::render::picture::srgb;

/// Missing points: grey, which no height is.
pub const MISSING: Colour = [200, 200, 200];

/// Lines told apart by every kind of colour vision (Okabe and Ito 2008).
pub const BLUE: Colour = [0, 114, 178];
pub const ORANGE: Colour = [213, 94, 0];
pub const GREEN: Colour = [0, 130, 95];

/// Hue \[deg\] and chroma of the scale, evenly spaced from low to high.
const HUES: [(f64, f64); 5] = [(285.0, 0.10), (255.0, 0.11), (205.0, 0.10), (145.0, 0.14), (102.0, 0.17)];

/// Lightness of the lowest and of the highest height.
const LIGHTNESS: [f64; 2] = [0.22, 0.93];

/// Colour of a height at `share` of the scale, 0 to 1: dark violet over blue and green to yellow.
///
/// Lightness rises evenly in Oklab (Ottosson 2020), so that equal steps of height look equal and a grey print keeps their
/// order.
pub fn height_colour(share: f64) -> Colour {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let at = share * (HUES.len() - 1) as f64;
    let k = (at as usize).min(HUES.len() - 2);
    let mix = |a: f64, b: f64| a + (at - k as f64) * (b - a);
    let hue = mix(HUES[k].0, HUES[k + 1].0).to_radians();
    let chroma = mix(HUES[k].1, HUES[k + 1].1);
    let lightness = LIGHTNESS[0] + share * (LIGHTNESS[1] - LIGHTNESS[0]);
    oklab(lightness, chroma * hue.cos(), chroma * hue.sin()).map(|linear| (255.0 * srgb(linear)).round() as u8)
}

/// Linear sRGB of a colour in Oklab.
fn oklab(lightness: f64, a: f64, b: f64) -> [f64; 3] {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_rises_in_luminance_and_stays_coloured() {
        let luminance = |c: Colour| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
        let colours: Vec<Colour> = (0..=100).map(|k| height_colour(f64::from(k) / 100.0)).collect();
        assert!(colours.windows(2).all(|w| luminance(w[1]) >= luminance(w[0])));
        for c in colours {
            let (low, high) = (c.iter().min().unwrap(), c.iter().max().unwrap());
            assert!(high - low > 30, "{c:?} is grey");
        }
        assert_eq!(height_colour(f64::NAN), height_colour(-3.0));
    }

    /// White and black of Oklab.
    #[test]
    fn oklab_ends() {
        for (found, expected) in
            oklab(1.0, 0.0, 0.0).into_iter().chain(oklab(0.0, 0.0, 0.0)).zip([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        {
            assert!((found - expected).abs() < 1e-6);
        }
    }
}
