//! The page of one map: heights, slopes, spectrum and autocorrelation, with the numbers and the warnings.

use super::colours::{BLUE, GREEN, ORANGE};
use super::facts::{Fact, of_grid, of_heights, of_rays, of_texture};
use super::height_view::draw_heights;
use super::plot::{Curve, Plot, Stroke, decades, exact};
use super::raster::{Align, Area, Colour, GRID, INK, Raster, SOFT_INK, WHITE};
use super::units::{Unit, length};
use crate::heightmap::parameters::DECAY;
use crate::heightmap::spectrum::RadialBin;
use crate::heightmap::{Edges, HeightMap, Survey};
use crate::render::caption::Lettering;

const WIDTH: usize = 1680;
const MARGIN: usize = 40;
const PANEL: (usize, usize) = (780, 540);
const GAP: usize = 40;
/// Room for the title and around the lines below it.
const HEADER: usize = 56;
const LINE: usize = 24;

/// What the page is about, besides the map and its survey.
#[derive(Debug, Clone)]
pub struct PageNotes {
    /// Name of the map.
    pub title: String,
    /// Format, instrument and preparation: lines of text, wrapped where they are too long.
    pub subtitle: String,
    /// Shortest and longest wave that the prepared map holds \[m\].
    pub band: [f64; 2],
    /// Wavelength the rays are judged at \[m\].
    pub wavelength: f64,
    /// Sentences to print below, after those of the survey.
    pub warnings: Vec<String>,
}

/// Draws the page; the same map gives the same pixels.
pub fn inspection_page(map: &HeightMap, survey: &Survey, notes: &PageNotes) -> Raster {
    let text_width = WIDTH - 2 * MARGIN;
    let sentences = survey.warnings.iter().map(ToString::to_string).chain(notes.warnings.iter().cloned());
    let warnings: Vec<Vec<String>> = sentences.map(|w| Lettering::Small.wrap(&format!("- {w}"), text_width)).collect();
    let columns = [
        of_grid(map, survey, notes.band),
        of_heights(survey),
        of_texture(survey),
        of_rays(survey.heights.sq, notes.wavelength),
    ];
    let table = columns.iter().map(Vec::len).max().unwrap_or(0) * LINE;
    let subtitle: Vec<String> = notes.subtitle.lines().flat_map(|l| Lettering::Small.wrap(l, text_width)).collect();
    let header = HEADER + subtitle.len() * (LINE - 4);
    let table_top = header + 2 * PANEL.1 + GAP + 30;
    let warnings_top = table_top + table + 26;
    let lines: usize = warnings.iter().map(Vec::len).sum();
    let heading = if lines > 0 { 34 } else { 0 };
    let mut raster = Raster::new(WIDTH, warnings_top + heading + lines * (LINE - 4) + MARGIN, WHITE);

    let title = cut(&notes.title, text_width, Lettering::Heading);
    raster.text(&title, MARGIN as f64, 32.0, Align::Start, Lettering::Heading, INK);
    for (k, line) in subtitle.iter().enumerate() {
        let y = (58 + k * (LINE - 4)) as f64;
        raster.text(line, MARGIN as f64, y, Align::Start, Lettering::Small, SOFT_INK);
    }

    let panel = |column: usize, row: usize| Area {
        x: MARGIN + column * (PANEL.0 + GAP),
        y: header + row * (PANEL.1 + GAP),
        width: PANEL.0,
        height: PANEL.1,
    };
    let first = panel(0, 0);
    raster.text("Heights", first.x as f64, first.y as f64 + 14.0, Align::Start, Lettering::Strong, INK);
    draw_heights(&mut raster, map, Area { y: first.y + 50, height: first.height - 50, ..first });
    slope_plot(map, survey).draw(&mut raster, panel(1, 0));
    spectrum_plot(survey).draw(&mut raster, panel(0, 1));
    autocorrelation_plot(survey).draw(&mut raster, panel(1, 1));

    raster.fill(Area { x: MARGIN, y: table_top - 18, width: text_width, height: 1 }, GRID);
    draw_table(&mut raster, &columns, table_top, notes.wavelength);
    if lines > 0 {
        raster.fill(Area { x: MARGIN, y: warnings_top - 10, width: text_width, height: 1 }, GRID);
        raster.text("Warnings", MARGIN as f64, warnings_top as f64 + 12.0, Align::Start, Lettering::Strong, INK);
        for (k, line) in warnings.iter().flatten().enumerate() {
            let y = (warnings_top + heading + k * (LINE - 4) + 8) as f64;
            raster.text(line, MARGIN as f64, y, Align::Start, Lettering::Small, INK);
        }
    }
    raster
}

