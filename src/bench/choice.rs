//! What `auto` chooses for a map, what the next costlier method would have changed, and whether it was within the tolerance.

use super::patches::{counted, counted_by_places, tabulated, tabulated_by_subareas};
use super::surface::{GLASS, Surface};
use crate::bench::method::Distance::Moved;
use crate::error::Result;
use crate::heightmap::HeightMap;
use crate::scatter::facet_sum::{Azimuth, facet_sum};
use crate::scatter::{Decision, Method, Options, Scatter, Selection, scatter};
use crate::table::{Provenance, Table};
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::time::Instant;

/// Incident angles that are looked at \[deg\].
pub const ANGLES: [f64; 5] = [0.0, 20.0, 45.0, 60.0, 75.0];
/// Shares of the energy that may be wrong.
pub const TOLERANCES: [f64; 3] = [0.05, 0.01, 0.001];

/// Source azimuths over which the light of an isotropic table is counted.
const AZIMUTHS: u32 = 24;
/// Beams of the reference per incident angle, where azimuths are averaged: from 4 to 16 azimuths per facet.
const BEAMS: f64 = 8e6;

/// What served one incident angle, and how far it is from the costlier methods. Distances are shares of the light that lie in
/// another patch of Klems.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    pub map: String,
    pub tolerance: f64,
    pub theta_i_deg: f64,
    /// Rayleigh parameter.
    pub rayleigh_g: f64,
    /// Whether the table is the average over source azimuths; if not, rows are of the source at azimuth 0.
    pub isotropic: bool,
    /// `slope distribution`, `facet visibility` or `waves`.
    pub taken: String,
    /// Time of the whole table by `auto` over all angles.
    pub seconds: f64,
    /// The next costlier method: `facet visibility` after the slope distribution, `waves` after that, none after waves.
    pub next: Option<String>,
    /// Time of the whole table by it.
    pub next_seconds: Option<f64>,
    pub next_moves: Option<f64>,
    /// From the table of every facet with its visibility in the same cells, and the error of that table; `None` where waves serve.
    pub from_facets: Option<f64>,
    pub from_facets_se: Option<f64>,
    /// From the same facets counted into the patches without a table, and the error of that count: what the cells add.
    pub from_count: Option<f64>,
    pub from_count_se: Option<f64>,
    /// Expected distance between the count and the surface, of which the map is a sample: from sixteen places of the map.
    pub map_error: f64,
    /// From waves. Where waves serve themselves: from those at the finest tolerance.
    pub from_waves: Option<f64>,
    /// Where waves may not be believed themselves (too steep, too curved or too much hidden), they judge nobody.
    pub waves_hold: bool,
    /// Expected distance between waves on the map and on the surface, of which the map is a sample: from groups of speckles.
    pub waves_error: f64,
    /// Where rays serve and waves hold: whether they are nearer to waves than the tolerance and twice what chance makes of both.
    pub waves_agree: Option<bool>,
    /// Within the tolerance of the costliest method of its kind: rays of every facet with its visibility, waves of those at the
    /// finest tolerance.
    pub within: bool,
    /// The cells, too, move less than the tolerance, or than another map of the surface would.
    pub resolved: bool,
}

impl Row {
    /// Within `tolerance`, given the standard error of what is compared with.
    fn holds(&self, off: Option<f64>, error: Option<f64>) -> bool {
        off.is_none_or(|off| off <= self.tolerance + error.unwrap_or(0.0))
    }
}

/// One table over all angles.
struct Served {
    found: Scatter,
    table: Table,
    seconds: f64,
}

impl Served {
    fn new(map: &HeightMap, method: Method, tolerance: f64) -> Result<Served> {
        let theta_i = ANGLES.map(f64::to_radians).to_vec();
        // An anisotropic table is judged at one azimuth; the others are served alike, by facets of their own.
        let options = Options { method, tolerance, material: GLASS, theta_i, phi_i: vec![0.0], ..Options::default() };
        let start = Instant::now();
        let found = scatter(map, &options, &|_| ())?;
        let table = Table::from_scatter(&found, Provenance::default());
        Ok(Served { found, table, seconds: start.elapsed().as_secs_f64() })
    }

