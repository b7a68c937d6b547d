//! Mirrored, turned and inverted maps: for parts that were measured from the wrong side.

use super::RawMap;
use ndarray::Axis;
use serde::Serialize;

/// A turn about +z, counter-clockwise as the map is seen from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rotation {
    /// Not turned.
    #[default]
    None,
    /// A quarter: what pointed to +x points to +y.
    By90,
    /// Half.
    By180,
    /// Three quarters, or one clockwise.
    By270,
}

/// What is done first to last: mirror in x, mirror in y, rotate, invert.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Orientation {
    /// x becomes -x: left and right are exchanged.
    pub mirror_x: bool,
    /// y becomes -y: top and bottom are exchanged.
    pub mirror_y: bool,
    /// A turn counter-clockwise.
    pub rotation: Rotation,
    /// h becomes -h: hills become valleys.
    pub invert: bool,
}

impl Orientation {
    /// Whether nothing is to be done.
    pub fn is_identity(&self) -> bool {
        *self == Orientation::default()
    }
}

impl std::fmt::Display for Orientation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rotation = match self.rotation {
            Rotation::None => None,
            Rotation::By90 => Some("rotated by 90 deg"),
            Rotation::By180 => Some("rotated by 180 deg"),
            Rotation::By270 => Some("rotated by 270 deg"),
        };
        let done = [
            self.mirror_x.then_some("mirrored in x"),
            self.mirror_y.then_some("mirrored in y"),
            rotation,
            self.invert.then_some("inverted"),
        ];
        f.write_str(&done.into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}

/// `h'(x', y') = +-h(x, y)`, the samples moved and not interpolated; a quarter turn exchanges width and height and the
/// pitches along x and y.
pub fn orient(mut raw: RawMap, orientation: Orientation) -> RawMap {
    if orientation.mirror_x {
        raw.heights.invert_axis(Axis(1));
    }
    if orientation.mirror_y {
        raw.heights.invert_axis(Axis(0));
    }
    if matches!(orientation.rotation, Rotation::By90 | Rotation::By270) {
        raw.heights.swap_axes(0, 1);
        std::mem::swap(&mut raw.pitch_x, &mut raw.pitch_y);
    }
    // After the exchange of axes a row is an old column, read downwards: reversed it is a turn, not a mirror image.
    match orientation.rotation {
        Rotation::None => {}
        Rotation::By90 => raw.heights.invert_axis(Axis(0)),
        Rotation::By180 => {
            raw.heights.invert_axis(Axis(0));
            raw.heights.invert_axis(Axis(1));
        }
        Rotation::By270 => raw.heights.invert_axis(Axis(1)),
    }
    if orientation.invert {
        raw.heights.mapv_inplace(|h| -h);
    }
    // Everything downstream reads rows as slices.
    if !raw.heights.is_standard_layout() {
        raw.heights = raw.heights.as_standard_layout().into_owned();
    }
    raw
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    fn raw() -> RawMap {
        RawMap {
            heights: array![[1.0, 2.0, 3.0], [4.0, 5.0, f64::NAN]],
            pitch_x: 1e-6,
            pitch_y: 3e-6,
            format: "test",
            notes: vec![],
        }
    }

    /// Heights as text, so that a gap compares equal to a gap.
    fn shown(raw: &RawMap) -> Vec<String> {
        assert!(raw.heights.is_standard_layout());
        raw.heights.outer_iter().map(|row| row.iter().map(|h| format!("{h} ")).collect()).collect()
    }

    #[test]
    fn every_flag_on_an_asymmetric_map() {
        let with = |o: Orientation| orient(raw(), o);
        let d = Orientation::default();
        assert_eq!(shown(&with(Orientation { mirror_x: true, ..d })), ["3 2 1 ", "NaN 5 4 "]);
        assert_eq!(shown(&with(Orientation { mirror_y: true, ..d })), ["4 5 NaN ", "1 2 3 "]);
        assert_eq!(shown(&with(Orientation { invert: true, ..d })), ["-1 -2 -3 ", "-4 -5 NaN "]);
        assert_eq!(shown(&with(Orientation { rotation: Rotation::By180, ..d })), ["NaN 5 4 ", "3 2 1 "]);
        let quarter = with(Orientation { rotation: Rotation::By90, ..d });
        assert_eq!(shown(&quarter), ["3 NaN ", "2 5 ", "1 4 "]);
        assert_eq!((quarter.pitch_x, quarter.pitch_y), (3e-6, 1e-6));
        let three = with(Orientation { rotation: Rotation::By270, ..d });
        assert_eq!(shown(&three), ["4 1 ", "5 2 ", "NaN 3 "]);
        assert_eq!((three.pitch_x, three.pitch_y), (3e-6, 1e-6));
        assert_eq!(shown(&with(d)), ["1 2 3 ", "4 5 NaN "]);
    }

    #[test]
    fn a_slope_turns_as_a_vector() {
        // Slopes (0.1, 0.02) point to +x; after a quarter turn they point to +y: (-0.02, 0.1).
        let (p, q) = (0.1, 0.02);
        let heights = ndarray::Array2::from_shape_fn((9, 12), |(r, c)| p * 1e-6 * c as f64 - q * 3e-6 * r as f64);
        let ramp = RawMap { heights, ..raw() };
        let turned = |rotation, mirror_x| {
            let o = Orientation { rotation, mirror_x, ..Orientation::default() };
            crate::heightmap::level::level(&orient(ramp.clone(), o), crate::heightmap::Edges::Open)
                .unwrap()
                .removed_slopes
        };
        for (found, expected) in [
            (turned(Rotation::By90, false), [-q, p]),
            (turned(Rotation::By180, false), [-p, -q]),
            (turned(Rotation::By270, false), [q, -p]),
            (turned(Rotation::None, true), [-p, q]),
            // Mirrored first, then turned.
            (turned(Rotation::By90, true), [-q, -p]),
        ] {
            assert!((found[0] - expected[0]).abs() < 1e-9 && (found[1] - expected[1]).abs() < 1e-9, "{found:?}");
        }
    }
}
