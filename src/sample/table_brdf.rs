//! A table that can be drawn from.

use super::alias::AliasTable;
use super::hats::Hats;
use super::run::{self, SourceTables};
use super::slabs::{Found, Slabs};
use super::slots::Slots;
use super::sources::Sources;
use crate::error::Result;
use crate::math::direction;
use crate::optics::{Brdf, BrdfSample};
use crate::scatter::axis::{at_least, at_most};
use crate::table::{Incident, Place, Table, albedos, mesh, not_below};
use glam::{DVec3, Vec4};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

/// Share of its density that a cell keeps as sampling weight when it lies below the horizon of the node: between two
/// nodes, or in a corner, it may still reflect.
const SLIVER: f64 = 1e-3;

/// Cosines below this count as the horizon.
pub(super) const HORIZON: f64 = 1e-9;

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
    nodes: Vec<Sampler>,
    pub(super) sources: Sources,
    pub(super) source_tables: SourceTables,
    pub(super) slots: Slots,
    pub(super) slabs: Slabs,
    pub(super) hats: Hats,
    /// Per node, for runs: probabilities of core and floor, `f_r` of the floor, reflecting share of the core.
    pub(super) facts: Vec<Vec4>,
    /// No node has a core or a floor.
    pub(super) glossy: bool,
    /// That, and the same at every azimuth.
    plain: bool,
    /// Albedo at even steps of theta_i, worked out when first asked for.
    albedo: OnceLock<Vec<f64>>,
}

/// How one node draws.
struct Sampler {
    /// `None` where only core and floor reflect.
    alias: Option<AliasTable>,
    /// Probabilities of the core and of the floor.
    core: f64,
    floor: f64,
    /// `f_r` of the floor and reflecting share of the core.
    diffuse: f64,
    core_share: f64,
}

