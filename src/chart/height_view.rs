//! Heights in colour, with a scale bar and a colour bar.

use super::axis::Axis;
use super::colours::{MISSING, height_colour};
use super::plot::exact;
use super::raster::{Align, Area, INK, Raster, SOFT_INK, WHITE};
use super::units::{Unit, length};
use crate::heightmap::HeightMap;
use crate::render::caption::Lettering;

const BAR_WIDTH: usize = 22;
const BAR_GAP: usize = 18;
const BAR_LABELS: usize = 92;
const BELOW: usize = 64;

/// Share of the points that may lie off either end of the colours, if that makes the rest visible.
const OFF_SCALE: f64 = 0.001;

/// A picture of the map, `width` pixels wide: what `convert --preview` writes.
pub fn height_preview(map: &HeightMap, width: usize) -> Raster {
    let width = width.clamp(320, 8000);
    let room = width - 40 - BAR_GAP - BAR_WIDTH - BAR_LABELS;
    let aspect = aspect(map);
    let picture = ((room as f64 / aspect).round() as usize).clamp(120, 4 * width);
    let mut raster = Raster::new(width, picture + BELOW + 56, WHITE);
    draw_heights(&mut raster, map, Area { x: 20, y: 36, width: width - 40, height: picture + BELOW });
    raster
}

/// Width over height of the measured field, kept between 1/8 and 8 so that a strip stays visible.
fn aspect(map: &HeightMap) -> f64 {
    let (w, h) = field(map);
    (w / h).clamp(0.125, 8.0)
}

fn field(map: &HeightMap) -> (f64, f64) {
    (map.width() as f64 * map.pitch_x, map.height() as f64 * map.pitch_y)
}

/// Draws the map, true to scale, in the upper left of `area`; the colour bar to its right, the scale bar below.
pub fn draw_heights(raster: &mut Raster, map: &HeightMap, area: Area) {
    let room = (area.width.saturating_sub(BAR_GAP + BAR_WIDTH + BAR_LABELS), area.height.saturating_sub(BELOW));
    let (across, down) = field(map);
    let shape = aspect(map);
    let width = (room.0 as f64).min(room.1 as f64 * shape).max(2.0) as usize;
    let picture = Area { x: area.x, y: area.y, width, height: ((width as f64 / shape).round() as usize).max(2) };
    let scale = Scale::of(map);
    paint(raster, map, picture, &scale);
    raster.frame(picture, SOFT_INK);
    colour_bar(raster, picture, room.1, &scale);

    // A bar of a round length, about a quarter of the width.
    let unit = Unit::with(across, 1.0);
    let round = round_below(0.3 * across / unit.size);
    let bar = ((round * unit.size / across * picture.width as f64).round() as usize).max(2);
    let y = picture.bottom() + 14;
    raster.fill(Area { x: picture.x, y, width: bar, height: 6 }, INK);
    let text = format!("{round} {}", unit.name);
    raster.text(&text, (picture.x + bar + 10) as f64, (y + 3) as f64, Align::Start, Lettering::Small, INK);
    let mut note = format!("{} x {}", length(across), length(down));
    if (across / down - shape).abs() > 1e-6 * shape {
        note += ", not to scale";
    }
    if scale.clipped {
        note += &format!(
            "; heights {} to {}, 0.1 % off the colours at either end",
            length(scale.range[0]),
            length(scale.range[1])
        );
    }
    let limit = area.width;
    for (k, line) in Lettering::Small.wrap(&note, limit).iter().take(2).enumerate() {
        let y = (y + 24 + 19 * k) as f64;
        raster.text(line, picture.x as f64, y, Align::Start, Lettering::Small, SOFT_INK);
    }
    if scale.missing {
        // To the right of the scale bar: what grey means.
        let x = picture.x + bar + 10 + Lettering::Small.text_width(&text) + 24;
        let swatch = Area { x, y: y - 4, width: 22, height: 14 };
        raster.fill(swatch, MISSING);
        raster.frame(swatch, SOFT_INK);
        raster.text("missing", (x + 30) as f64, (y + 3) as f64, Align::Start, Lettering::Small, INK);
    }
}

/// Largest of 1, 2, 5 times a power of ten that is at most `value`.
fn round_below(value: f64) -> f64 {
    let exponent = value.log10().floor() as i32;
    let power = |m: f64| if exponent < 0 { m / 10f64.powi(-exponent) } else { m * 10f64.powi(exponent) };
    [5.0, 2.0, 1.0].map(power).into_iter().find(|v| *v <= value * (1.0 + 1e-9)).unwrap_or(value)
}

/// Heights at the ends of the colours.
struct Scale {
    low: f64,
    high: f64,
    /// Lowest and highest height there is.
    range: [f64; 2],
    clipped: bool,
    missing: bool,
}

impl Scale {
    fn of(map: &HeightMap) -> Self {
        let stride = (map.heights.len() / 400_000).max(1);
        let mut sample: Vec<f32> = map.heights.iter().step_by(stride).copied().filter(|h| !h.is_nan()).collect();
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let mut missing = false;
        for &h in &map.heights {
            missing |= h.is_nan();
            range = [range[0].min(f64::from(h)), range[1].max(f64::from(h))];
        }
        if sample.is_empty() || range[0] > range[1] {
            return Scale { low: 0.0, high: 1e-9, range: [0.0, 0.0], clipped: false, missing };
        }
        sample.sort_unstable_by(f32::total_cmp);
        let tail = (OFF_SCALE * sample.len() as f64) as usize;
        let (low, high) = (f64::from(sample[tail]), f64::from(sample[sample.len() - 1 - tail]));
        // A few spikes must not turn the rest of the map into one colour.
        let clipped = high > low && range[1] - range[0] > 1.5 * (high - low);
        let [low, high] = if clipped { [low, high] } else { range };
        // A flat map has one colour; any span does.
        let high = if high > low { high } else { low + 1e-9 };
        Scale { low, high, range, clipped, missing }
    }