/// Four columns of label and value; each as wide as its longest entry.
fn draw_table(raster: &mut Raster, columns: &[Vec<Fact>; 4], top: usize, wavelength: f64) {
    let letter = Lettering::Small.letter_width();
    let mut x = MARGIN;
    for (k, facts) in columns.iter().enumerate() {
        let labels = facts.iter().map(|f| f.0.chars().count()).max().unwrap_or(0) * letter + 14;
        for (row, (label, value)) in facts.iter().enumerate() {
            let y = (top + row * LINE + 8) as f64;
            raster.text(label, x as f64, y, Align::Start, Lettering::Small, SOFT_INK);
            raster.text(value, (x + labels) as f64, y, Align::Start, Lettering::Small, INK);
        }
        if k == 3 {
            let y = (top + facts.len() * LINE + 8) as f64;
            let note = format!("g: Rayleigh parameter at {}, rays", length(wavelength));
            raster.text(&note, x as f64, y, Align::Start, Lettering::Small, SOFT_INK);
            let note = "are valid from g = 9; parameters: ISO 25178-2";
            raster.text(note, x as f64, y + LINE as f64, Align::Start, Lettering::Small, SOFT_INK);
        }
        let values = facts.iter().map(|f| f.1.chars().count()).max().unwrap_or(0) * letter;
        x += labels + values + 40;
    }
}

/// `text` cut to `width` pixels, its end replaced by dots.
fn cut(text: &str, width: usize, lettering: Lettering) -> String {
    let most = width / lettering.letter_width();
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(3)).chain("...".chars()).collect()
}

const fn solid(ink: Colour) -> Stroke {
    Stroke { ink, width: 2.0, dashes: None }
}

const fn dashed(ink: Colour, width: f64) -> Stroke {
    Stroke { ink, width, dashes: Some([7.0, 5.0]) }
}

fn curve(label: impl Into<String>, points: Vec<(f64, f64)>, stroke: Stroke) -> Curve {
    Curve { label: label.into(), points, stroke }
}