/// The facts of the nodes around one `wi`, blended.
#[derive(Default)]
struct Blend {
    core: f64,
    floor: f64,
    diffuse: f64,
    core_share: f64,
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
        let mesh = mesh(&table);
        let built: Vec<(Sampler, Vec<f32>)> = (0..table.nodes.len())
            .into_par_iter()
            .map(|node| {
                let wi = direction(table.theta_i[node / phis], table.phi_i[node % phis]);
                let facts = &table.nodes[node];
                let density = &table.density[table.node_range(node)];
                let energies = mesh.hat_energies(cells.len(), wi, &table.material);
                let sliver = SLIVER * table.material.reflectance(1.0);
                let weights: Vec<f64> =
                    (0..cells.len()).map(|k| density[k] * energies[k].max(sliver * integrals[k])).collect();
                let rest = weights.iter().sum::<f64>();
                let mirror = facts.core_share * table.material.reflectance(wi.z);
                let all = mirror + facts.diffuse + rest;
                // Of 24 bits, as lanes hold them.
                let probability = |energy: f64| if energy > 0.0 { f64::from((energy / all) as f32) } else { 0.0 };
                let (core, floor) = (probability(mirror), probability(facts.diffuse));
                let mut draws = vec![0.0f32; cells.len()];
                let mut alias = None;
                if rest > 0.0 || !rest.is_finite() {
                    let built = AliasTable::new(&weights)?;
                    for (k, p) in built.probabilities().into_iter().enumerate() {
                        draws[k] = (p * (1.0 - core - floor) / integrals[k]) as f32;
                    }
                    alias = Some(built);
                }
                let sampler = Sampler { alias, core, floor, diffuse: facts.diffuse / PI, core_share: facts.core_share };
                Ok((sampler, draws))
            })
            .collect::<Result<_>>()?;
        let (nodes, draws): (Vec<Sampler>, Vec<Vec<f32>>) = built.into_iter().unzip();
        let sources = Sources::new(&table);
        let source_tables = SourceTables::new(&table, &sources);
        let slabs = Slabs::new(&table, &draws);
        let slots = Slots::new(cells, nodes.iter().map(|node| node.alias.as_ref()));
        let glossy = nodes.iter().all(|node| node.core == 0.0 && node.floor == 0.0);
        let facts =
            nodes.iter().map(|n| Vec4::from([n.core, n.floor, n.diffuse, n.core_share].map(|x| x as f32))).collect();
        Ok(TableBrdf {
            facts,
            nodes,
            sources,
            source_tables,
            slots,
            slabs,
            hats,
            glossy,
            plain: glossy && table.isotropic,
            albedo: OnceLock::new(),
            table,
        })
    }

    /// The table behind the sampler.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The alias table of a node, `None` where only the core reflects.
    pub fn alias(&self, node: usize) -> Option<&AliasTable> {
        self.nodes[node].alias.as_ref()
    }

    /// Whether [`run`] can draw from it: there is a lobe at every node.
    pub(super) fn runs(&self) -> bool {
        self.slots.nodes.iter().all(|node| node.count > 0)
    }

    /// Blends what every node says about core and floor.
    #[inline(always)]
    fn blend(&self, place: &Place) -> Blend {
        if self.glossy {
            return Blend::default();
        }
        let phis = self.table.phi_i.len();
        let next = (place.theta + 1).min(self.table.theta_i.len() - 1);
        let mix = |a: &Sampler, b: &Sampler, t: f64| Blend {
            core: a.core + t * (b.core - a.core),
            floor: a.floor + t * (b.floor - a.floor),
            diffuse: a.diffuse + t * (b.diffuse - a.diffuse),
            core_share: a.core_share + t * (b.core_share - a.core_share),
        };
        let [p0, p1] = place.phi;
        let near = mix(&self.nodes[place.theta * phis + p0], &self.nodes[next * phis + p0], place.u);
        if phis == 1 {
            return near;
        }
        let far = mix(&self.nodes[place.theta * phis + p1], &self.nodes[next * phis + p1], place.u);
        let v = place.v;
        Blend {
            core: near.core + v * (far.core - near.core),
            floor: near.floor + v * (far.floor - near.floor),
            diffuse: near.diffuse + v * (far.diffuse - near.diffuse),
            core_share: near.core_share + v * (far.core_share - near.core_share),
        }
    }

    /// Everything about `wi` that its many `wo` share; `wi` must be above the horizon.
    #[inline(always)]
    fn incident<const ISO: bool>(&self, wi: DVec3) -> Incident {
        if ISO { self.sources.incident(wi) } else { self.table.incident(wi) }
    }

    /// `cos_theta_i cos_theta_r / G`.
    #[inline(always)]
    fn cosines(&self, incident: &Incident, cos_theta_r: f64) -> f64 {
        let cos_theta_i = incident.wi.z;
        (cos_theta_i + incident.masked) * cos_theta_r + cos_theta_i * self.sources.masked(cos_theta_r)
    }

    /// `f_r` and pdf of `wo` for a `wi`.
    #[inline(always)]
    fn both(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        if !(wi.z > HORIZON && wo.z > HORIZON) {
            (0.0, 0.0)
        } else if self.plain {
            self.found::<true>(&self.incident::<true>(wi), wo)
        } else {
            self.found_of_any(wi, wo)
        }
    }

    /// The same of any table, above the horizon; a call of its own, so that the plain one stays small.
    #[inline(never)]
    fn found_of_any(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        if self.table.isotropic {
            self.with_floor(&self.incident::<true>(wi), wo, Self::found::<true>)
        } else {
            self.with_floor(&self.incident::<false>(wi), wo, Self::found::<false>)
        }
    }

    #[inline(always)]
    fn with_floor(
        &self,
        incident: &Incident,
        wo: DVec3,
        found: impl Fn(&Self, &Incident, DVec3) -> (f64, f64),
    ) -> (f64, f64) {
        let (rest, pdf) = found(self, incident, wo);
        let blend = self.blend(&incident.place);
        (rest + blend.diffuse, pdf + blend.floor * wo.z / PI)
    }

    /// The same of the glossy rest alone, both above the horizon.
    #[inline(always)]
    fn found<const ISO: bool>(&self, incident: &Incident, wo: DVec3) -> (f64, f64) {
        let sum = incident.wi + wo;
        let length2 = sum.length_squared();
        // One division for all that is divided by.
        let cosines = 4.0 * self.cosines(incident, wo.z);
        let inverse = 1.0 / (cosines * sum.z);
        let per_z = inverse * cosines;
        let slope = incident.in_cells(sum * -per_z);
        let found = self.slabs.at::<ISO>(&incident.place, [slope.x, slope.y]);
        // cos_beta = |wi + wo| / 2 and cos_theta_h = sum.z / |wi + wo|.
        let steepness = length2 * per_z * per_z;
        let reflectance = self.table.material.reflectance_of_square(at_most(0.25 * length2, 1.0));
        let density = f64::from(found.density);
        let rest = incident.balance * reflectance * density * steepness * steepness * inverse * sum.z;
        let pdf = f64::from(found.draws) * 0.5 * steepness * per_z;
        (rest, pdf)
    }

    /// A draw whose cell, column and row, comes from `draw(node, u)`, with what is left of `u`.
    #[inline(always)]
    pub(super) fn sample_by(
        &self,
        wi: DVec3,
        u: [f64; 2],
        draw: impl Fn(usize, f64) -> Option<([u16; 2], f32)>,
    ) -> Option<BrdfSample> {
        if !(wi.z > HORIZON) {
            None
        } else if self.plain {
            self.drawn::<true, true>(&self.incident::<true>(wi), u, draw)
        } else {
            self.drawn_of_any(wi, u, draw)
        }
    }

    /// The same of any table, above the horizon; a call of its own, so that the plain one stays small.
    #[inline(never)]
    fn drawn_of_any(
        &self,
        wi: DVec3,
        u: [f64; 2],
        draw: impl Fn(usize, f64) -> Option<([u16; 2], f32)>,
    ) -> Option<BrdfSample> {
        if self.table.isotropic {
            self.drawn::<true, false>(&self.incident::<true>(wi), u, draw)
        } else {
            self.drawn::<false, false>(&self.incident::<false>(wi), u, draw)
        }
    }

    #[inline(always)]
    fn drawn<const ISO: bool, const PLAIN: bool>(
        &self,
        incident: &Incident,
        u: [f64; 2],
        draw: impl Fn(usize, f64) -> Option<([u16; 2], f32)>,
    ) -> Option<BrdfSample> {
        let wi = incident.wi;
        let place = &incident.place;
        let blend = if PLAIN { Blend::default() } else { self.blend(place) };
        // The second number picks the node and its branch, and what is left of it the place inside the cell.
        let phis = if ISO { 1 } else { self.table.phi_i.len() };
        let (upper, mut left) = self.table.finder.choose(place, wi.z, u[1]);
        let mut phi = place.phi[0];
        if phis > 1 {
            let (second, rest) = choose(place.v, left);
            (phi, left) = (place.phi[second], rest);
        }
        let theta = (place.theta + upper).min(self.table.theta_i.len() - 1);
        let node = theta * phis + phi;
        if !PLAIN {
            let facts = &self.nodes[node];
            if left < facts.core {
                return Some(BrdfSample {
                    wo: DVec3::new(-wi.x, -wi.y, wi.z),
                    weight: blend.core_share * self.table.material.reflectance(wi.z) / blend.core,
                    pdf: f64::INFINITY,
                    specular: true,
                });
            }
            if left < facts.core + facts.floor {
                return self.sample_floor(incident, u[0], (left - facts.core) / facts.floor);
            }
            left = at_least((left - facts.core - facts.floor) / (1.0 - facts.core - facts.floor), 0.0);
        }
        let (cell, across) = draw(node, u[0])?;
        let [x, y] = self.hats.place(cell, across, left as f32);
        let (p, q) = self.table.cells.slope_of([f64::from(x.x), f64::from(y.x)]);
        let below = (usize::from(cell[1]) + y.beyond - 1) * self.slabs.grid.row + usize::from(cell[0]) + x.beyond - 1;
        let found = self.slabs.between::<ISO>(place, below, [x.upper, y.upper]);
        self.reflect::<ISO, PLAIN>(incident, &blend, [p, q], found)
    }

    /// A draw of the floor, for two uniform numbers.
    fn sample_floor(&self, incident: &Incident, u: f64, v: f64) -> Option<BrdfSample> {
        let wo = incident.out_of_cells(by_the_cosine([u, v]));
        if wo.z <= HORIZON {
            return None;
        }
        let (f, pdf) = self.both(incident.wi, wo);
        Some(BrdfSample { wo, weight: f * wo.z / pdf, pdf, specular: false })
    }

    /// The draw of a slope in the frame of the cells.
    #[inline(always)]
    fn reflect<const ISO: bool, const PLAIN: bool>(
        &self,
        incident: &Incident,
        blend: &Blend,
        [p, q]: [f64; 2],
        found: Found,
    ) -> Option<BrdfSample> {
        let wi = incident.wi;
        let local = if ISO { DVec3::new(incident.place.sine, 0.0, wi.z) } else { wi };
        // lean = cos_beta / cos_theta_h.
        let lean = if ISO { wi.z - p * local.x } else { wi.z - p * local.x - q * local.y };
        let steepness = 1.0 + p * p + q * q;
        let scale = 2.0 * lean * (1.0 / steepness);
        let (x, y) = (-p * scale - local.x, -q * scale - local.y);
        let wo =
            if ISO { incident.out_of_cells(DVec3::new(x, y, scale - wi.z)) } else { DVec3::new(x, y, scale - wi.z) };
        if !(lean > 0.0 && wo.z > HORIZON) {
            return None;
        }
        // One division at the end of what waits for roots and lookups.
        let [above, below] = self.table.material.reflectance_of_ratio(at_most(lean * lean, steepness), steepness);
        let below = below * self.cosines(incident, wo.z);
        let density = incident.balance * f64::from(found.density) * lean * wo.z * above;
        let draws = f64::from(found.draws);
        if PLAIN {
            let pdf = 0.25 * draws * steepness * steepness / lean;
            return Some(BrdfSample { wo, weight: density / (below * draws), pdf, specular: false });
        }
        // dw / (dp dq) = 4 cos_beta cos^3 theta_h: rest and draws stay per slope, floor and cosine come to it.
        let per_slope = 4.0 * lean / (steepness * steepness);
        let reflected = density / below + blend.diffuse * wo.z * per_slope;
        let draws = draws + blend.floor * wo.z * (1.0 / PI) * per_slope;
        Some(BrdfSample { wo, weight: reflected / draws, pdf: draws / per_slope, specular: false })
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

    /// Of the interpolated table at azimuth 0; between the nodes the Fresnel reflectance does not run straight.
    fn albedo(&self, theta_i: f64) -> f64 {
        let steps = self.albedo.get_or_init(|| {
            let at = |k: usize| direction(ALBEDO_LAST * k as f64 / ALBEDO_STEPS as f64, 0.0);
            albedos(&self.table, &(0..=ALBEDO_STEPS).map(at).collect::<Vec<_>>())
        });
        let x = at_most(at_least(theta_i / ALBEDO_LAST, 0.0), 1.0) * ALBEDO_STEPS as f64;
        let k = (x as usize).min(ALBEDO_STEPS - 1);
        steps[k] + (x - k as f64) * (steps[k + 1] - steps[k])
    }

    fn specular_core(&self, wi: DVec3) -> f64 {
        self.table.core(wi)
    }
}

/// The direction drawn by the cosine for two uniform numbers (Malley: a point of the disc, lifted).
#[inline]
pub(super) fn by_the_cosine([u, v]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
    let r = u.sqrt();
    DVec3::new(r * cos, r * sin, (1.0 - u).sqrt())
}

/// The second of two with probability `share`, and what is left of `u`.
#[inline(always)]
fn choose(share: f64, u: f64) -> (usize, f64) {
    let from = 1.0 - share;
    let second = not_below(u, from);
    let one = f64::from_bits(second & 1f64.to_bits());
    let width = from + one * (share - from);
    ((second & 1) as usize, at_most(at_least((u - one * from) / width, 0.0), 1.0 - f64::EPSILON))
}
