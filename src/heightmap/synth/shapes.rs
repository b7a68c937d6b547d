//! Surfaces in closed form. x grows with the column from 0 at the left, y against the row from 0 at the top.

use super::{Grid, check_grid, map_of, micrometres};
use crate::error::{Error, Result};
use crate::heightmap::RawMap;
use ndarray::Array2;

/// Slope beyond which a tilted plane is a mistake: 89.9 deg.
const STEEPEST: f64 = 1000.0;

/// `h = p x + q y` with slopes `p`, `q`: a tilted mirror. x grows with the column, y against the row.
///
/// # Errors
/// `Error::Parameter` for an unusable grid, or a slope beyond 1000 or not a number.
pub fn ramp(grid: Grid, slopes: [f64; 2]) -> Result<RawMap> {
    check_grid(grid)?;
    if !slopes.iter().all(|s| s.abs() <= STEEPEST) {
        let advice = format!("give two numbers up to {STEEPEST}, such as 0.1,0");
        return Err(Error::parameter(format!("{slopes:?} are no slopes of a map"), advice));
    }
    let heights = Array2::from_shape_fn((grid.height, grid.width), |(r, c)| {
        slopes[0] * grid.pitch[0] * c as f64 - slopes[1] * grid.pitch[1] * r as f64
    });
    Ok(map_of(grid, heights))
}

/// `h = sqrt(2) Sq sin(2 pi u / period)`, `u` the distance \[m\] along the direction `angle` \[rad\] from +x.
///
/// Over whole periods: Sq as asked, `Sa = 2 sqrt(2) Sq / pi`, `Ssk = 0`, `Sku = 3/2`, `Sdq = 2 pi Sq / period`.
///
/// # Errors
/// `Error::Parameter` for an unusable grid, a negative Sq, or a period shorter than two pitches.
pub fn sinusoid(grid: Grid, sq: f64, period: f64, angle: f64) -> Result<RawMap> {
    check_period(grid, period, angle)?;
    if !(sq >= 0.0 && sq.is_finite()) {
        return Err(Error::parameter(format!("Sq {sq} m is not a height"), "give --sq 0 or more, with a unit"));
    }
    let amplitude = std::f64::consts::SQRT_2 * sq;
    let wave = |u: f64| amplitude * (std::f64::consts::TAU * u / period).sin();
    Ok(along(grid, angle, wave))
}

/// A symmetric saw of the slopes `+slope` and `-slope`, half a period \[m\] each, along the direction `angle` \[rad\].
///
/// Over whole periods that hold an even number of samples: `Sz = slope period / 2`, `Sdq = |slope|`. Every facet has one of
/// two normals.
///
/// # Errors
/// `Error::Parameter` for an unusable grid, a slope that is not finite, or a period shorter than two pitches.
pub fn sawtooth(grid: Grid, slope: f64, period: f64, angle: f64) -> Result<RawMap> {
    check_period(grid, period, angle)?;
    if !slope.is_finite() {
        return Err(Error::parameter(format!("{slope} is not a slope"), "give --slope a number such as 0.1"));
    }
    let tooth = |u: f64| {
        let t = (u / period).rem_euclid(1.0);
        slope * period * t.min(1.0 - t)
    };
    Ok(along(grid, angle, tooth))
}

/// `h = sqrt(R^2 - r^2) - R`: a spherical cap \[m\] of radius of curvature `R`, its top in the middle of the map; a bowl if
/// `R` is negative.
///
/// Curvature `-1/R` at the top, slope `-r / sqrt(R^2 - r^2)`.
///
/// # Errors
/// `Error::Parameter` for an unusable grid, or if the map reaches beyond the sphere.
pub fn cap(grid: Grid, radius: f64) -> Result<RawMap> {
    check_grid(grid)?;
    let middle = [(grid.width - 1) as f64 / 2.0 * grid.pitch[0], (grid.height - 1) as f64 / 2.0 * grid.pitch[1]];
    let corner = middle[0].hypot(middle[1]);
    if !(radius.is_finite() && radius.abs() > corner) {
        return Err(Error::parameter(
            format!(
                "a sphere of radius {} does not reach the corners of the map, {} from its middle",
                micrometres(radius),
                micrometres(corner)
            ),
            "give a larger --radius, or a smaller map",
        ));
    }
    let heights = Array2::from_shape_fn((grid.height, grid.width), |(r, c)| {
        let (x, y) = (c as f64 * grid.pitch[0] - middle[0], r as f64 * grid.pitch[1] - middle[1]);
        let r2 = x * x + y * y;
        // The depth below the top, without the difference of two large numbers.
        -radius.signum() * r2 / (radius.abs() + (radius * radius - r2).sqrt())
    });
    Ok(map_of(grid, heights))
}