    /// Where the light from the azimuth 0 goes.
    fn patches(&self, theta_i: f64) -> Vec<f64> {
        tabulated(&self.table, theta_i, 0.0)
    }

    /// The same table of every facet with its visibility, lit so many times where azimuths are averaged.
    fn by_every_facet(&self, surface: &Surface, times: f64) -> Served {
        let start = Instant::now();
        let mut found = self.found.clone();
        for (k, decision) in self.found.decisions.iter().enumerate().filter(|d| !d.1.wave) {
            let sum = |phi: &f64| {
                let azimuth = if found.isotropic { Azimuth::Averaged } else { Azimuth::Fixed(*phi) };
                let selection = Selection::share(times);
                facet_sum(&surface.walk(), &self.found.cells, decision.theta_i, azimuth, &selection).tally()
            };
            found.tallies[k] = self.found.phi_i.iter().map(sum).collect();
        }
        let table = Table::from_scatter(&found, Provenance::default());
        Served { found, table, seconds: start.elapsed().as_secs_f64() }
    }
}

/// All facets counted without a table.
struct Count {
    patches: Vec<f64>,
    /// Of the average over azimuths; 0 for one azimuth.
    error: f64,
    map_error: f64,
}

impl Count {
    /// For the source at azimuth 0, or for all azimuths: the difference of every other one tells the error.
    fn new(surface: &Surface, theta_i: f64, isotropic: bool) -> Count {
        let walk = surface.walk();
        let map_error = counted_by_places(&walk, theta_i);
        if !isotropic {
            return Count { patches: counted(&walk, theta_i, 0.0, &Selection::default()), error: 0.0, map_error };
        }
        let mut halves = [0, 1].map(|_| vec![0.0; 0]);
        for k in 0..AZIMUTHS {
            let phi = TAU * f64::from(k) / f64::from(AZIMUTHS);
            let own = counted(&walk, theta_i, phi, &Selection::default());
            let half = &mut halves[k as usize % 2];
            half.resize(own.len(), 0.0);
            half.iter_mut().zip(own).for_each(|(sum, e)| *sum += 2.0 * e / f64::from(AZIMUTHS));
        }
        let error = 0.5 * Moved.between(&halves[0], &halves[1]);
        let patches = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect();
        Count { patches, error, map_error }
    }
}

/// What `auto` does with `map` at every tolerance and angle.
///
/// # Errors
/// `Error::Parameter` for a map without facets.
pub fn choose(map: &HeightMap, name: &str, tolerances: &[f64]) -> Result<Vec<Row>> {
    let surface = Surface::new(map, name)?;
    let waves = Served::new(map, Method::Kirchhoff, 0.01)?;
    let waves_error = tabulated_by_subareas(&waves.table, &ANGLES.map(f64::to_radians));
    let mut finest_first = tolerances.to_vec();
    finest_first.sort_by(f64::total_cmp);
    let mut counts: Vec<Count> = Vec::new();
    // Waves serve the same angles at every tolerance; the finest cells judge the others.
    let mut finest: Vec<Vec<f64>> = Vec::new();
    let mut rows = Vec::new();
    for &tolerance in &finest_first {
        let auto = Served::new(map, Method::Auto, tolerance)?;
        let times = (BEAMS / surface.statistics.facets as f64).ceil().clamp(4.0, 16.0);
        let facets = auto.by_every_facet(&surface, times);
        let fewer = auto.found.isotropic.then(|| auto.by_every_facet(&surface, times / 4.0));
        for (k, d) in auto.found.decisions.iter().enumerate() {
            if counts.len() <= k {
                counts.push(Count::new(&surface, d.theta_i, auto.found.isotropic));
            }
            let own = auto.patches(d.theta_i);
            if finest.len() <= k {
                finest.push(own.clone());
            }
            rows.push(row(
                name,
                tolerance,
                k,
                &own,
                &auto,
                (&facets, fewer.as_ref()),
                (&waves, waves_error[k]),
                &counts[k],
                &finest[k],
            ));
        }
    }
    // As they were asked for.
    let place = |row: &Row| tolerances.iter().position(|t| *t == row.tolerance);
    rows.sort_by_key(place);
    Ok(rows)
}

