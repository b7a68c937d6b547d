//! Drawing directions: the reflectance of a table at one incident angle as the mean weight of N draws.

use crate::bench::method::{Distance, Family, Method, Reference, half_decades};
use crate::bench::surface::{GLASS, gaussian};
use crate::error::Result;
use crate::math::direction;
use crate::math::random::CounterRng;
use crate::optics::Brdf;
use crate::sample::TableBrdf;
use crate::sample::rivals::{CosineSampled, CumulativeSampled, UniformSampled};
use crate::scatter::{Method as How, Options, scatter};
use crate::table::{Provenance, Table};

/// Between two nodes of the table.
const THETA_I: f64 = 47.0;

/// The table that is drawn from: alpha 0.02, by rays.
///
/// # Errors
/// Never in practice: the map is ours.
pub fn table() -> Result<TableBrdf> {
    let map = gaussian(512, 1e-6, 0.1e-6, 10e-6, 3)?;
    let options = Options { method: How::Geometric, material: GLASS, ..Options::default() };
    TableBrdf::new(Table::from_scatter(&scatter(&map, &options, &|_| ())?, Provenance::default()))
}

/// Mean weight of `draws` draws.
fn mean_weight(brdf: &dyn Brdf, draws: f64, seed: u64) -> Vec<f64> {
    let wi = direction(THETA_I.to_radians(), 0.0);
    let weight = |k: u64| {
        let [u, v, ..] = CounterRng::four(seed, 11, k);
        brdf.sample(wi, [u, v]).map_or(0.0, |s| s.weight)
    };
    vec![(0..draws as u64).map(weight).sum::<f64>() / draws]
}

/// Alias against its rivals, one thread.
pub fn family(table: &TableBrdf) -> Family<'_> {
    let cumulative = CumulativeSampled::new(table);
    let draws = || half_decades(2, 7);
    Family {
        id: "sampling".into(),
        title: "Drawing from a table".into(),
        error: "relative error of the reflectance",
        distance: Distance::Relative,
        reference: Reference {
            text: format!(
                "table of a surface of alpha 0.02 ({} cells), incident at {THETA_I:.0}\u{b0}, against its own integral; one thread",
                table.table().cells().len()
            ),
            values: vec![table.albedo(THETA_I.to_radians())],
            noise: 0.0,
        },
        methods: vec![
            Method::new("alias tables", "draws", draws(), |n, seed| mean_weight(table, n, seed).into())
                .random()
                .taken_at(1e3),
            Method::new("inversion of sums", "draws", draws(), move |n, seed| mean_weight(&cumulative, n, seed).into())
                .random(),
            Method::new("cosine", "draws", draws(), |n, seed| mean_weight(&CosineSampled(table), n, seed).into())
                .random(),
            Method::new("uniform", "draws", draws(), |n, seed| mean_weight(&UniformSampled(table), n, seed).into())
                .random(),
        ],
    }
}