/// Densities of the slopes along x and y and of normal distributions with the same rms, on a logarithmic scale.
fn slope_plot(map: &HeightMap, survey: &Survey) -> Plot {
    const BINS: usize = 161;
    let rms = survey.gradient.rms;
    let steepest = rms[0].max(rms[1]);
    let half = if steepest > 0.0 { 5.0 * steepest } else { 1e-3 };
    // A slope has no unit; small ones are read more easily as rise per metre of run.
    let (unit, name) = match half {
        h if h >= 0.03 => (1.0, "slope"),
        h if h >= 3e-5 => (1e-3, "slope / (mm/m)"),
        _ => (1e-6, "slope / (\u{b5}m/m)"),
    };
    let half = half / unit;
    let mut curves = Vec::new();
    let (mut highest, mut lowest) = (f64::MIN_POSITIVE, f64::INFINITY);
    let strokes = [("along x", BLUE, map.pitch_x), ("along y", ORANGE, map.pitch_y)];
    for (k, (label, ink, pitch)) in strokes.into_iter().enumerate() {
        let mut bin = 2.0 * half / BINS as f64;
        // Heights in steps: a bin that is no multiple of a step would show a comb of its own making.
        if let Some(q) = survey.sampling.quantum {
            let step = q.step / pitch / unit;
            bin = step * (bin / step).ceil();
        }
        let count = (2.0 * half / bin).ceil() as usize;
        let first = -0.5 * bin * count as f64;
        let mut counts = vec![0.0f64; count];
        let mut all = 0.0f64;
        visit_slopes(map, k, |slope| {
            all += 1.0;
            let at = (slope / unit - first) / bin;
            if at >= 0.0 && at < count as f64 {
                counts[at as usize] += 1.0;
            }
        });
        let density = |count: f64| count / (all.max(1.0) * bin);
        lowest = lowest.min(density(0.5));
        // A logarithmic scale has no zero: between other bins half a facet stands for none, beyond the last one the curve
        // leaves the plot.
        let taken = |n: &f64| *n > 0.0;
        let ends = counts.iter().position(taken).zip(counts.iter().rposition(taken)).unwrap_or((0, 0));
        let shown = ends.0.saturating_sub(1)..(ends.1 + 2).min(count);
        let height = |i: usize| if i < ends.0 || i > ends.1 { 1e-30 } else { density(counts[i].max(0.5)) };
        let points: Vec<_> = shown.map(|i| (first + (i as f64 + 0.5) * bin, height(i))).collect();
        highest = points.iter().map(|p| p.1).fold(highest, f64::max);
        let inside: f64 = counts.iter().sum();
        let off = 100.0 * (1.0 - inside / all.max(1.0));
        let label = if off > 0.05 { format!("{label} ({off:.1} % off scale)") } else { label.to_owned() };
        curves.push(curve(label, points, solid(ink)));
        let s = rms[k] / unit;
        if s > 0.0 {
            let normal = |x: f64| (-0.5 * (x / s).powi(2)).exp() / (s * std::f64::consts::TAU.sqrt());
            let points = (0..=400).map(|i| -half + 2.0 * half * f64::from(i) / 400.0).map(|x| (x, normal(x))).collect();
            curves.push(curve(if k == 0 { "normal, same rms" } else { "" }, points, dashed(ink, 1.25)));
        }
    }
    let top = highest * 1.5;
    Plot {
        title: "Slope distribution".to_owned(),
        x: exact(-half, half, 6),
        y: decades(lowest.max(top * 1e-7), top),
        x_label: name.to_owned(),
        y_label: "probability density".to_owned(),
        curves,
    }
}

/// Slopes of the mesh edges along one axis.
fn visit_slopes(map: &HeightMap, axis: usize, mut visit: impl FnMut(f64)) {
    let (rows, columns) = map.heights.dim();
    let wraps = usize::from(map.edges == Edges::Periodic);
    let h = |r: usize, c: usize| f64::from(map.heights[[r % rows, c % columns]]);
    let (rows_here, columns_here) = if axis == 0 { (rows, columns - 1 + wraps) } else { (rows - 1 + wraps, columns) };
    for r in 0..rows_here {
        for c in 0..columns_here {
            let slope =
                if axis == 0 { (h(r, c + 1) - h(r, c)) / map.pitch_x } else { (h(r, c) - h(r + 1, c)) / map.pitch_y };
            if !slope.is_nan() {
                visit(slope);
            }
        }
    }
}

/// Radially averaged spectrum up to the frequency that both axes resolve.
fn spectrum_plot(survey: &Survey) -> Plot {
    let [low, high] = survey.spectrum.bandwidth;
    let unit = if high > 5e4 { Unit { name: "\u{b5}m", size: 1e-6 } } else { Unit { name: "mm", size: 1e-3 } };
    // nm^2 um^2: heights squared times the area a wave shares.
    let (psd_unit, psd_name) = (1e-30, "nm\u{b2} \u{b5}m\u{b2}");
    let rings: Vec<&RadialBin> = survey.spectrum.radial.iter().filter(|b| b.frequency <= high && b.psd > 0.0).collect();
    let raw: Vec<_> = rings.iter().map(|b| (b.frequency * unit.size, b.psd / psd_unit)).collect();
    let averaged: Vec<_> =
        logarithmic_average(&rings, 24.0).iter().map(|p| (p.0 * unit.size, p.1 / psd_unit)).collect();
    let highest = raw.iter().map(|p| p.1).fold(f64::MIN_POSITIVE, f64::max);
    let lowest = raw.iter().map(|p| p.1).fold(highest, f64::min).max(highest * 1e-13);
    let x = decades(low * unit.size, high * unit.size);
    let flat = raw.is_empty();
    let y = if flat { decades(0.1, 1.0) } else { decades(lowest / 1.3, highest * 1.3) };
    let limit = |f: f64| vec![(f * unit.size, y.low), (f * unit.size, y.high)];
    let window = if survey.spectrum.windowed { "Hann window" } else { "periodic, no window" };
    let curves = vec![
        curve("", raw, Stroke { ink: [176, 205, 226], width: 1.25, dashes: None }),
        curve(format!("mean over directions, {window}; integral Sq\u{b2}"), averaged, solid(BLUE)),
        curve("1/L, 1/2d", limit(low), dashed(SOFT_INK, 1.25)),
        curve("", limit(high), dashed(SOFT_INK, 1.25)),
    ];
    Plot {
        title: "Power spectral density, two-sided in two dimensions".to_owned(),
        x,
        y,
        x_label: format!("spatial frequency / (1/{})", unit.name),
        y_label: format!("PSD / ({psd_name})"),
        curves,
    }
}

