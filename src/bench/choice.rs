//! What `auto` chooses for a map, what the next costlier method would have changed, and whether it was within the tolerance.

use crate::error::Result;
use crate::heightmap::HeightMap;
use crate::math::direction;
use crate::optics::{Brdf, Material};
use crate::sample::TableBrdf;
use crate::scatter::detectors::{Detectors, Rings};
use crate::scatter::{Decision, Method, Options, Symmetry, scatter};
use crate::table::{Provenance, Table};
use serde::Serialize;
use std::fmt::Write;
use std::time::Instant;

/// Incident angles that are looked at \[deg\].
pub const ANGLES: [f64; 5] = [0.0, 20.0, 45.0, 60.0, 75.0];
/// Shares of the energy that may be wrong.
pub const TOLERANCES: [f64; 3] = [0.05, 0.01, 0.001];

/// Directions per comparison.
const DRAWS: u32 = 16384;

/// What served one incident angle, and how far it is from the costlier methods.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    pub map: String,
    pub tolerance: f64,
    pub theta_i_deg: f64,
    /// Rayleigh parameter.
    pub rayleigh_g: f64,
    /// `slope distribution`, `facet visibility` or `waves`.
    pub taken: String,
    /// Time of the whole table by `auto` over all angles.
    pub seconds: f64,
    /// The next costlier method: `facet visibility` after the slope distribution, `waves` after that, none after waves.
    pub next: Option<String>,
    /// Time of the whole table by it.
    pub next_seconds: Option<f64>,
    /// Share of the energy, over the patches of Klems, that it puts elsewhere.
    pub next_moves: Option<f64>,
    /// The same against every facet with its visibility; `None` where waves serve.
    pub from_facets: Option<f64>,
    /// The same against waves.
    pub from_waves: Option<f64>,
    /// Where waves may not be believed themselves (too steep, too curved or too much hidden), they judge nobody.
    pub waves_hold: bool,
    /// Within the tolerance of the costliest method that holds.
    pub within: bool,
}

/// How one method served all angles.
struct Served {
    brdf: TableBrdf,
    decisions: Vec<Decision>,
    seconds: f64,
}

fn serve(map: &HeightMap, method: Method, tolerance: f64) -> Result<Served> {
    let options = Options {
        method,
        tolerance,
        material: Material::Dielectric { n: 1.5 },
        theta_i: ANGLES.map(f64::to_radians).to_vec(),
        // One azimuth: an average over azimuths would add the chance of which facet is lit from where.
        symmetry: Symmetry::Anisotropic,
        phi_i: vec![0.0],
        ..Options::default()
    };
    let start = Instant::now();
    let found = scatter(map, &options, &|_| ())?;
    let decisions = found.decisions.clone();
    let brdf = TableBrdf::new(Table::from_scatter(&found, Provenance::default()))?;
    Ok(Served { brdf, decisions, seconds: start.elapsed().as_secs_f64() })
}

/// `1/2 sum |A_k - B_k| / sum B_k` over the patches of Klems: the share of the light that lies elsewhere, mirror beam included.
///
/// The patches of both are integrated over the same directions, drawn half from each.
fn moved(a: &TableBrdf, b: &TableBrdf, theta_i: f64) -> f64 {
    let patches = Rings::klems();
    let wi = direction(theta_i, 0.0);
    let mut energy = vec![[0.0; 2]; patches.len()];
    let place = |k: u32, step: f64| (0.5 + step * f64::from(k)).fract();
    // Shares of the draws that are not spent on the mirror beam are known through the density itself.
    for k in 0..DRAWS {
        let u = [place(k, 0.754_877_666_246_692_7), place(k, 0.569_840_290_998_053_3)];
        let Some(s) = (if k % 2 == 0 { a.sample(wi, u) } else { b.sample(wi, u) }) else { continue };
        if s.specular {
            continue;
        }
        let ((fa, pa), (fb, pb)) = (a.eval_and_pdf(wi, s.wo), b.eval_and_pdf(wi, s.wo));
        let weight = s.wo.z / (0.5 * (pa + pb)) / f64::from(DRAWS);
        let sums = &mut energy[patches.index(wi, s.wo)];
        sums[0] += fa * weight;
        sums[1] += fb * weight;
    }
    let mirror = patches.index(wi, direction(theta_i, std::f64::consts::PI));
    energy[mirror][0] += a.specular_core(wi);
    energy[mirror][1] += b.specular_core(wi);
    let whole: f64 = energy.iter().map(|e| e[1]).sum();
    0.5 * energy.iter().map(|e| (e[0] - e[1]).abs()).sum::<f64>() / whole.max(f64::MIN_POSITIVE)
}

/// What `auto` does with `map` at every tolerance and angle.
///
/// # Errors
/// `Error::Parameter` for a map without facets.
pub fn choose(map: &HeightMap, name: &str, tolerances: &[f64]) -> Result<Vec<Row>> {
    let finest = tolerances.iter().copied().fold(0.01, f64::min);
    let facets = serve(map, Method::Facets, finest)?;
    let waves = serve(map, Method::Kirchhoff, 0.01)?;
    let mut rows = Vec::new();
    for &tolerance in tolerances {
        let auto = serve(map, Method::Auto, tolerance)?;
        for (k, d) in auto.decisions.iter().enumerate() {
            let judge = &waves.decisions[k];
            let waves_hold = judge.undersampled <= tolerance.max(0.01)
                && judge.tangent_plane >= 1.0
                && judge.unfollowed <= 0.5 * tolerance;
            let from_waves = Some(moved(&auto.brdf, &waves.brdf, d.theta_i));
            let from_facets = (!d.wave).then(|| moved(&auto.brdf, &facets.brdf, d.theta_i));
            let (taken, next, next_seconds, next_moves) = match (d.wave, d.visibility) {
                (true, _) => ("waves", None, None, None),
                (false, true) => ("facet visibility", Some("waves"), Some(waves.seconds), from_waves),
                (false, false) => ("slope distribution", Some("facet visibility"), Some(facets.seconds), from_facets),
            };
            rows.push(Row {
                map: name.to_owned(),
                tolerance,
                theta_i_deg: d.theta_i.to_degrees(),
                rayleigh_g: d.rayleigh,
                taken: taken.to_owned(),
                seconds: auto.seconds,
                next: next.map(str::to_owned),
                next_seconds,
                next_moves,
                from_facets,
                from_waves,
                waves_hold,
                within: from_facets.is_none_or(|moved| moved <= tolerance),
            });
        }
    }
    Ok(rows)
}

/// One row per map, tolerance and angle.
pub fn csv(rows: &[Row], machine: &super::Machine) -> String {
    let mut csv = format!(
        "# {machine}\nmap,tolerance,theta_i_deg,rayleigh_g,taken,seconds,next,next_seconds,next_moves,from_facets,from_waves,\
         waves_hold,within\n"
    );
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| format!("{v:.3e}"));
    for r in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            csv,
            "\"{}\",{},{:.0},{:.4e},{},{:.3e},{},{},{},{},{},{},{}",
            r.map.replace('"', "\"\""),
            r.tolerance,
            r.theta_i_deg,
            r.rayleigh_g,
            r.taken,
            r.seconds,
            r.next.as_deref().unwrap_or("none"),
            number(r.next_seconds),
            number(r.next_moves),
            number(r.from_facets),
            number(r.from_waves),
            r.waves_hold,
            r.within
        );
    }
    csv
}
