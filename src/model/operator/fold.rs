//! The fold: what ghosts behind walls, surfaces and sources add to a row of the matrix.
//!
//! A row gets more weight for some neighbours, a factor of its own value, and a source: see
//! [`RowFold`]. Ghosts behind faces are in `mirrors`, surfaces that are no faces in `surfaces`.
//!
//! Convection is the one kind that leaves the matrix unsymmetric where a support reaches past the
//! first layer: what its ghost makes of a value depends on the distance of that particle alone.

mod mirrors;
mod surfaces;

use glam::DVec3;

use super::PairWeight;
use crate::model::neighbors::Neighbor;
use crate::model::wall::{Condition, WalledFace};
use crate::model::{Problem, ScalarField};

use mirrors::Mirrors;
use surfaces::Surfaces;

/// A part of a row's source that changes in time: `coefficient` x what is imposed at `foot`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Which wall, surface or source imposes it: an index into [`Problem::imposed`].
    pub imposed: usize,
    /// Where (m); 0 if it is the same everywhere.
    pub foot: DVec3,
    /// Factor, 1/s.
    pub coefficient: f64,
}

/// What walls, surfaces and sources add to a row.
#[derive(Clone, Debug, Default)]
pub struct RowFold {
    /// What each neighbour's weight gets, 1/s, in the order of the neighbours.
    pub weight: Vec<f64>,
    /// Factor of the row's own value by walls and surfaces, 1/s.
    pub diagonal: f64,
    /// Factor of the row's own value by sources, 1/s.
    pub linear: f64,
    /// Twice the antisymmetric part of the weights, 1/s: -sum_b w_ab (s_ab - s_ba).
    pub skew: f64,
    /// The part of the source that does not change, 1/s x the value's unit.
    pub source: f64,
    /// The part of the source that does.
    pub changing: Vec<Term>,
    /// Whether anything but insulation acts here.
    pub acts: bool,
    /// What is wrong with a wall or surface here, if anything is.
    pub fault: Option<Fault>,
}

/// What is wrong with a wall or surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// A wall or surface imposes a value that is not finite.
    NotFinite {
        /// Which: an index into [`Problem::imposed`].
        imposed: usize,
        /// Where, m.
        at: DVec3,
    },
    /// Particles lie within a support on both sides of a surface: it is no surface of the body.
    Inside {
        /// Which: an index into [`Problem::imposed`].
        imposed: usize,
        /// Where, m.
        at: DVec3,
    },
}

impl RowFold {
    fn clear(&mut self, neighbors: usize) {
        self.weight.clear();
        self.weight.resize(neighbors, 0.0);
        self.changing.clear();
        (self.diagonal, self.linear, self.skew, self.source) = (0.0, 0.0, 0.0, 0.0);
        (self.acts, self.fault) = (false, None);
    }

    /// Adds `coefficient` x what `condition` imposes at `foot`.
    fn add_source(&mut self, condition: &Condition, imposed: usize, foot: DVec3, coefficient: f64) {
        self.add_field(&condition.imposed, imposed, foot, coefficient);
    }

    /// Adds `coefficient` x `field` at `foot`: at once, or as a term where it changes.
    fn add_field(&mut self, field: &ScalarField, imposed: usize, foot: DVec3, coefficient: f64) {
        let value = field.at(foot, 0.0);
        if !value.is_finite() {
            self.fault = Some(Fault::NotFinite { imposed, at: foot });
        }
        if field.depends_on_time() {
            let foot = if field.depends_on_position() { foot } else { DVec3::ZERO };
            self.changing.push(Term { imposed, foot, coefficient });
        } else {
            self.source += coefficient * value;
        }
    }
}

/// Folds the walls, surfaces and sources of a scene into rows.
pub struct Fold<'a> {
    problem: &'a Problem,
    mirrors: Mirrors<'a>,
    surfaces: Surfaces<'a>,
}

impl<'a> Fold<'a> {
    /// The fold of `problem`, whose pairs have the weights `weight`; `None` if it has no wall but
    /// free ones, no surface and no source.
    pub fn new(problem: &'a Problem, weight: &'a PairWeight<'a>) -> Option<Self> {
        let faces = WalledFace::all(&problem.walls, problem.dimension);
        let acts = !(faces.is_empty() && problem.surfaces.is_empty() && problem.sources.is_empty());
        acts.then(|| Self {
            problem,
            mirrors: Mirrors::new(problem, weight, faces),
            surfaces: Surfaces::new(problem, weight),
        })
    }

    /// Whether a ghost or a surface may be within the support of particle `a`, or a source acts on it.
    pub fn reaches(&self, a: usize) -> bool {
        let x = self.problem.particles.position[a];
        self.mirrors.reach(x) || self.surfaces.reach(x) || self.is_fed(a)
    }

    fn is_fed(&self, a: usize) -> bool {
        self.problem.sources.iter().any(|source| source.acts_on(a))
    }

    /// Writes what row `a` gets into `row`. `neighbors` are all particles within its support, as
    /// ranks of `order`. Nothing is written and `false` returned where nothing reaches.
    pub fn of_row(
        &self,
        a: usize,
        neighbors: &[Neighbor],
        order: &[u32],
        row: &mut RowFold,
    ) -> bool {
        let x = self.problem.particles.position[a];
        let (by_mirrors, by_surfaces) = (self.mirrors.reach(x), self.surfaces.reach(x));
        let is_fed = self.is_fed(a);
        if by_mirrors || by_surfaces || is_fed {
            row.clear(neighbors.len());
        }
        if by_mirrors {
            self.mirrors.fold(a, neighbors, order, row);
        }
        if by_surfaces {
            self.surfaces.fold(a, neighbors, order, &self.mirrors, row);
        }
        if is_fed {
            self.feed(a, row);
        }
        by_mirrors || by_surfaces || is_fed
    }

    /// Adds the sources of particle `a` to its row.
    fn feed(&self, a: usize, row: &mut RowFold) {
        let Problem { walls, surfaces, sources, .. } = self.problem;
        let x = self.problem.particles.position[a];
        let first = walls.len() + surfaces.len();
        for (k, source) in sources.iter().enumerate().filter(|(_, source)| source.acts_on(a)) {
            row.acts = true;
            row.linear += source.linear.at(x, 0.0);
            row.add_field(&source.rate, first + k, x, 1.0);
        }
    }
}

#[cfg(test)]
#[path = "fold_tests.rs"]
mod tests;
