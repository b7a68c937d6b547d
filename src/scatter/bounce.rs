//! The path of one beam from its first facet to its exit.

use crate::facets::visibility::{Fate, HeightField, Ray};
use crate::math::frame;
use crate::optics::Material;
use glam::DVec3;

/// A beam about to be reflected by a facet.
#[derive(Debug, Clone, Copy)]
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
#[derive(Debug, Clone, Copy)]
pub struct Departure {
    /// Exit direction in the map's frame and the energy that took it.
    pub escaped: Option<(DVec3, f64)>,
    pub absorbed: f64,
    pub lost: f64,
    pub bounces: u32,
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
    /// Whether a beam leaving a facet along `w` meets the surface again.
    #[inline]
    pub fn onward(&self, arrival: &Arrival, w: DVec3) -> Fate {
        if w.z > 0.0 && w.z * w.z >= self.steepest * self.steepest * (w.x * w.x + w.y * w.y) {
            return Fate::Escaped([1.0, 1.0]);
        }
        let [column, row, z] = arrival.point;
        self.field.trace(Ray { column, row, z, direction: w }, Some(arrival.facet))
    }

    /// Reflects the beam until it escapes, each bounce keeping `R(beta)` of its energy.
    #[inline]
    pub fn follow(&self, arrival: Arrival) -> Departure {
        self.follow_on(arrival, None)
    }

    /// As [`Walk::follow`] when the fate of the first reflection is known.
    pub fn follow_on(&self, mut arrival: Arrival, mut first: Option<Fate>) -> Departure {
        let (mut energy, mut absorbed) = (1.0, 0.0);
        for bounce in 1..=self.max_bounces {
            let n = frame::normal_of_slope(arrival.slope.0, arrival.slope.1);
            let reflectance = self.material.reflectance(n.dot(arrival.back));
            absorbed += energy * (1.0 - reflectance);
            energy *= reflectance;
            let wo = frame::reflect(arrival.back, n);
            match first.take().unwrap_or_else(|| self.onward(&arrival, wo)) {
                Fate::Escaped(_) if wo.z > 0.0 => {
                    // In the unfolded map the beam goes straight on; the tiles it crosses no longer matter.
                    let sign = DVec3::new(arrival.flip[0], arrival.flip[1], 1.0);
                    return Departure { escaped: Some((wo * sign, energy)), absorbed, lost: 0.0, bounces: bounce };
                }
                Fate::Hit(hit) => {
                    let sign = DVec3::new(hit.flip[0], hit.flip[1], 1.0);
                    arrival = Arrival {
                        point: [hit.column, hit.row, hit.z],
                        facet: (hit.cell, hit.upper),
                        slope: hit.slope,
                        back: -wo * sign,
                        flip: [arrival.flip[0] * hit.flip[0], arrival.flip[1] * hit.flip[1]],
                    };
                }
                Fate::Escaped(_) | Fate::Lost => {
                    return Departure { escaped: None, absorbed, lost: energy, bounces: bounce };
                }
            }
        }
        Departure { escaped: None, absorbed, lost: energy, bounces: self.max_bounces }
    }
}