#[expect(clippy::too_many_arguments, reason = "one row compares all there is")]
fn row(
    name: &str,
    tolerance: f64,
    k: usize,
    own: &[f64],
    auto: &Served,
    (facets, fewer): (&Served, Option<&Served>),
    (waves, waves_error): (&Served, f64),
    count: &Count,
    finest: &[f64],
) -> Row {
    let d: &Decision = &auto.found.decisions[k];
    let judge = &waves.found.decisions[k];
    let by_rays = |value: f64| (!d.wave).then_some(value);
    let every = facets.patches(d.theta_i);
    let from_facets = by_rays(Moved.between(own, &every));
    // The error of an average falls with the number of azimuths: that of a quarter is four times as large.
    let chance = fewer.map_or(0.0, |fewer| Moved.between(&fewer.patches(d.theta_i), &every) / 3.0);
    let from_waves = Moved.between(own, if d.wave { finest.to_vec() } else { waves.patches(d.theta_i) }.as_slice());
    let (taken, next, next_seconds, next_moves) = match (d.wave, d.visibility) {
        (true, _) => ("waves", None, None, None),
        (false, true) => ("facet visibility", Some("waves"), Some(waves.seconds), Some(from_waves)),
        (false, false) => ("slope distribution", Some("facet visibility"), Some(facets.seconds), from_facets),
    };
    let mut row = Row {
        map: name.to_owned(),
        tolerance,
        theta_i_deg: d.theta_i.to_degrees(),
        rayleigh_g: d.rayleigh,
        isotropic: auto.found.isotropic,
        taken: taken.to_owned(),
        seconds: auto.seconds,
        next: next.map(str::to_owned),
        next_seconds,
        next_moves,
        from_facets,
        from_facets_se: by_rays(chance),
        from_count: by_rays(Moved.between(own, &count.patches)),
        from_count_se: by_rays(count.error),
        map_error: count.map_error,
        from_waves: Some(from_waves),
        waves_hold: judge.undersampled <= tolerance.max(0.01)
            && judge.tangent_plane >= 1.0
            && judge.unfollowed <= 0.5 * tolerance,
        waves_error,
        waves_agree: None,
        within: false,
        resolved: false,
    };
    // A few patches hold a lobe, so the distance that chance makes scatters by a third of its mean: twice it is beyond chance.
    let chance = 2.0 * row.map_error.hypot(waves_error);
    row.waves_agree = (!d.wave && row.waves_hold).then(|| row.holds(row.from_waves, Some(chance)));
    row.within = if d.wave { row.holds(row.from_waves, None) } else { row.holds(row.from_facets, row.from_facets_se) };
    row.resolved =
        row.holds(row.from_count, row.from_count_se) || row.from_count.is_some_and(|off| off <= row.map_error);
    row
}

/// One row per map, tolerance and angle.
pub fn csv(rows: &[Row], machine: &super::Machine) -> String {
    let mut csv = format!(
        "# {machine}\nmap,tolerance,theta_i_deg,rayleigh_g,isotropic,taken,seconds,next,next_seconds,next_moves,from_facets,\
         from_facets_se,from_count,from_count_se,map_error,from_waves,waves_hold,waves_error,waves_agree,within,resolved\n"
    );
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| format!("{v:.3e}"));
    for r in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            csv,
            "\"{}\",{},{:.0},{:.4e},{},{},{:.3e},{},{},{},{},{},{},{},{:.3e},{},{},{:.3e},{},{},{}",
            r.map.replace('"', "\"\""),
            r.tolerance,
            r.theta_i_deg,
            r.rayleigh_g,
            r.isotropic,
            r.taken,
            r.seconds,
            r.next.as_deref().unwrap_or("none"),
            number(r.next_seconds),
            number(r.next_moves),
            number(r.from_facets),
            number(r.from_facets_se),
            number(r.from_count),
            number(r.from_count_se),
            r.map_error,
            number(r.from_waves),
            r.waves_hold,
            r.waves_error,
            r.waves_agree.map_or_else(String::new, |agree| agree.to_string()),
            r.within,
            r.resolved
        );
    }
    csv
}
