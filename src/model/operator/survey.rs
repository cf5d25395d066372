//! What one walk over all pairs tells about a scene.

use super::fold::{Fault, RowFold};
use crate::model::Problem;
use crate::model::neighbors::Neighbor;

/// Negative weights of this part of a row's diagonal and less count as none.
const ROUNDING: f64 = 1e-12;

/// What one walk over all pairs tells about a scene, without storing the pairs.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Neighbours over all particles: twice the number of pairs.
    pub entries: u64,
    /// The most neighbours that a particle has.
    pub most_neighbors: usize,
    /// What bounds the step of explicit Euler, 1/s: the largest |A_aa| over particles that are not
    /// held. Where weights of a row are negative, their magnitudes are added, which makes it a
    /// bound of sum_b |A_ab| / 2. 0 if none has a neighbour.
    pub rate_bound: f64,
    /// Whether the matrix is symmetric once scaled by volume: all but convection is.
    pub symmetric: bool,
    /// What is wrong with a wall or surface, if anything is.
    pub fault: Option<Fault>,
    /// Smallest summation density (18), kg/m^dim.
    pub min_density: f64,
    /// Largest summation density (18), kg/m^dim.
    pub max_density: f64,
    /// Two particles (a, b) at one place, if there are any.
    pub coincident: Option<(usize, usize)>,
}

impl Default for Survey {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Survey {
    /// That of no particle.
    pub(in crate::model) const EMPTY: Self = Self {
        entries: 0,
        most_neighbors: 0,
        rate_bound: 0.0,
        symmetric: true,
        fault: None,
        min_density: f64::INFINITY,
        max_density: f64::NEG_INFINITY,
        coincident: None,
    };

    pub(super) fn merge(self, other: Self) -> Self {
        Self {
            entries: self.entries + other.entries,
            most_neighbors: self.most_neighbors.max(other.most_neighbors),
            rate_bound: self.rate_bound.max(other.rate_bound),
            symmetric: self.symmetric && other.symmetric,
            fault: self.fault.or(other.fault),
            min_density: self.min_density.min(other.min_density),
            max_density: self.max_density.max(other.max_density),
            coincident: self.coincident.or(other.coincident),
        }
    }

    /// With what sources in proportion to the value add to the bound: the most that they do anywhere.
    pub(in crate::model) fn with_sources(mut self, problem: &Problem) -> Self {
        self.rate_bound += problem.linear_sources().damping;
        self
    }

    pub(super) fn note_neighbors(&mut self, order: &[u32], a: usize, neighbors: &[Neighbor]) {
        self.entries += neighbors.len() as u64;
        self.most_neighbors = self.most_neighbors.max(neighbors.len());
        if let Some(same) = neighbors.iter().find(|n| n.dist == 0.0) {
            self.coincident = Some((a, order[same.rank as usize] as usize));
        }
    }

    /// Takes a row whose diagonal is -`diagonal` and whose negative weights add up to -`negative`.
    pub(in crate::model) fn note_diagonal(&mut self, diagonal: f64, negative: f64) {
        // Mirrors subtract nearly equal weights; what rounding leaves of them is no sign.
        let bound = if negative <= ROUNDING * diagonal { diagonal } else { diagonal + negative };
        self.rate_bound = self.rate_bound.max(bound);
    }

    pub(super) fn note_fold(&mut self, fold: &RowFold) {
        self.symmetric &= fold.skew == 0.0;
        self.fault = self.fault.or(fold.fault);
    }

    /// Takes a density, kg/m^dim.
    pub(in crate::model) fn note_density(&mut self, density: f64) {
        self.min_density = self.min_density.min(density);
        self.max_density = self.max_density.max(density);
    }
}
