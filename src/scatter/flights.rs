//! Many beams at a time from their first facets to their exits.

use super::bounce::{Arrival, Departure, Flight, Walk};
use crate::facets::Packet;
use crate::facets::visibility::Fate;
use std::ops::ControlFlow;

/// Beams under way, bounce after bounce side by side: each ends as [`Walk::follow`] says.
pub struct Flights<'w> {
    walk: &'w Walk<'w>,
    packet: Packet,
    /// Beams at a facet, each with a number.
    arrived: Vec<(u32, Flight)>,
    leaving: Vec<(u32, Flight)>,
}

impl<'w> Flights<'w> {
    /// None yet.
    pub fn new(walk: &'w Walk<'w>) -> Self {
        Flights { walk, packet: Packet::default(), arrived: Vec::new(), leaving: Vec::new() }
    }

    /// Adds beam `number` at its first facet.
    #[inline]
    pub fn start(&mut self, number: u32, arrival: Arrival) {
        self.arrived.push((number, Flight::new(arrival)));
    }

    /// Follows all beams to their ends.
    pub fn land(&mut self, ended: &mut impl FnMut(u32, Departure)) {
        let field = self.walk.field;
        while !self.arrived.is_empty() {
            for (number, mut flight) in self.arrived.drain(..) {
                if let ControlFlow::Break(end) = flight.reflect(self.walk) {
                    ended(number, end);
                } else if self.walk.outclimbs(flight.wo) {
                    if let ControlFlow::Break(end) = flight.meet(&Fate::Escaped([1.0; 2])) {
                        ended(number, end);
                    }
                } else {
                    self.packet.push(field, flight.arrival.onward(flight.wo), Some(flight.arrival.facet));
                    self.leaving.push((number, flight));
                }
            }
            for ((number, mut flight), fate) in self.leaving.drain(..).zip(self.packet.trace(field)) {
                match flight.meet(fate) {
                    ControlFlow::Break(end) => ended(number, end),
                    ControlFlow::Continue(()) => self.arrived.push((number, flight)),
                }
            }
        }
    }
}
