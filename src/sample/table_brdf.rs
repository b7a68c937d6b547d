//! A table that can be drawn from.

use super::alias::AliasTable;
use super::azimuths::Served;
use super::hats::Hats;
use super::run::{self, SourceTables};
use super::slabs::Slabs;
use super::slots::Slots;
use super::sources::Sources;
use crate::error::Result;
use crate::math::direction;
use crate::math::frame::theta;
use crate::optics::{Brdf, BrdfSample};
use crate::scatter::axis::{at_least, at_most};
use crate::table::{Table, albedos};
use glam::{DVec3, Vec4};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

/// Share of its density that a cell keeps as sampling weight when it lies below the horizon of the node: between two
/// nodes, or in a corner, it may still reflect.
const SLIVER: f64 = 1e-3;

/// Cosines below this count as the horizon.
pub(super) const HORIZON: f64 = 1e-9;

/// Azimuths over which the albedo of a surface with a grain is averaged: the default nodes, between which a table is straight.
const ALBEDO_AZIMUTHS: usize = 12;
/// Steps of the albedo from 0 to 90 deg.
const ALBEDO_STEPS: usize = 128;
/// The last of them, short of the horizon \[rad\].
const ALBEDO_LAST: f64 = FRAC_PI_2 * (1.0 - 1e-4);

/// A [`Table`] with one alias table per incident node.
///
/// `pdf(wi, wo) = sum over nodes n of w_n [ d_n cos_theta_r / pi + (1 - c_n - d_n) sum over cells k of p_n(k) hat_k / H_k /
/// (4 cos_beta cos^3 theta_h) ]`: node by its interpolation weight, then specular core with probability `c_n`, diffuse floor
/// with `d_n` by the cosine, or cell `k` by alias and a slope under the hat by which the cell enters the interpolation, `H_k`
/// its integral. So draws follow the interpolated table, and where it is 0 none falls. Draws whose mirror direction lies
/// below the horizon carry nothing; the pdf integrates to 1 minus their share and the core's.
pub struct TableBrdf {
    pub(super) table: Table,
    /// Per node; `None` where only core and floor reflect.
    aliases: Vec<Option<AliasTable>>,
    pub(super) sources: Sources,
    pub(super) source_tables: SourceTables,
    pub(super) slots: Slots,
    pub(super) slabs: Slabs,
    pub(super) hats: Hats,
    /// Per node: probabilities of core and floor, `f_r` of the floor.
    pub(super) facts: Vec<Vec4>,
    /// No node has a core or a floor.
    pub(super) glossy: bool,
    /// That, and the same at every azimuth.
    pub(super) plain: bool,
    /// Albedo at even steps of theta_i, each worked out when first asked for.
    albedo: Vec<OnceLock<f64>>,
}

