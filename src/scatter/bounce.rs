//! The path of one beam from its first facet to its exit.

use crate::facets::visibility::{Fate, HeightField, Ray};
use crate::math::frame;
use crate::optics::Material;
use glam::DVec3;
use std::ops::ControlFlow;

/// A beam about to be reflected by a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Point on the facet: column, row in samples, height \[m\].
    pub point: [f64; 3],
    /// Cell and triangle of the facet.
    pub facet: ([usize; 2], bool),
    /// Slopes of the facet in the map's frame.
    pub slope: (f64, f64),
    /// Unit vector towards where the beam came from.
    pub back: DVec3,
    /// Signs by which mirrored tiles have flipped the frame so far.
    pub flip: [f64; 2],
}

/// Where a beam of unit energy ended: shares sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// Exit direction in the map's frame and the energy that took it.
    pub escaped: Option<(DVec3, f64)>,
    pub absorbed: f64,
    pub lost: f64,
    pub bounces: u32,
}

/// A beam of unit energy under way.
#[derive(Debug, Clone, Copy)]
pub struct Flight {
    pub arrival: Arrival,
    /// Where it goes from there.
    pub wo: DVec3,
    energy: f64,
    absorbed: f64,
    bounces: u32,
}

impl Flight {
    /// A beam at its first facet.
    #[inline]
    pub fn new(arrival: Arrival) -> Self {
        Flight { arrival, wo: arrival.back, energy: 1.0, absorbed: 0.0, bounces: 0 }
    }

    /// Reflects the beam, which keeps `R(beta)` of its energy; it ends if it has no bounce left.
    #[inline]
    pub fn reflect(&mut self, walk: &Walk) -> ControlFlow<Departure> {
        if self.bounces == walk.max_bounces {
            return ControlFlow::Break(self.end(None, self.energy));
        }
        self.bounces += 1;
        let n = frame::normal_of_slope(self.arrival.slope.0, self.arrival.slope.1);
        let reflectance = walk.material.reflectance(n.dot(self.arrival.back));
        self.absorbed += self.energy * (1.0 - reflectance);
        self.energy *= reflectance;
        self.wo = frame::reflect(self.arrival.back, n);
        ControlFlow::Continue(())
    }

    /// What follows from the fate of its way along `wo`: an end, or the next facet.
    #[inline]
    pub fn meet(&mut self, fate: &Fate) -> ControlFlow<Departure> {
        match fate {
            Fate::Escaped(_) if self.wo.z > 0.0 => {
                // In the unfolded map the beam goes straight on; the tiles it crosses no longer matter.
                let sign = DVec3::new(self.arrival.flip[0], self.arrival.flip[1], 1.0);
                ControlFlow::Break(self.end(Some((self.wo * sign, self.energy)), 0.0))
            }
            Fate::Hit(hit) => {
                let sign = DVec3::new(hit.flip[0], hit.flip[1], 1.0);
                self.arrival = Arrival {
                    point: [hit.column, hit.row, hit.z],
                    facet: (hit.cell, hit.upper),
                    slope: hit.slope,
                    back: -self.wo * sign,
                    flip: [self.arrival.flip[0] * hit.flip[0], self.arrival.flip[1] * hit.flip[1]],
                };
                ControlFlow::Continue(())
            }
            Fate::Escaped(_) | Fate::Lost => ControlFlow::Break(self.end(None, self.energy)),
        }
    }

    fn end(&self, escaped: Option<(DVec3, f64)>, lost: f64) -> Departure {
        Departure { escaped, absorbed: self.absorbed, lost, bounces: self.bounces }
    }
}

/// What the walk needs to know besides the beam.
pub struct Walk<'a> {
    pub field: &'a HeightField<'a>,
    pub material: Material,
    pub max_bounces: u32,
    /// Largest gradient of the map: a beam that climbs faster cannot meet the surface again.
    pub steepest: f64,
}

impl Walk<'_> {
    /// Whether a beam along `w` climbs faster than any facet of the map.
    #[inline]
    pub fn outclimbs(&self, w: DVec3) -> bool {
        w.z > 0.0 && w.z * w.z >= self.steepest * self.steepest * (w.x * w.x + w.y * w.y)
    }

    /// Whether a beam leaving a facet along `w` meets the surface again.
    #[inline]
    pub fn onward(&self, arrival: &Arrival, w: DVec3) -> Fate {
        if self.outclimbs(w) {
            return Fate::Escaped([1.0, 1.0]);
        }
        self.field.trace(arrival.onward(w), Some(arrival.facet))
    }

    /// Reflects the beam until it escapes, each bounce keeping `R(beta)` of its energy.
    pub fn follow(&self, arrival: Arrival) -> Departure {
        let mut flight = Flight::new(arrival);
        loop {
            if let ControlFlow::Break(end) = flight.reflect(self) {
                return end;
            }
            let fate = self.onward(&flight.arrival, flight.wo);
            if let ControlFlow::Break(end) = flight.meet(&fate) {
                return end;
            }
        }
    }
}

impl Arrival {
    /// The ray that leaves the facet along `w`.
    #[inline]
    pub fn onward(&self, w: DVec3) -> Ray {
        let [column, row, z] = self.point;
        Ray { column, row, z, direction: w }
    }
}
