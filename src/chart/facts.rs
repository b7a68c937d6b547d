//! The numbers of a survey in words, for the screen and for the page.

pub use super::units::digits;
use super::units::length;
use crate::heightmap::sampling::SlopeScale;
use crate::heightmap::{HeightMap, Survey};
use crate::meter::{Geometry, validity};

/// One line: what, and how much.
pub type Fact = (&'static str, String);

/// Size, pitch, gaps, and the shortest and longest wave \[m\] that the prepared map holds.
pub fn of_grid(map: &HeightMap, survey: &Survey, [shortest, longest]: [f64; 2]) -> Vec<Fact> {
    let (w, h) = (map.width(), map.height());
    vec![
        ("points", format!("{w} x {h}")),
        ("pitch", format!("{} x {}", length(map.pitch_x), length(map.pitch_y))),
        ("field", format!("{} x {}", length(w as f64 * map.pitch_x), length(h as f64 * map.pitch_y))),
        ("missing", format!("{} %", digits(100.0 * survey.missing_fraction))),
        ("bandwidth", format!("wavelengths {} to {}", length(longest), length(shortest))),
    ]
}

/// ISO 25178-2 heights.
pub fn of_heights(survey: &Survey) -> Vec<Fact> {
    let h = &survey.heights;
    vec![
        ("Sa", length(h.sa)),
        ("Sq", length(h.sq)),
        ("Ssk", digits(h.ssk)),
        ("Sku", digits(h.sku)),
        ("Sp", length(h.sp)),
        ("Sv", length(h.sv)),
        ("Sz", length(h.sz())),
    ]
}

/// ISO 25178-2 slopes, area and texture.
pub fn of_texture(survey: &Survey) -> Vec<Fact> {
    let (g, t) = (&survey.gradient, &survey.texture);
    let undefined = || "not defined".to_owned();
    let at_most = if t.str_is_upper_bound { "at most " } else { "" };
    vec![
        ("Sdq", digits(g.sdq)),
        ("Sdr", format!("{} %", digits(100.0 * g.sdr))),
        ("slope rms x", digits(g.rms[0])),
        ("slope rms y", digits(g.rms[1])),
        ("Sal", t.sal.map_or_else(undefined, length)),
        ("Str", t.str.map_or_else(undefined, |s| format!("{at_most}{s:.3}"))),
        ("Std (lay)", t.std.map_or_else(undefined, |s| format!("{:.1} deg", tenths(s.to_degrees())))),
    ]
}

/// Rounded to one decimal, never to a zero with a minus.
fn tenths(value: f64) -> f64 {
    (10.0 * value).round() / 10.0 + 0.0
}

/// `s(d), s(2d), ..`, as many as fit.
pub fn of_scales(scales: &[SlopeScale], most: usize) -> String {
    let parts = scales.iter().take(most).map(|s| format!("{} at {}", digits(s.rms), length(s.distance)));
    parts.collect::<Vec<_>>().join(", ")
}

/// Rayleigh parameter and verdict at 20, 60 and 85 deg.
pub fn of_rays(sq: f64, wavelength: f64) -> Vec<Fact> {
    let names = ["rays at 20 deg", "rays at 60 deg", "rays at 85 deg"];
    let verdict = |geometry: &Geometry| {
        let g = validity::rayleigh_parameter(sq, geometry.theta_i, wavelength);
        let word = if validity::check_rays(sq, geometry, wavelength).is_none() {
            "valid".to_owned()
        } else {
            format!("not valid, {:.1} % stays a mirror beam", 100.0 * (-g).exp())
        };
        format!("g = {}: {word}", digits(g))
    };
    names.into_iter().zip(Geometry::standard_three().iter().map(verdict)).collect()
}