    fn share(&self, h: f64) -> f64 {
        (h - self.low) / (self.high - self.low)
    }
}

/// Each pixel is the mean of the measured points under it, or the nearest point if it is smaller than one.
fn paint(raster: &mut Raster, map: &HeightMap, picture: Area, scale: &Scale) {
    let (rows, columns) = map.heights.dim();
    let span = |k: usize, pixels: usize, points: usize| {
        let first = k * points / pixels;
        first..((k + 1) * points).div_ceil(pixels).max(first + 1)
    };
    let colours: Vec<_> = (0..=1023).map(|k| height_colour(f64::from(k) / 1023.0)).collect();
    for y in 0..picture.height {
        let under_rows = span(y, picture.height, rows);
        for x in 0..picture.width {
            let (mut n, mut sum) = (0.0, 0.0);
            for r in under_rows.clone() {
                for c in span(x, picture.width, columns) {
                    let h = f64::from(map.heights[[r, c]]);
                    if !h.is_nan() {
                        n += 1.0;
                        sum += h;
                    }
                }
            }
            let share = scale.share(sum / n).clamp(0.0, 1.0);
            let ink = if n > 0.0 { colours[(share * 1023.0).round() as usize] } else { MISSING };
            raster.blend((picture.x + x) as i64, (picture.y + y) as i64, ink, 1.0);
        }
    }
}

fn colour_bar(raster: &mut Raster, picture: Area, room: usize, scale: &Scale) {
    // As high as the picture, but of a strip at least high enough to be read.
    let height = picture.height.max(140).min(room.max(40));
    let bar = Area { x: picture.right() + BAR_GAP, y: picture.y, width: BAR_WIDTH, height };
    for k in 0..height {
        let ink = height_colour(1.0 - (k as f64 + 0.5) / height as f64);
        raster.fill(Area { y: bar.y + k, height: 1, ..bar }, ink);
    }
    raster.frame(bar, SOFT_INK);
    let unit = Unit::with(scale.low.abs().max(scale.high.abs()), 1.0);
    let axis: Axis = exact(scale.low / unit.size, scale.high / unit.size, (height / 60).clamp(2, 8));
    for (&v, label) in axis.ticks.iter().zip(axis.labels()) {
        let y = bar.y as f64 + (1.0 - axis.share(v)) * (height - 1) as f64;
        let right = bar.right() as f64;
        raster.line(&[(right, y.round()), (right + 4.0, y.round())], SOFT_INK, 1.0);
        raster.text(&label, right + 9.0, y, Align::Start, Lettering::Small, INK);
    }
    raster.text(unit.name, bar.x as f64, bar.y as f64 - 14.0, Align::Start, Lettering::Small, INK);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::Edges;
    use ndarray::Array2;

    fn map(rows: usize, columns: usize, heights: impl Fn(usize, usize) -> f32) -> HeightMap {
        let heights = Array2::from_shape_fn((rows, columns), |(r, c)| heights(r, c));
        HeightMap { heights, pitch_x: 1e-6, pitch_y: 2e-6, edges: Edges::Open, removed_slopes: [0.0; 2] }
    }

    fn pixel(raster: &Raster, x: usize, y: usize) -> [u8; 3] {
        let first = 3 * (y * raster.width() + x);
        [raster.rgb()[first], raster.rgb()[first + 1], raster.rgb()[first + 2]]
    }

    /// Row 0 on top, column 0 on the left, missing points grey, in pictures larger and smaller than the map.
    #[test]
    fn every_quarter_is_where_it_belongs() {
        for n in [2, 3000] {
            let m = map(n, n, |r, c| match (r < n / 2, c < n / 2) {
                (true, true) => 0.0,
                (true, false) => 1e-7,
                (false, true) => f32::NAN,
                (false, false) => 5e-8,
            });
            let raster = height_preview(&m, 400);
            let room = 400 - 40 - BAR_GAP - BAR_WIDTH - BAR_LABELS;
            let at = |x: usize, y: usize| pixel(&raster, 20 + x * room / 4, 36 + y * room / 2);
            assert_eq!(at(1, 1), height_colour(0.0));
            assert_eq!(at(3, 1), height_colour(1.0));
            assert_eq!(at(1, 3), MISSING);
            assert_eq!(at(3, 3), height_colour(0.5));
        }
    }

    #[test]
    fn odd_maps_give_a_picture() {
        for m in [
            map(2, 2, |_, _| f32::NAN),
            map(3, 4000, |_, c| c as f32),
            map(900, 2, |_, _| 0.0),
            map(64, 64, |r, c| if (r, c) == (5, 5) { 1.0 } else { 1e-9 * (r * c % 7) as f32 }),
        ] {
            let raster = height_preview(&m, 600);
            assert!(raster.width() == 600 && raster.height() > 150);
        }
        assert_eq!([0.3, 7.0, 49.9, 100.0].map(round_below), [0.2, 5.0, 20.0, 100.0]);
    }
}
