//! A page with one panel of curves: goniometer scans, readings along a parameter.

use super::axis::Axis;
use super::colours::{BLUE, GREEN, ORANGE};
use super::plot::{Curve, Plot, Stroke, decades, exact};
use super::raster::{Area, Colour, Raster, WHITE};

const SIZE: [usize; 2] = [1100, 640];
const VIOLET: Colour = [128, 72, 160];
const SOFT: Colour = [150, 150, 150];

/// Colours and dashes in turn: told apart in a grey print too.
const STROKES: [Stroke; 4] = [
    Stroke { ink: BLUE, width: 2.4, dashes: None },
    Stroke { ink: ORANGE, width: 2.4, dashes: Some([11.0, 5.0]) },
    Stroke { ink: GREEN, width: 2.4, dashes: Some([4.0, 4.0]) },
    Stroke { ink: VIOLET, width: 2.4, dashes: Some([16.0, 4.0]) },
];

/// A named curve.
pub type Named = (String, Vec<(f64, f64)>);

/// Decades of f_r shown below the highest value.
const DEPTH: f64 = 1e7;

/// f_r \[1/sr\] against the detector angle \[deg\], logarithmic, one curve per surface; a grey line marks the mirror
/// direction. Zeros are below any logarithm and leave a gap.
pub fn scan_chart(title: &str, mirror_deg: f64, curves: &[Named]) -> Raster {
    let points = || curves.iter().flat_map(|(_, points)| points);
    let highest = points().map(|p| p.1).filter(|y| y.is_finite()).fold(0.0, f64::max);
    let highest = if highest > 0.0 { highest } else { 1.0 };
    let lowest = points().map(|p| p.1).filter(|y| *y > highest / DEPTH).fold(highest, f64::min);
    let y = decades(lowest, highest * 1.05);
    let (from, to) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let (from, to) = if to > from { (from, to) } else { (mirror_deg - 1.0, mirror_deg + 1.0) };
    let mirror = Curve {
        label: String::new(),
        points: vec![(mirror_deg, y.low), (mirror_deg, y.high)],
        stroke: Stroke { ink: SOFT, width: 1.4, dashes: Some([3.0, 5.0]) },
    };
    let shown = |points: &[(f64, f64)]| points.iter().map(|&(x, v)| (x, if v > 0.0 { v } else { f64::NAN })).collect();
    page(Plot {
        title: title.to_owned(),
        x: exact(from, to, 9),
        y,
        x_label: "detector angle, degrees (negative: side of the source)".into(),
        y_label: "BRDF averaged over the detector, 1/sr".into(),
        curves: std::iter::once(mirror).chain(styled(curves, shown)).collect(),
    })
}

/// Readings against a parameter on a logarithmic axis.
pub fn parameter_chart(title: &str, x_label: &str, y_label: &str, curves: &[Named]) -> Raster {
    let points = || curves.iter().flat_map(|(_, points)| points);
    let (from, to) = points().fold((f64::INFINITY, 0.0), |(a, b), p| (f64::min(a, p.0), f64::max(b, p.0)));
    let (from, to) = if from > 0.0 && to > from { (from, to) } else { (0.1, 1.0) };
    page(Plot {
        title: title.to_owned(),
        x: Axis { low: from, high: to, ..decades(from, to) },
        y: Axis::from_zero(points().map(|p| p.1).fold(0.0, f64::max), 6),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        curves: styled(curves, <[_]>::to_vec).collect(),
    })
}

fn styled<'a>(
    curves: &'a [Named],
    shown: impl Fn(&[(f64, f64)]) -> Vec<(f64, f64)> + 'a,
) -> impl Iterator<Item = Curve> + 'a {
    curves.iter().enumerate().map(move |(k, (label, points))| Curve {
        label: label.clone(),
        points: shown(points),
        stroke: STROKES[k % STROKES.len()],
    })
}

fn page(plot: Plot) -> Raster {
    let [width, height] = SIZE;
    let mut raster = Raster::new(width, height, WHITE);
    plot.draw(&mut raster, Area { x: 12, y: 10, width: width - 24, height: height - 14 });
    raster
}
