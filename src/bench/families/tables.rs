//! Size of a table: `f_r` of a tabulated formula against the formula.

use crate::bench::method::{Answer, Distance, Family, Method, Reference};
use crate::bench::surface::GLASS;
use crate::facets::SlopeStatistics;
use crate::facets::distribution::Hiding;
use crate::heightmap::{Edges, HeightMap};
use crate::math::direction;
use crate::model;
use crate::optics::Brdf;
use crate::sample::TableBrdf;
use crate::scatter::slope_histogram::SlopeDensity;
use crate::scatter::{HalfVectorCells, Method as How, Options, Scatter};
use crate::table::{Provenance, Table};
use glam::DVec3;
use std::time::Instant;

/// Width of the lobe.
const ALPHA: f64 = 0.1;

/// Directions in which both are asked.
const PAIRS: u32 = 4096;

/// `Lambda` of a Beckmann surface (Smith 1967).
fn lambda(theta: f64) -> f64 {
    let v = 1.0 / (theta.tan().max(1e-300) * ALPHA);
    0.5 * (libm::erf(v) - 1.0) + (-v * v).exp() / (2.0 * v * std::f64::consts::PI.sqrt())
}

/// The formula as a map of very many facets would be counted: slope density and Smith's masking.
fn scattered(theta_i: &[f64], tolerance: f64) -> Option<Scatter> {
    let flat = HeightMap {
        heights: ndarray::Array2::zeros((2, 2)),
        pitch_x: 1e-6,
        pitch_y: 1e-6,
        edges: Edges::Open,
        removed_slopes: [0.0; 2],
    };
    let mut statistics = SlopeStatistics::measure(&flat).ok()?;
    (statistics.sdq, statistics.core, statistics.facets) = (ALPHA, 1.0, 1 << 40);
    let cells = HalfVectorCells::for_lobe(&statistics, true, tolerance);
    let p22 = |p: f64, q: f64| (-(p * p + q * q) / (ALPHA * ALPHA)).exp() / (std::f64::consts::PI * ALPHA * ALPHA);
    let mean = |k: usize| cells.points(k).iter().map(|x| p22(x.p, x.q)).sum::<f64>() / cells.points(k).len() as f64;
    let density = SlopeDensity { density: (0..cells.len()).map(mean).collect(), core: 0.0, subareas: Vec::new() };
    let hiding = Hiding::tabulate(lambda);
    let tallies =
        theta_i.iter().map(|&t| vec![density.tally(&cells, direction(t, 0.0), &GLASS, &hiding)]).collect::<Vec<_>>();
    Some(Scatter {
        isotropic: true,
        material: GLASS,
        method: How::Geometric,
        theta_i: theta_i.to_vec(),
        phi_i: vec![0.0],
        tallies,
        density,
        statistics,
        decisions: Vec::new(),
        wave: None,
        core_error: vec![0.0; theta_i.len()],
        cells,
    })
}

/// Pairs spread over the lobe at 5 to 70 deg, away from the nodes.
fn pairs(formula: &dyn Brdf) -> Vec<(DVec3, DVec3)> {
    let place = |k: u32, step: f64| (0.5 + step * f64::from(k)).fract();
    (0..PAIRS)
        .filter_map(|k| {
            let wi = direction((5.0 + 65.0 * place(k, 0.819_172_513_396_164_5)).to_radians(), 0.3);
            let u = [place(k, 0.671_043_606_703_789_2), place(k, 0.549_700_477_901_970_3)];
            formula.sample(wi, u).map(|s| (wi, s.wo))
        })
        .collect()
}

/// Finer cells at the 14 incident angles of the program, and more incident angles at its cells.
pub fn family<'a>() -> Family<'a> {
    let formula = model::parse(&format!("beckmann:alpha={ALPHA},n=1.5"), 550e-9).ok();
    let pairs = formula.as_deref().map(pairs).unwrap_or_default();
    let values = |brdf: &dyn Brdf| pairs.iter().map(|&(wi, wo)| brdf.eval(wi, wo)).collect::<Vec<f64>>();
    let reference = formula.as_deref().map(values).unwrap_or_default();
    let table = move |pairs: &[(DVec3, DVec3)], theta_i: &[f64], tolerance: f64| -> Answer {
        let found = scattered(theta_i, tolerance);
        let start = Instant::now();
        let brdf = found.and_then(|s| TableBrdf::new(Table::from_scatter(&s, Provenance::default())).ok());
        let time = Some(start.elapsed());
        let values = match brdf {
            Some(brdf) => pairs.iter().map(|&(wi, wo)| brdf.eval(wi, wo)).collect(),
            None => vec![f64::NAN; pairs.len()],
        };
        Answer { values, time }
    };
    let (for_cells, for_angles) = (pairs.clone(), pairs);
    Family {
        id: "table".into(),
        title: "Size of a table".into(),
        error: "relative error of f_r",
        distance: Distance::Relative,
        reference: Reference {
            text: format!(
                "tabulated Beckmann lobe of alpha {ALPHA} against its formula, 5\u{b0} to 70\u{b0}; time to build"
            ),
            values: reference,
            noise: 0.0,
        },
        methods: vec![
            Method::new("finer cells", "cell tolerance", [0.04, 0.01, 0.0025], move |tol, _| {
                table(&for_cells, &Options::default().theta_i, tol)
            })
            .taken_at(0.01)
            .hungry(2.0),
            Method::new("more angles", "angles", [3.0, 6.0, 12.0, 24.0], move |n, _| {
                let step = 88.0 / (n - 1.0);
                let theta_i: Vec<f64> = (0..n as u32).map(|k| (step * f64::from(k)).to_radians()).collect();
                table(&for_angles, &theta_i, 0.01)
            })
            .hungry(2.0),
        ],
    }
}
