//! Aggregates of particles, by place.

use rayon::prelude::*;

use super::CHUNK;
use super::vector::Capacities;

/// Which places belong together.
#[derive(Debug, Default)]
pub(super) struct Aggregates {
    /// The aggregate of each place; none where it is not below their number.
    of: Vec<u32>,
    /// The places, aggregate by aggregate, each from its `start` on.
    places: Vec<u32>,
    start: Vec<u32>,
}

impl Aggregates {
    /// From the aggregate of each place, of `count`.
    pub(super) fn new(of: Vec<u32>, count: usize) -> Self {
        let mut start = vec![0; count + 1];
        let members = || (0..).zip(&of).filter(|(_, aggregate)| (**aggregate as usize) < count);
        members().for_each(|(_, &aggregate)| start[aggregate as usize + 1] += 1);
        for k in 0..count {
            start[k + 1] += start[k];
        }
        let mut next: Vec<u32> = start[..count].to_vec();
        let mut places = vec![0; start[count] as usize];
        for (place, &aggregate) in members() {
            let next = &mut next[aggregate as usize];
            places[*next as usize] = place;
            *next += 1;
        }
        Self { of, places, start }
    }

    /// `out` = the sum of V x over each, in an order that does not depend on the number of threads.
    pub(super) fn restrict(&self, x: &[f64], capacities: &Capacities, out: &mut [f64]) {
        out.par_iter_mut().enumerate().for_each(|(k, out)| {
            let places = &self.places[self.start[k] as usize..self.start[k + 1] as usize];
            *out = capacities.sum(x, places);
        });
    }

    /// Adds to `out` at each place the value of its aggregate.
    pub(super) fn prolong(&self, values: &[f64], out: &mut [f64]) {
        let parts = out.par_chunks_mut(CHUNK).zip(self.of.par_chunks(CHUNK));
        parts.for_each(|(out, of)| {
            for (out, &aggregate) in out.iter_mut().zip(of) {
                *out += values.get(aggregate as usize).unwrap_or(&0.0);
            }
        });
    }

    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.of) + size_of_val(&*self.places) + size_of_val(&*self.start)
    }
}
