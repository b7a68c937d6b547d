//! Integrals over the hemisphere that find a lobe of any width by looking where draws fall.

use crate::math::quadrature::gauss_legendre;
use glam::DVec3;

/// Leaf boxes for the chi-square test: `2^LEVELS` of about equal share of the draws.
const LEVELS: u32 = 8;
/// Splits below a leaf at most, and the share of a leaf to which its integral is found.
const DEEPEST: u32 = 40;
const SHARE: f64 = 1e-3;
/// Nodes of the rule along each side of a box.
const NODES: usize = 6;

/// The upper hemisphere as a disc of equal areas, `(x, y) sqrt(2 / (1 + z))` (Lambert 1772), cut at the medians of pilot draws.
pub(super) struct Tree {
    rule: Vec<(f64, f64)>,
    pilot: Vec<Draw>,
    root: Split,
}

enum Split {
    Leaf(usize),
    At { axis: usize, place: f64, below: Box<Split>, above: Box<Split> },
}

/// Place of a draw on the disc, and the first function there.
type Draw = [f64; 3];

/// Integrals of two functions.
type Pair = [f64; 2];

#[derive(Clone, Copy)]
struct Area {
    low: [f64; 2],
    high: [f64; 2],
}

impl Area {
    fn halves(&self, axis: usize, place: f64) -> [Area; 2] {
        let (mut below, mut above) = (*self, *self);
        below.high[axis] = place;
        above.low[axis] = place;
        [below, above]
    }
}

/// Radius of the disc.
const RADIUS: f64 = std::f64::consts::SQRT_2;
const ALL: Area = Area { low: [-RADIUS; 2], high: [RADIUS; 2] };

fn to_disc(w: DVec3) -> [f64; 2] {
    let scale = (2.0 / (1.0 + w.z)).sqrt();
    [w.x * scale, w.y * scale]
}

fn from_disc([x, y]: [f64; 2]) -> Option<DVec3> {
    // r^2 = 2 (1 - z).
    let z = 1.0 - (x * x + y * y) / 2.0;
    let scale = ((1.0 + z) / 2.0).max(0.0).sqrt();
    (z > 0.0).then(|| DVec3::new(x * scale, y * scale, z))
}

impl Tree {
    /// A tree that follows `pilot` directions.
    pub fn new(pilot: impl IntoIterator<Item = DVec3>) -> Tree {
        let place = |w| {
            let [x, y] = to_disc(w);
            [x, y, 0.0]
        };
        let mut pilot: Vec<Draw> = pilot.into_iter().map(place).collect();
        let mut leaves = 0;
        let root = grow(&mut pilot, ALL, LEVELS, &mut leaves);
        Tree { rule: gauss_legendre(NODES), pilot, root }
    }

    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        count(&self.root)
    }

    /// The leaf a direction falls into.
    pub fn leaf(&self, w: DVec3) -> usize {
        let at = to_disc(w);
        let mut split = &self.root;
        loop {
            match split {
                Split::Leaf(k) => return *k,
                Split::At { axis, place, below, above } => split = if at[*axis] < *place { below } else { above },
            }
        }
    }

    /// `integral of (f, g) dw` over every leaf. `f` is what the pilot was drawn from: where a draw sees more of it than the
    /// nodes do the box is split on, so that no narrow lobe slips through between them.
    pub fn integrals(&self, functions: &dyn Fn(DVec3) -> Pair) -> Vec<Pair> {
        let mut sums = Vec::new();
        let mut pilot = self.pilot.clone();
        for draw in &mut pilot {
            draw[2] = from_disc([draw[0], draw[1]]).map_or(0.0, |w| functions(w)[0]);
        }
        self.descend(&self.root, ALL, &mut pilot, functions, &mut sums);
        sums
    }

    fn descend(
        &self,
        split: &Split,
        area: Area,
        pilot: &mut [Draw],
        functions: &dyn Fn(DVec3) -> Pair,
        sums: &mut Vec<Pair>,
    ) {
        match split {
            Split::Leaf(_) => sums.push(self.refine(area, pilot, functions, self.rule_over(area, functions).0, 0)),
            Split::At { axis, place, below, above } => {
                let middle = partition(pilot, *axis, *place);
                let (left, right) = pilot.split_at_mut(middle);
                let [low, high] = area.halves(*axis, *place);
                self.descend(below, low, left, functions, sums);
                self.descend(above, high, right, functions, sums);
            }
        }
    }

    fn refine(
        &self,
        area: Area,
        pilot: &mut [Draw],
        functions: &dyn Fn(DVec3) -> Pair,
        whole: Pair,
        depth: u32,
    ) -> Pair {
        let (axis, place) = cut(pilot, area);
        let parts = area.halves(axis, place);
        let [(a, peak_a), (b, peak_b)] = parts.map(|part| self.rule_over(part, functions));
        let sum = [a[0] + b[0], a[1] + b[1]];
        // A leaf holds about 1 / leaves of either function.
        let unit = SHARE / f64::from(1u32 << LEVELS) / f64::from(1u32 << (depth / 2).min(20));
        let agrees = (0..2).all(|k| (sum[k] - whole[k]).abs() <= unit.max(0.2 * SHARE * sum[k].abs()));
        // Draws of a needle that lies between the nodes see more than the nodes do.
        let seen = pilot.iter().fold(0.0, |most: f64, draw| most.max(draw[2]));
        let plausible = seen <= 2.0 * peak_a.max(peak_b);
        if (agrees && plausible && depth > 0) || depth == DEEPEST {
            return sum;
        }
        let middle = partition(pilot, axis, place);
        let (left, right) = pilot.split_at_mut(middle);
        let [low, high] = parts;
        let a = self.refine(low, left, functions, a, depth + 1);
        let b = self.refine(high, right, functions, b, depth + 1);
        [a[0] + b[0], a[1] + b[1]]
    }

    /// The integrals, and the largest value of the first function at a node.
    fn rule_over(&self, area: Area, functions: &dyn Fn(DVec3) -> Pair) -> (Pair, f64) {
        let half = [0, 1].map(|k| 0.5 * (area.high[k] - area.low[k]));
        let centre = [0, 1].map(|k| 0.5 * (area.high[k] + area.low[k]));
        let (mut sum, mut peak) = ([0.0; 2], 0.0f64);
        for &(x, wx) in &self.rule {
            for &(y, wy) in &self.rule {
                if let Some(w) = from_disc([centre[0] + x * half[0], centre[1] + y * half[1]]) {
                    let value = functions(w);
                    sum[0] += wx * wy * value[0];
                    sum[1] += wx * wy * value[1];
                    peak = peak.max(value[0]);
                }
            }
        }
        (sum.map(|s| s * half[0] * half[1]), peak)
    }
}

