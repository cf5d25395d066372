//! The weight of a pair.

use crate::model::{Kernel, Problem, lattice};

/// What the kernel sum is divided by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Correction {
    /// Nothing: the plain operator, whose effective diffusivity differs from D by a factor that
    /// depends on kernel and support ratio and does not vanish under refinement.
    None,
    /// The discrete second moment of the infinite lattice: one constant for every particle, so
    /// that the weights stay symmetric beside edges and held bodies.
    Moment,
}

impl Correction {
    /// Every correction.
    pub const ALL: [Self; 2] = [Self::None, Self::Moment];

    /// The name in case files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Moment => "moment",
        }
    }

    /// The divisor: 1, or Deff / D of the infinite lattice.
    pub fn moment(self, kernel: &Kernel, spacing: f64) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Moment => lattice::effective_diffusivity_ratio(kernel, spacing),
        }
    }
}

/// Computes the weights w_ab of a scene, 1/s.
pub struct PairWeight<'a> {
    problem: &'a Problem,
    inverse_moment: f64,
}

impl<'a> PairWeight<'a> {
    /// The weights of `problem`.
    pub fn new(problem: &'a Problem) -> Self {
        let moment = problem.correction.moment(&problem.kernel, problem.spacing);
        Self {
            problem,
            inverse_moment: 1.0 / moment,
        }
    }

    /// w_ab of particles `a` and `b` at distance `dist` (m), 1/s, never negative.
    pub fn of(&self, a: usize, b: usize, dist: f64) -> f64 {
        let particles = &self.problem.particles;
        let diffusivity =
            |i: usize| self.problem.materials[usize::from(particles.material[i])].diffusivity;
        let mean = self.problem.pair_mean.of(diffusivity(a), diffusivity(b));
        particles.volume[b] * mean * -self.problem.kernel.dw_over_r(dist) * self.inverse_moment
    }
}
