//! How large a table must be: gloss of the table against gloss of the facets it was made from.

use super::contests::{Subject, table};
use super::race::{Contest, Method, Outcome, Reference};
use crate::error::Result;
use crate::meter::{self, Azimuths, Geometry, facet_gloss, gloss};
use crate::sample::TableBrdf;
use crate::scatter;

/// The facets are read straight into the stops of the glossmeter, without any table.
pub fn contest<'a>(subject: &'a Subject<'a>, _: &'a TableBrdf) -> Result<Contest<'a>> {
    let three = Geometry::standard_three();
    let isotropic = crate::facets::SlopeStatistics::measure(subject.map)?.looks_isotropic();
    let quarters = || (0..4).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4).collect::<Vec<_>>();
    let azimuths = if isotropic { Azimuths::All } else { Azimuths::At(quarters()) };
    let straight = facet_gloss(subject.map, &subject.material, &three, &azimuths)?;
    let reference = straight.gloss.iter().map(|g| g.value).collect();
    let run = move |tolerance: f64, _: u64| {
        let brdf = table(subject, tolerance, scatter::Method::Geometric)?;
        let mut options = meter::Options { tolerance: 0.003, ..meter::Options::default() };
        if !isotropic {
            options = options.with_azimuths(quarters());
        }
        let values = Geometry::standard_three().map(|g| gloss(&brdf, &g, &options).value).to_vec();
        let t = brdf.table();
        Ok(Outcome { values, size: Some((t.cells().len() * t.theta_i().len() * t.phi_i().len()) as f64) })
    };
    Ok(Contest {
        key: "tables",
        title: "Table: making it and reading its gloss".into(),
        error: "largest error of gloss at 20/60/85\u{b0}, GU",
        effort: "tolerance",
        size: Some("cells x incident directions"),
        references: vec![Reference { name: "facets straight into the stops".into(), values: reference, noise: 0.0 }],
        methods: vec![Method {
            name: "table by tolerance".into(),
            ladder: vec![0.3, 0.1, 0.03, 0.01, 0.003, 0.001],
            chosen: Some(scatter::Options::default().tolerance),
            random: false,
            reference: 0,
            run: Box::new(run),
        }],
        distance: |a, b| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max),
    })
}
