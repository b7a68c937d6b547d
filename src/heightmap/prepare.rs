//! From a map as measured to a map whose facets mean something.

use super::crop::{self, Cropped, Region};
use super::despike::{self, Despike, Spikes};
use super::fill::{self, Fill, Filled, USUAL_LIMIT};
use super::filter::{self, Pass};
use super::form::{self, Form, Removed};
use super::noise::{SlopeNoise, slope_noise};
use super::orient::{self, Orientation};
use super::warning::{LARGEST_NOISE_SHARE, MOST_SPIKES, Warning};
use super::{Edges, HeightMap, RawMap};
use crate::error::{Error, Result};
use serde::Serialize;
use std::fmt;

/// What to do with a map; by default its least-squares plane is removed and nothing else.
#[derive(Debug, Clone, Default)]
pub struct Preparation {
    /// What lies beyond the border.
    pub edges: Edges,
    /// Mirror, rotate, invert.
    pub orientation: Orientation,
    /// Part to keep, as the map looks once oriented.
    pub region: Option<Region>,
    /// Mark spikes as missing.
    pub despike: Option<Despike>,
    /// Form to remove.
    pub form: Form,
    /// Fill missing points.
    pub fill: Option<Fill>,
    /// Cut-off of the S-filter \[m\]: shorter waves are removed.
    pub s_filter: Option<f64>,
    /// Cut-off of the L-filter \[m\]: longer waves are removed.
    pub l_filter: Option<f64>,
    /// Known standard deviation of the height noise \[m\].
    pub noise: Option<f64>,
}

/// One thing that was done, with its figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "action", rename_all = "snake_case")]
pub enum Action {
    /// Mirrored, rotated, inverted.
    Oriented(Orientation),
    /// Cropped.
    Cropped(Cropped),
    /// Spikes marked as missing.
    Despiked(Spikes),
    /// Form removed.
    FormRemoved(Removed),
    /// Missing points filled.
    Filled(Filled),
    /// Filtered.
    Filtered {
        /// Which waves passed.
        pass: Pass,
        /// Cut-off \[m\].
        cut_off_m: f64,
    },
    /// Slopes judged against known noise; the heights are as they were.
    NoiseJudged(SlopeNoise),
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Action::Oriented(o) => o.fmt(f),
            Action::Cropped(c) => c.fmt(f),
            Action::Despiked(s) => s.fmt(f),
            Action::FormRemoved(r) => r.fmt(f),
            Action::Filled(filled) => filled.fmt(f),
            Action::Filtered { pass: Pass::Long, cut_off_m } => write!(f, "S-filter {:.6} um", cut_off_m * 1e6),
            Action::Filtered { pass: Pass::Short, cut_off_m } => write!(f, "L-filter {:.6} um", cut_off_m * 1e6),
            Action::NoiseJudged(n) => n.fmt(f),
        }
    }
}

/// What was done, in order, and what should be known about it. As text: the actions, separated by commas.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// In the order of [`prepare`].
    pub actions: Vec<Action>,
    /// Sentences with advice.
    pub warnings: Vec<Warning>,
    /// Shortest and longest wave the prepared map holds \[m\]: from two pitches or the S-filter to the longer side or the
    /// L-filter. Slopes depend on it, so a slope without its band says little.
    pub band_m: [f64; 2],
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, action) in self.actions.iter().enumerate() {
            write!(f, "{}{action}", if k == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}

/// A prepared map and how it came about.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// Levelled heights.
    pub map: HeightMap,
    /// What was done.
    pub report: Report,
    /// Name of the format the map came from.
    pub format: &'static str,
    /// Title, instrument and the like as the file states them.
    pub notes: Vec<(String, String)>,
}