impl TableBrdf {
    /// Builds the alias tables: weight of a cell = energy the table sends through its hat.
    ///
    /// # Errors
    /// `Error::Parameter` if a density is not a finite, non-negative number.
    pub fn new(table: Table) -> Result<Self> {
        let cells = &table.cells;
        let phis = table.phi_i.len();
        let hats = Hats::new(cells);
        let integrals: Vec<f64> = (0..cells.len()).map(|k| hats.integral(cells.column_and_row(k))).collect();
        let served = Served::new(&table);
        let built: Vec<(Option<AliasTable>, Vec4, Vec<f32>)> = (0..table.nodes.len())
            .into_par_iter()
            .map(|node| {
                let wi = direction(table.theta_i[node / phis], table.phi_i[node % phis]);
                let facts = &table.nodes[node];
                let density = &table.density[table.node_range(node)];
                let energies = served.energies(node);
                let sliver = SLIVER * table.material.reflectance(1.0);
                let weights: Vec<f64> =
                    (0..cells.len()).map(|k| density[k] * energies[k].max(sliver * integrals[k])).collect();
                let rest = weights.iter().sum::<f64>();
                let mirror = facts.core_share * table.material.reflectance(wi.z);
                let all = mirror + facts.diffuse + rest;
                // Of 24 bits, as lanes hold them.
                let probability = |energy: f64| if energy > 0.0 { f64::from((energy / all) as f32) } else { 0.0 };
                let (core, floor) = (probability(mirror), probability(facts.diffuse));
                let others = (1.0 - core - floor).max(0.0);
                let mut draws = vec![0.0f32; cells.len()];
                let mut alias = None;
                if rest > 0.0 || !rest.is_finite() {
                    let built = AliasTable::new(&weights)?;
                    for (k, p) in built.probabilities().into_iter().enumerate() {
                        draws[k] = (p * others / integrals[k]) as f32;
                    }
                    alias = Some(built);
                }
                let facts = Vec4::from([core, floor, facts.diffuse / PI, 0.0].map(|x| x as f32));
                Ok((alias, facts, draws))
            })
            .collect::<Result<_>>()?;
        let (mut aliases, mut facts, mut draws) = (Vec::new(), Vec::new(), Vec::new());
        for node in built {
            aliases.push(node.0);
            facts.push(node.1);
            draws.push(node.2);
        }
        let sources = Sources::new(&table);
        let source_tables = SourceTables::new(&table, &sources);
        let slabs = Slabs::new(&table, &draws);
        let slots = Slots::new(cells, aliases.iter().map(Option::as_ref));
        let glossy = facts.iter().all(|node| node.x == 0.0 && node.y == 0.0);
        Ok(TableBrdf {
            facts,
            aliases,
            sources,
            source_tables,
            slots,
            slabs,
            hats,
            glossy,
            plain: glossy && table.isotropic,
            albedo: vec![OnceLock::new(); ALBEDO_STEPS + 1],
            table,
        })
    }

    /// The table behind the sampler.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The alias table of a node, `None` where only the core reflects.
    pub fn alias(&self, node: usize) -> Option<&AliasTable> {
        self.aliases[node].as_ref()
    }

    /// Albedo at a step, the mean over azimuths.
    fn albedo_step(&self, k: usize) -> f64 {
        if let Some(known) = self.albedo[k].get() {
            return *known;
        }
        let theta_i = ALBEDO_LAST * k as f64 / ALBEDO_STEPS as f64;
        let azimuths = if self.table.isotropic || k == 0 { 1 } else { ALBEDO_AZIMUTHS };
        let at = |j: usize| direction(theta_i, TAU * j as f64 / azimuths as f64);
        let all = albedos(&self.table, &(0..azimuths).map(at).collect::<Vec<_>>());
        // Two that ask at once find the same.
        *self.albedo[k].get_or_init(|| all.iter().sum::<f64>() / azimuths as f64)
    }

    /// Whether [`run`] can draw from it: there is a lobe at every node.
    pub(super) fn runs(&self) -> bool {
        self.slots.nodes.iter().all(|node| node.count > 0)
    }
}

impl Brdf for TableBrdf {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.both(wi, wo).0
    }

    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        self.sample_by(wi, u, |node, u| self.slots.draw(node, u))
    }

    fn sample_many(&self, wi: &[DVec3], u: &[[f64; 2]], out: &mut [Option<BrdfSample>]) {
        run::sample(self, wi, u, out);
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.both(wi, wo).1
    }

    fn eval_and_pdf(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        self.both(wi, wo)
    }

    fn eval_and_pdf_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [(f64, f64)]) {
        run::eval_and_pdf(self, wi, wo, out);
    }

    /// Of the interpolated table; between the nodes the Fresnel reflectance does not run straight.
    fn albedo(&self, theta_i: f64) -> f64 {
        let x = at_most(at_least(theta_i / ALBEDO_LAST, 0.0), 1.0) * ALBEDO_STEPS as f64;
        let k = (x as usize).min(ALBEDO_STEPS - 1);
        let [below, above] = [k, k + 1].map(|k| self.albedo_step(k));
        below + (x - k as f64) * (above - below)
    }

    /// By quadrature at that very direction: it takes as long as many thousand draws.
    fn albedo_towards(&self, wi: DVec3) -> f64 {
        // The horizon itself reflects what comes from just above it.
        albedos(&self.table, &[direction(at_most(theta(wi), ALBEDO_LAST), wi.y.atan2(wi.x))])[0]
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.table.core(wi)
    }
}