fn check_period(grid: Grid, period: f64, angle: f64) -> Result<()> {
    check_grid(grid)?;
    let coarse = grid.pitch[0].max(grid.pitch[1]);
    if !(period.is_finite() && period >= 2.0 * coarse) {
        return Err(Error::parameter(
            format!("a period of {} cannot be sampled with a pitch of {}", micrometres(period), micrometres(coarse)),
            "give --period at least two pitches, better ten",
        ));
    }
    if !angle.is_finite() {
        return Err(Error::parameter(format!("{angle} is not an angle"), "give --angle in degrees"));
    }
    Ok(())
}

/// A profile of the distance along one direction.
fn along(grid: Grid, angle: f64, profile: impl Fn(f64) -> f64) -> RawMap {
    let (sin, cos) = angle.sin_cos();
    let heights = Array2::from_shape_fn((grid.height, grid.width), |(r, c)| {
        profile(c as f64 * grid.pitch[0] * cos - r as f64 * grid.pitch[1] * sin)
    });
    map_of(grid, heights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightmap::parameters::{Gradient, Heights};
    use crate::heightmap::{Edges, level};
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    const GRID: Grid = Grid { width: 320, height: 200, pitch: [0.5e-6, 1e-6] };

    #[test]
    fn a_sinusoid_along_either_axis() {
        for (angle, pitch) in [(0.0, 0.5e-6), (FRAC_PI_2, 1e-6)] {
            let map = level::keep_tilt(&sinusoid(GRID, 2e-7, 20e-6, angle).unwrap(), Edges::Periodic);
            let (h, g) = (Heights::measure(&map), Gradient::measure(&map));
            assert!((h.sq / 2e-7 - 1.0).abs() < 1e-6 && (h.sku - 1.5).abs() < 1e-6 && h.ssk.abs() < 1e-6, "{h:?}");
            // Forward differences take the share sinc(d / period) of the slope.
            let x = PI * pitch / 20e-6;
            assert!((g.sdq / (TAU * 2e-7 / 20e-6 * x.sin() / x) - 1.0).abs() < 1e-6, "{g:?}");
        }
        // Direction: 45 deg climbs to the right and upwards.
        let map = sinusoid(Grid { pitch: [1e-6; 2], ..GRID }, 1e-7, 80e-6, PI / 4.0).unwrap();
        assert!(map.heights[[100, 101]] - map.heights[[100, 100]] == map.heights[[99, 100]] - map.heights[[100, 100]]);
    }

    #[test]
    fn a_saw_has_two_slopes() {
        let map = level::keep_tilt(&sawtooth(GRID, 0.1, 20e-6, 0.0).unwrap(), Edges::Periodic);
        let g = Gradient::measure(&map);
        assert!((g.sdq - 0.1).abs() < 1e-7 && g.rms[1] == 0.0, "{g:?}");
        assert!((Heights::measure(&map).sz() / 1e-6 - 1.0).abs() < 1e-6);
        let slopes: Vec<f64> =
            (1..320).map(|c| f64::from(map.heights[[0, c]] - map.heights[[0, c - 1]]) / 0.5e-6).collect();
        assert!(slopes.iter().all(|s| (s.abs() - 0.1).abs() < 1e-6));
        assert!((slopes.iter().filter(|s| **s > 0.0).count() as f64 / 320.0 - 0.5).abs() < 0.01);
    }

    /// Second differences at the top give the curvature, the slope at the border that of the circle.
    #[test]
    fn a_cap_has_its_radius() {
        let grid = Grid { width: 201, height: 101, ..GRID };
        for radius in [1e-3, -2e-3] {
            let h = cap(grid, radius).unwrap().heights;
            assert_eq!(h[[50, 100]], 0.0);
            let bend = |a: f64, b: f64, d: f64| (a + b) / (d * d);
            assert!((bend(h[[50, 99]], h[[50, 101]], 0.5e-6) * radius + 1.0).abs() < 1e-6);
            assert!((bend(h[[49, 100]], h[[51, 100]], 1e-6) * radius + 1.0).abs() < 1e-6);
            let slope = (h[[50, 200]] - h[[50, 198]]) / 1e-6;
            let x: f64 = 49.5e-6;
            assert!((slope / (-x / (radius * radius - x * x).sqrt() * radius.signum()) - 1.0).abs() < 1e-6);
        }
        assert!(cap(grid, 5e-5).is_err() && cap(grid, f64::NAN).is_err());
    }

    #[test]
    fn refuses_what_it_cannot_make() {
        assert!(ramp(Grid { pitch: [0.0, 1.0], ..GRID }, [0.1, 0.0]).is_err());
        assert!(ramp(GRID, [f64::NAN, 0.0]).is_err());
        assert!(sinusoid(GRID, 1e-7, 1.9e-6, 0.0).is_err() && sinusoid(GRID, -1.0, 1e-5, 0.0).is_err());
        assert!(sawtooth(GRID, f64::INFINITY, 1e-5, 0.0).is_err() && sawtooth(GRID, 0.1, 1e-5, f64::NAN).is_err());
    }
}