/// Map as measured -> oriented -> cropped -> despiked -> form removed -> filled -> S-filter -> L-filter -> noise judged.
///
/// This is the one order in which maps are prepared, whatever the order of the flags:
///
/// 1. Mirror in x, mirror in y, rotate, invert: the map is brought into the view the user has of the part.
/// 2. Crop, in that view. Nothing outside the region has any influence on what follows.
/// 3. Spikes become missing before they can tilt the form.
/// 4. Form is removed in f64 and the rest is stored as f32 (F-operator). It precedes the filters because a tilted edge
///    biases a weighted mean; away from edges the order makes no difference, both are linear.
/// 5. Missing points are filled, if asked, so that the filters find a whole map. Otherwise they stay missing to the end.
/// 6. S-filter, then L-filter (ISO 25178-3:2012: S-L surface).
/// 7. Known noise is compared with the slopes that are left; the heights do not change.
///
/// # Errors
/// `Error::Parameter` from the step that failed: see [`crop::crop`], [`despike::despike`], [`form::remove`],
/// [`fill::fill`], [`filter::gaussian`], [`slope_noise`]; also if a periodic map is cropped, if the S-filter is not
/// shorter than the L-filter, or if no facet is left.
pub fn prepare(raw: RawMap, preparation: &Preparation) -> Result<Prepared> {
    let p = preparation;
    if let (Some(s), Some(l)) = (p.s_filter, p.l_filter)
        && s >= l
    {
        return Err(Error::parameter(
            format!("the S-filter of {} um is not shorter than the L-filter of {} um", s * 1e6, l * 1e6),
            "the S-filter removes short waves, the L-filter long ones: exchange them",
        ));
    }
    let (mut actions, mut warnings) = (Vec::new(), Vec::new());
    let mut raw = orient::orient(raw, p.orientation);
    if !p.orientation.is_identity() {
        actions.push(Action::Oriented(p.orientation));
    }
    if let Some(region) = p.region {
        let before = raw.heights.dim();
        let cropped = crop::crop(&mut raw, region)?;
        if p.edges == Edges::Periodic && raw.heights.dim() != before {
            return Err(Error::parameter(
                "a part of a periodic map is not periodic",
                "leave out --region, or choose --edges open or mirrored",
            ));
        }
        actions.push(Action::Cropped(cropped));
    }
    if let Some(rule) = p.despike {
        let spikes = despike::despike(&mut raw, rule)?;
        if spikes.fraction > MOST_SPIKES {
            warnings.push(Warning::ManySpikes { fraction: spikes.fraction });
        }
        actions.push(Action::Despiked(spikes));
    }
    if p.region.is_some() || p.despike.is_some() {
        raw.check()?;
    }
    let (mut map, removed) = form::remove(&raw, p.form, p.edges)?;
    let RawMap { format, notes, .. } = raw;
    actions.push(Action::FormRemoved(removed));
    if let Some(rule) = p.fill {
        let filled = fill::fill(&mut map, rule)?;
        if filled.fraction() > USUAL_LIMIT {
            warnings.push(Warning::ManyFilled { fraction: filled.fraction() });
        }
        if !filled.converged {
            warnings.push(Warning::FillNotConverged { largest_hole: filled.largest_hole });
        }
        actions.push(Action::Filled(filled));
    }
    let pitch = map.pitch_x.max(map.pitch_y);
    let side = (map.pitch_x * map.width() as f64).max(map.pitch_y * map.height() as f64);
    let mut band_m = [2.0 * pitch, side];
    let mut s_filter = None;
    if let Some(cut_off) = p.s_filter {
        if cut_off > 0.0 && cut_off < 2.0 * pitch {
            warnings.push(Warning::SFilterBelowSampling { cut_off, pitch });
        } else {
            filter::gaussian(&mut map, cut_off, Pass::Long)?;
            actions.push(Action::Filtered { pass: Pass::Long, cut_off_m: cut_off });
            s_filter = Some(cut_off);
            band_m[0] = cut_off;
        }
    }
    if let Some(cut_off) = p.l_filter {
        filter::gaussian(&mut map, cut_off, Pass::Short)?;
        actions.push(Action::Filtered { pass: Pass::Short, cut_off_m: cut_off });
        band_m[1] = cut_off;
    }
    if let Some(sigma) = p.noise {
        let judged = slope_noise(&map, sigma, s_filter)?;
        if judged.share > LARGEST_NOISE_SHARE {
            let SlopeNoise { noise, share, sdq, corrected, .. } = judged;
            warnings.push(Warning::NoiseInSlopes { noise, share, sdq: [sdq, corrected] });
        }
        actions.push(Action::NoiseJudged(judged));
    }
    Ok(Prepared { map, report: Report { actions, warnings, band_m }, format, notes })
}