/// Where to cut a box: across its longer side, halfway between its middle and the median of the draws in it.
fn cut(pilot: &mut [Draw], area: Area) -> (usize, f64) {
    let side = [0, 1].map(|k| area.high[k] - area.low[k]);
    let axis = usize::from(side[1] > side[0]);
    let middle = 0.5 * (area.low[axis] + area.high[axis]);
    if pilot.len() < 8 {
        return (axis, middle);
    }
    let half = pilot.len() / 2;
    let (_, median, _) = pilot.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
    // Never a sliver: the cut stays off the ends.
    let place = 0.5 * (middle + median[axis]);
    (axis, place.clamp(area.low[axis] + 0.02 * side[axis], area.high[axis] - 0.02 * side[axis]))
}

fn grow(pilot: &mut [Draw], area: Area, levels: u32, leaves: &mut usize) -> Split {
    if levels == 0 || pilot.len() < 32 {
        *leaves += 1;
        return Split::Leaf(*leaves - 1);
    }
    // The longer side of where the draws are, not of the box: a lobe may be a ridge.
    let extent = [0, 1].map(|k| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for x in pilot.iter() {
            (low, high) = (low.min(x[k]), high.max(x[k]));
        }
        high - low
    });
    let axis = usize::from(extent[1] > extent[0]);
    let half = pilot.len() / 2;
    let (_, median, _) = pilot.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
    let place = median[axis];
    let middle = partition(pilot, axis, place);
    let (left, right) = pilot.split_at_mut(middle);
    let [low, high] = area.halves(axis, place);
    let below = grow(left, low, levels - 1, leaves);
    let above = grow(right, high, levels - 1, leaves);
    Split::At { axis, place, below: Box::new(below), above: Box::new(above) }
}

fn count(split: &Split) -> usize {
    match split {
        Split::Leaf(_) => 1,
        Split::At { below, above, .. } => count(below) + count(above),
    }
}

/// Moves what lies below `place` to the front and says how much that is.
fn partition(pilot: &mut [Draw], axis: usize, place: f64) -> usize {
    let mut middle = 0;
    for k in 0..pilot.len() {
        if pilot[k][axis] < place {
            pilot.swap(k, middle);
            middle += 1;
        }
    }
    middle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::CounterRng;
    use std::f64::consts::PI;

    /// A needle of 0.05 deg in the plain of a cosine: both masses are found.
    #[test]
    fn a_needle_is_found() {
        let centre = crate::math::direction(1.0, 2.0);
        let (t, b) = crate::math::frame::tangents(centre);
        let s = 1e-3;
        let mut rng = CounterRng::new(1, 0, 0);
        let draws: Vec<DVec3> = (0..60_000)
            .map(|k| {
                if k % 2 == 0 {
                    let [x, y] = rng.normal_pair();
                    (centre + s * (x * t + y * b)).normalize()
                } else {
                    let (u, phi) = (rng.uniform(), std::f64::consts::TAU * rng.uniform());
                    DVec3::new(u.sqrt() * phi.cos(), u.sqrt() * phi.sin(), (1.0 - u).sqrt())
                }
            })
            .collect();
        let tree = Tree::new(draws);
        let pdf = |w: DVec3| {
            let (x, y, z) = (w.dot(t), w.dot(b), w.dot(centre));
            let needle = if z > 0.0 {
                (-(x * x + y * y) / (2.0 * s * s * z * z)).exp() / (2.0 * PI * s * s * z * z * z)
            } else {
                0.0
            };
            0.5 * needle + 0.5 * w.z / PI
        };
        let masses = tree.integrals(&|w| [pdf(w), 1.0]);
        assert_eq!(masses.len(), tree.leaves());
        let sum = masses.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        assert!((sum[0] - 1.0).abs() < 1e-3, "{sum:?}");
        assert!((sum[1] / (2.0 * PI) - 1.0).abs() < 1e-3, "{sum:?}");
        assert!(masses.iter().all(|m| m[0] > 0.5 / tree.leaves() as f64 && m[0] < 2.0 / tree.leaves() as f64));
    }
}
