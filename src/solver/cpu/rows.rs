//! Assembled rows as an operator.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::entries::{Entries, Near};
use super::operator::{Combine, CpuOperator, Now};
use crate::model::Problem;
use crate::model::operator::SourceRows;
use crate::model::operator::rows::Rows;

/// The rows of all particles; places are ranks in cell order.
pub(super) struct StoredRows {
    /// Particle index at each rank.
    order: Vec<u32>,
    rows: Rows,
    /// Capacities of the held particles, by rank.
    held_capacity: Vec<f64>,
    /// See [`CpuOperator::reach`].
    reach: OnceLock<usize>,
}

impl StoredRows {
    pub(super) fn new(problem: &Problem, order: Vec<u32>, rows: Rows) -> Self {
        let capacity = |&rank: &u32| problem.capacity(order[rank as usize] as usize);
        let held_capacity = rows.held_rank().iter().map(capacity).collect();
        Self { held_capacity, order, rows, reach: OnceLock::new() }
    }
}

impl CpuOperator for StoredRows {
    fn by_place(&self, values: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&particle| values[particle as usize]).collect()
    }

    fn by_particle(&self, values: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.order.len()];
        for (&particle, value) in self.order.iter().zip(values) {
            out[particle as usize] = *value;
        }
        out
    }

    fn held(&self) -> &[u32] {
        self.rows.held_rank()
    }

    fn sources(&self) -> &SourceRows {
        self.rows.sources()
    }

    fn entries(&self, place: usize, _near: &mut Near) -> Entries<'_> {
        let (others, weights) = self.rows.entries(place);
        Entries::Row(others, weights)
    }

    fn reach(&self) -> usize {
        *self.reach.get_or_init(|| {
            let of_row = |rank: usize| {
                let (others, _) = self.rows.entries(rank);
                others.iter().map(|&other| (other as usize).abs_diff(rank)).max().unwrap_or(0)
            };
            (0..self.order.len()).into_par_iter().map(of_row).max().unwrap_or(0)
        })
    }

    fn apply(&self, now: &Now<'_>, out: &mut [f64], combine: Combine) -> f64 {
        let source = now.source.unwrap_or(&[]);
        self.rows.apply(now.values, source, out, |own, rate| combine.of(own, rate));
        // What holding the values takes: the negative of what the held rows would gain.
        let gains = self.rows.held_rates(now.values).zip(&self.held_capacity);
        -gains.map(|(rate, capacity)| capacity * rate).sum::<f64>()
    }

    fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = self.rows.diagonal();
        for &rank in self.rows.held_rank() {
            diagonal[rank as usize] = -1.0;
        }
        diagonal
    }

    fn memory_bytes(&self) -> u64 {
        let own = size_of_val(&*self.order) + size_of_val(&*self.held_capacity);
        self.rows.memory_bytes() + own as u64
    }
}
