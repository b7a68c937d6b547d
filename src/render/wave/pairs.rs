//! Questions to the BRDFs, by the run.

use super::spots::Spots;
use crate::math::frame::DVec3;

/// Pairs of directions that a BRDF is asked for, and its answers.
#[derive(Default)]
pub(super) struct Pairs {
    pub wi: Vec<DVec3>,
    pub wo: Vec<DVec3>,
    pub found: Vec<(DVec3, f64)>,
    grey: Vec<(f64, f64)>,
    pub spots: Vec<usize>,
}

impl Pairs {
    pub fn clear(&mut self) {
        self.wi.clear();
        self.wo.clear();
        self.spots.clear();
    }

    #[inline(always)]
    pub fn push(&mut self, spot: usize, wi: DVec3, wo: DVec3) {
        self.wi.push(wi);
        self.wo.push(wo);
        self.spots.push(spot);
    }

    /// Asks the reflectors of the spots, which are in order of materials, for `f_r` without tint and the density of their
    /// draws.
    #[inline(always)]
    pub fn evaluate(&mut self, spots: &Spots) {
        self.found.clear();
        self.found.resize(self.wi.len(), (DVec3::ZERO, 0.0));
        let mut from = 0;
        for run in self.spots.chunk_by(|&a, &b| spots.coat[a].group() == spots.coat[b].group()) {
            let range = from..from + run.len();
            let coat = spots.coat[run[0]];
            let (wi, wo) = (&self.wi[range.clone()], &self.wo[range.clone()]);
            coat.evaluate(wi, wo, &mut self.found[range.clone()], &mut self.grey);
            from = range.end;
        }
    }
}
