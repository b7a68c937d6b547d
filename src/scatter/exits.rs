//! Beams that left after several bounces, and the detectors that they reach.

use super::cells::CellLanes;
use super::detectors::Detectors;
use crate::facets::starts::make_room;
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;

/// Beams in columns.
pub struct Exits {
    level: Level,
    n: usize,
    /// Direction in the frame of the map, and the direction to the source in that of the detectors.
    wo: [Vec<f32>; 3],
    local: [Vec<f32>; 3],
    /// Cosine and sine of the turn from one into the other.
    turn: [Vec<f32>; 2],
    beams: Vec<Beam>,
    slot: Vec<u32>,
}

/// How often a beam bounced, what it weighs and what is left of it.
#[derive(Debug, Clone, Copy)]
pub struct Beam {
    pub bounces: u32,
    pub weight: u32,
    pub energy: f32,
}

impl Default for Exits {
    fn default() -> Self {
        let none = Vec::new;
        let three = || [none(), none(), none()];
        let (wo, local, turn) = (three(), three(), [none(), none()]);
        Exits { level: Level::new(), n: 0, wo, local, turn, beams: Vec::new(), slot: Vec::new() }
    }
}

impl Exits {
    /// Adds a beam that leaves along `wo`; `local` is the direction to its source in the frame of the detectors, `turn` the turn into
    /// that.
    #[inline]
    pub fn push(&mut self, beam: Beam, wo: [f32; 3], local: DVec3, turn: [f32; 2]) {
        let k = self.n;
        if self.slot.len() <= k {
            let Exits { wo, local, turn, slot, .. } = self;
            wo.iter_mut().chain(local).chain(turn).for_each(|column| make_room(column, k + 1));
            make_room(slot, k + 1);
        }
        self.n += 1;
        let local = local.to_array();
        for axis in 0..3 {
            (self.wo[axis][k], self.local[axis][k]) = (wo[axis], local[axis] as f32);
        }
        for axis in 0..2 {
            self.turn[axis][k] = turn[axis];
        }
        self.beams.push(beam);
    }

    /// Tells of each beam which detector it reaches, and forgets it. `cells` are those of half-vector `detectors`.
    pub fn leave<D: Detectors + ?Sized>(
        &mut self,
        detectors: &D,
        cells: Option<&CellLanes>,
        mut reached: impl FnMut(Beam, u32),
    ) {
        let n = self.n;
        if let Some(cells) = cells {
            dispatch!(self.level, simd => locate(simd, self, cells));
        } else {
            for k in 0..n {
                let [x, y, z] = self.wo.each_ref().map(|wo| wo[k]);
                let [cos, sin] = self.turn.each_ref().map(|x| x[k]);
                let wo = [cos * x + sin * y, cos * y - sin * x, z].map(f64::from);
                let local = self.local.each_ref().map(|x| f64::from(x[k]));
                let index = detectors.index(DVec3::from_array(local), DVec3::from_array(wo).normalize());
                self.slot[k] = index as u32;
            }
        }
        self.beams.drain(..).zip(&self.slot).for_each(|(beam, &slot)| reached(beam, slot));
        self.n = 0;
    }
}

/// Cells of the half vectors' slopes.
#[simd]
fn locate<S: Simd>(_: S, exits: &mut Exits, cells: &CellLanes) {
    let n = exits.n;
    let [x, y, z] = exits.wo.each_ref().map(|x| &x[..n]);
    let [lx, ly, lz] = exits.local.each_ref().map(|x| &x[..n]);
    let [cos, sin] = exits.turn.each_ref().map(|x| &x[..n]);
    let slot = &mut exits.slot[..n];
    for k in 0..n {
        let (wx, wy) = (cos[k] * x[k] + sin[k] * y[k], cos[k] * y[k] - sin[k] * x[k]);
        let (hx, hy, hz) = (wx + lx[k], wy + ly[k], z[k] + lz[k]);
        slot[k] = cells.locate(-hx / hz, -hy / hz);
    }
}
