//! How to spend points on a surface: half vectors drawn by the surface itself, or by a grid that learnt the integrand.
//!
//! Draws of the surface follow a lobe of any width and its tails, but waste most points when the lobe is wider than
//! the receptor; the grid is the other way round. Every point is spent on both and the two are joined by the power
//! heuristic (Veach 1997, section 9.2.4), leaning to one side; which side scatters less is measured, not guessed.
//! Neither can be biased by the other: the weights sum to 1 wherever there is light.

use super::grid::Grid;
use super::path::Path;
use crate::math::half_vector;
use crate::math::reflect;
use crate::optics::Brdf;
use sobol_burley::sample_4d;

/// How many times the grid's density is counted in the heuristic: towards the surface, towards the grid. Leaning
/// fully to one side would lose what that side cannot draw.
pub const LEANINGS: [f64; 2] = [0.005, 5.0];

/// Share of the surface's draws that must reach the receptor's neighbourhood before leaning to the surface is an option:
/// with fewer, the few that count may be missing from the sums by which the leanings are compared.
const ENOUGH: f64 = 0.02;

/// The integrand at one half vector, and how densely each strategy puts points there.
#[derive(Debug, Clone, Copy)]
struct Spot {
    position: [f64; 2],
    value: f64,
    by_surface: f64,
    by_grid: f64,
    /// Which of the two drew it.
    from_grid: bool,
}

impl Spot {
    /// Integrand over density times weight: `f p_own c_own^2 / ((p_s)^2 + (c p_g)^2)`.
    fn power(&self, leaning: f64) -> f64 {
        let (s, g) = (self.by_surface, leaning * self.by_grid);
        let own = if self.from_grid { g * leaning } else { s };
        self.value * own / (s * s + g * g)
    }

    /// The same by the balance heuristic, which never magnifies: for training.
    fn balance(&self) -> f64 {
        self.value / (self.by_surface + self.by_grid)
    }
}

/// A trained grid for one path and one surface.
#[derive(Debug, Clone)]
pub struct Plan {
    grid: Grid,
    /// Whether the surface's own draws are frequent enough to lean on.
    surface_serves: bool,
}

impl Plan {
    /// Learns where `brdf` sends light through `path`: `training` draws place the knots of the grid, as many points set
    /// its density. Every `seed` gives an independent plan.
    pub fn new(path: &Path, brdf: &dyn Brdf, training: u32, seed: u32) -> Self {
        let draws: Vec<[f64; 2]> = (0..training)
            .filter_map(|k| {
                let [a, b, ..] = sample_4d(k, 1, seed).map(f64::from);
                let draw = brdf.sample(path.centre(), [a, b]).filter(|s| !s.specular)?;
                path.position(half_vector(path.centre(), draw.wo))
            })
            .collect();
        let surface_serves = draws.len() as f64 >= ENOUGH * f64::from(training);
        let mut plan = Plan { grid: Grid::new(path.bounds(), &draws), surface_serves };
        let mut learnt = plan.grid.clone();
        for k in 0..training {
            for spot in plan.spots(path, brdf, sample_4d(k, 2, seed).map(f64::from)).into_iter().flatten() {
                learnt.learn(spot.position, spot.balance());
            }
        }
        learnt.adapt();
        plan.grid = learnt;
        plan
    }

    /// Whether the first of [`LEANINGS`] may be chosen.
    pub fn surface_serves(&self) -> bool {
        self.surface_serves
    }

    /// One unbiased estimate of the flux without the specular core [sr^2] for `u` in `[0, 1)^4`, once per leaning.
    pub fn estimate<const N: usize>(&self, path: &Path, brdf: &dyn Brdf, u: [f64; 4], leanings: [f64; N]) -> [f64; N] {
        let spots = self.spots(path, brdf, u);
        leanings.map(|leaning| spots.iter().flatten().map(|spot| spot.power(leaning)).sum())
    }

    /// One draw of each strategy; `None` where there is no light.
    fn spots(&self, path: &Path, brdf: &dyn Brdf, u: [f64; 4]) -> [Option<Spot>; 2] {
        let (for_half_vector, for_source) = ([u[0], u[1]], [u[2], u[3]]);
        let by_surface = || {
            let draw = brdf.sample(path.centre(), for_half_vector).filter(|s| !s.specular)?;
            let wh = half_vector(path.centre(), draw.wo);
            let position = path.position(wh)?;
            let value = path.integrand(brdf, wh, for_source);
            let (by_surface, by_grid) = (draw.pdf * path.jacobian(wh), self.grid.density(position));
            (value != 0.0).then_some(Spot { position, value, by_surface, by_grid, from_grid: false })
        };
        let by_grid = || {
            let (position, by_grid) = self.grid.point(for_half_vector);
            let wh = path.half_vector(position);
            let value = path.integrand(brdf, wh, for_source);
            let by_surface = || brdf.pdf(path.centre(), reflect(path.centre(), wh)) * path.jacobian(wh);
            (value != 0.0).then(|| Spot { position, value, by_surface: by_surface(), by_grid, from_grid: true })
        };
        [by_surface(), by_grid()]
    }
}
