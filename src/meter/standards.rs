//! The instruments of the appearance standards by name.
//!
//! Angles of incidence and of the receptors' axes are those of the standards. Part of the stops could not be checked against
//! the text of a standard; where `about` says recalled or chosen, the number is a parameter to be replaced by anyone
//! who has the text: print the instrument as TOML, change it, read it back.

use super::instrument::{Instrument, Standard};
use super::stop::Shape;

fn rectangle(in_plane: f64, across: f64) -> Shape {
    Shape::Rectangle([in_plane.to_radians(), across.to_radians()])
}

fn gloss(name: &str, theta_i: f64, source: [f64; 2], receptor: Shape) -> Instrument {
    Instrument::gloss(name, theta_i.to_radians(), source.map(f64::to_radians), receptor)
}

fn deg(angle: f64) -> f64 {
    angle.to_radians()
}

/// Source stop of ISO 2813 and ASTM D523 in degrees, in the plane of measurement and across it.
const SOURCE: [f64; 2] = [0.75, 2.5];

/// Aspecular angles of the metallic instruments \[deg\], from the mirror direction of 45 deg towards the normal.
const THREE: [f64; 3] = [15.0, 45.0, 110.0];
const FIVE: [f64; 5] = [15.0, 25.0, 45.0, 75.0, 110.0];

fn metallic(name: &str, aspecular: &[f64]) -> Instrument {
    let receptor = Shape::Disc(deg(4.0));
    let mut meter = gloss(name, 45.0, [4.0, 4.0], receptor);
    meter.source = receptor;
    meter.standard = Standard::WhiteDiffuser;
    meter.receptors.clear();
    for gamma in aspecular {
        meter = meter.and(&format!("{gamma}"), deg(45.0 - gamma), receptor);
    }
    meter
}

/// Every named instrument, in the order in which they are listed.
pub fn instruments() -> Vec<Instrument> {
    let tappi =
        |meter: Instrument| Instrument { standard: Standard::Glass { index: 1.540, through: "gloss".into() }, ..meter };
    vec![
        gloss("gloss-20", 20.0, SOURCE, rectangle(1.8, 3.6)).about(
            "Gloss at 20 deg, high gloss (ISO 2813, ASTM D523). Source stop recalled; receptor from instrument \
             specifications that quote ISO 2813, its width also from ISO 13803.",
        ),
        gloss("gloss-60", 60.0, SOURCE, rectangle(4.4, 11.7)).about(
            "Gloss at 60 deg, the general one (ISO 2813, ASTM D523). Source stop recalled; receptor from instrument \
             specifications that quote ISO 2813.",
        ),
        gloss("gloss-85", 85.0, SOURCE, rectangle(4.0, 6.0)).about(
            "Gloss at 85 deg, low gloss (ISO 2813, ASTM D523). Source stop recalled; receptor from instrument \
             specifications that quote ISO 2813.",
        ),
        gloss("gloss-45", 45.0, [1.4, 3.0], rectangle(8.0, 10.0))
            .about("Gloss at 45 deg of ceramics and films (ASTM C346, D2457). Both stops recalled."),
        tappi(gloss("gloss-75", 75.0, SOURCE, Shape::Disc(deg(11.4)))).about(
            "Gloss at 75 deg of paper (TAPPI T480, ASTM D1223), 100 = flat glass of n = 1.540, so that a mirror reads \
             384. Stops chosen: the standard's converging beam is taken as a parallel one.",
        ),
        tappi(gloss("gloss-20-paper", 20.0, SOURCE, Shape::Disc(deg(5.0)))).about(
            "Gloss at 20 deg of paper (TAPPI T653), 100 = flat glass of n = 1.540; round receptor of 5 deg from the \
             standard, source stop chosen.",
        ),
        gloss("haze-20", 20.0, SOURCE, rectangle(1.8, 3.6))
            .and("haze", deg(18.1), rectangle(1.8, 5.5))
            .and("haze", deg(21.9), rectangle(1.8, 5.5))
            .about(
                "Reflection haze beside 20 deg (ASTM E430 method B, ISO 13803): the flux of two receptors, at 18.1 and \
                 21.9 deg, added; 100 = what the gloss standard sends through the gloss receptor. Their size of 1.8 by \
                 5.5 deg is recalled. Being a sum of two, haze may exceed 100.",
            ),
        gloss("haze-30", 30.0, [0.44, 2.5], rectangle(0.44, 3.0))
            .and("haze 2 deg", deg(28.0), rectangle(0.44, 3.0))
            .and("haze 2 deg", deg(32.0), rectangle(0.44, 3.0))
            .and("haze 5 deg", deg(25.0), rectangle(0.44, 3.0))
            .and("haze 5 deg", deg(35.0), rectangle(0.44, 3.0))
            .and("haze 15 deg", deg(15.0), rectangle(0.44, 3.0))
            .about(
                "Haze 2, 5 and 15 deg beside 30 deg (ASTM E430 methods A and C): two-sided sums at 28 and 32, 25 and 35 \
                 deg, and one receptor at 15 deg. All stops chosen.",
            ),
        gloss("doi", 30.0, [0.14, 1.0], rectangle(0.14, 1.0))
            .and("beside", deg(30.3), rectangle(0.14, 1.0))
            .about(
                "Distinctness of image (ASTM E430, Dorigon): DOI = 100 (1 - beside / gloss), the receptor beside being \
                 0.3 deg off the mirror direction. Stops chosen narrow enough for a mirror to read 100.",
            ),
        gloss("rspec", 20.0, SOURCE, rectangle(0.1982, 3.6)).about(
            "Peak gloss at 20 deg through a slit of +- 0.0991 deg. Its width recalled from an instrument with a diode array; \
             height and source as gloss-20.",
        ),
        metallic("metallic-3", &THREE).about(
            "Reflectance factor in percent at aspecular angles 15, 45, 110 deg, light from 45 deg (ASTM E2194). Stops \
             chosen: discs of 4 deg.",
        ),
        metallic("metallic-5", &FIVE).about(
            "Reflectance factor in percent at aspecular angles 15, 25, 45, 75, 110 deg, light from 45 deg (DIN 6175-2). \
             Stops chosen: discs of 4 deg.",
        ),
    ]
}

/// The instrument of that name, if there is one.
pub fn by_name(name: &str) -> Option<Instrument> {
    instruments().into_iter().find(|i| i.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_instrument_is_sound_and_says_where_it_comes_from() {
        let all = instruments();
        for (k, i) in all.iter().enumerate() {
            i.validate().unwrap();
            assert!(i.about.len() > 60 && all[..k].iter().all(|j| j.name != i.name), "{}", i.name);
        }
        assert!(by_name("gloss-60").is_some() && by_name("gloss-61").is_none());
    }
}
