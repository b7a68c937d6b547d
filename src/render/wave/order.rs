//! Rays in order of what they meet.

use super::super::rays::{Column, WAVE};
use std::ops::Range;

/// A list of rays by the numbers of their surfaces, so that what depends on the surface is asked once for all of its rays.
pub(super) struct Order {
    pub list: Column<u32>,
    /// Where the rays of each surface end in it.
    ends: Vec<usize>,
}

impl Default for Order {
    fn default() -> Self {
        Order { list: [0; WAVE], ends: Vec::new() }
    }
}

impl Order {
    /// Sorts the rays with these surfaces, of which there are `count`; those of one surface stay in order.
    #[inline(always)]
    pub fn sort(&mut self, surfaces: &[u32], count: usize) {
        self.ends.clear();
        self.ends.resize(count, 0);
        for &surface in surfaces {
            self.ends[surface as usize] += 1;
        }
        let mut start = 0;
        for end in &mut self.ends {
            start += std::mem::replace(end, start);
        }
        for (ray, &surface) in surfaces.iter().enumerate() {
            let end = &mut self.ends[surface as usize];
            self.list[*end] = ray as u32;
            *end += 1;
        }
    }

    /// Where the rays of a surface are in the list.
    #[inline(always)]
    pub fn run(&self, surface: usize) -> Range<usize> {
        let start = if surface > 0 { self.ends[surface - 1] } else { 0 };
        start..self.ends[surface]
    }
}