/// Means over `per_decade` bins of the logarithm, weighted by area, so that the many fine rings do not make a hedge.
fn logarithmic_average(rings: &[&RadialBin], per_decade: f64) -> Vec<(f64, f64)> {
    let mut means: Vec<(i64, [f64; 3])> = Vec::new();
    for ring in rings {
        let key = (ring.frequency.log10() * per_decade).floor() as i64;
        if means.last().is_none_or(|m| m.0 != key) {
            means.push((key, [0.0; 3]));
        }
        if let Some((_, sums)) = means.last_mut() {
            for (sum, value) in sums.iter_mut().zip([1.0, ring.frequency, ring.psd]) {
                *sum += ring.area * value;
            }
        }
    }
    means.into_iter().map(|(_, [area, f, psd])| (f / area, psd / area)).collect()
}

/// Profiles along x and y and the mean over directions, to a few autocorrelation lengths.
fn autocorrelation_plot(survey: &Survey) -> Plot {
    let acf = &survey.autocorrelation;
    let reach = (acf.reach[0] as f64 * acf.pitch[0]).max(acf.reach[1] as f64 * acf.pitch[1]);
    let t = &survey.texture;
    let wanted = t.sal.map_or(reach, |sal| (1.2 * sal / t.str.unwrap_or(1.0)).clamp(5.0 * sal, 14.0 * sal));
    let farthest = wanted.min(reach);
    let unit = Unit::with(farthest, 2.0);
    let scaled = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        // One point beyond the frame, so that the curve reaches it.
        let beyond = points.iter().position(|p| p.0 > farthest).map_or(points.len(), |k| k + 1);
        points[..beyond].iter().map(|p| (p.0 / unit.size, p.1)).collect()
    };
    let (x, y, radial) = (scaled(acf.along_x()), scaled(acf.along_y()), scaled(acf.radial()));
    let lowest = [&x, &y, &radial].into_iter().flatten().map(|p| p.1).fold(0.0, f64::min);
    let bottom = (10.0 * (lowest - 0.02)).floor() / 10.0;
    let end = farthest / unit.size;
    let mut curves = vec![
        curve("along x", x, solid(BLUE)),
        curve("along y", y, solid(ORANGE)),
        curve("mean over directions", radial, solid(GREEN)),
        curve(format!("{DECAY}"), vec![(0.0, DECAY), (end, DECAY)], dashed(SOFT_INK, 1.25)),
    ];
    if let Some(sal) = t.sal {
        let at = sal / unit.size;
        let label = format!("Sal = {}", length(sal));
        let dots = Stroke { ink: INK, width: 1.5, dashes: Some([2.0, 4.0]) };
        curves.push(curve(label, vec![(at, bottom), (at, DECAY)], dots));
    }
    Plot {
        title: "Autocorrelation".to_owned(),
        x: exact(0.0, end, 8),
        y: exact(bottom, 1.0, 8),
        x_label: format!("lag / {}", unit.name),
        y_label: "autocorrelation".to_owned(),
        curves,
    }
}
