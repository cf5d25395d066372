//! The weight of a pair.

use super::interfaces::Interfaces;
use crate::model::{Kernel, Particles, Problem, lattice};

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
    particles: &'a Particles,
    /// w'(q) / q of the kernel.
    shape: fn(f64) -> f64,
    inverse_radius: f64,
    /// kbar sigma / H^(dim + 2) / moment / rho_a c_a of each pair of materials, row by row: computed
    /// once, so that no pair divides.
    factor: Vec<f64>,
    /// Conductivity of each pair of materials as the operator conducts it.
    conductivity: Vec<f64>,
    materials: usize,
    /// Deff / D of the plain operator on the lattice.
    lattice_ratio: f64,
    /// Where materials meet, if that is known and not half way.
    interfaces: Option<Interfaces<'a>>,
}

impl<'a> PairWeight<'a> {
    /// The weights of `problem`.
    pub fn new(problem: &'a Problem) -> Self {
        let kernel = &problem.kernel;
        let moment = problem.correction.moment(kernel, problem.spacing);
        let lattice_ratio = lattice::effective_diffusivity_ratio(kernel, problem.spacing);
        let scale = kernel.dw_over_r_scale() / moment;
        let materials = &problem.materials;
        let pairs = materials.iter().flat_map(|a| materials.iter().map(move |b| (a, b)));
        let mean: Vec<f64> =
            pairs.map(|(a, b)| problem.pair_mean.of(a.conductivity, b.conductivity)).collect();
        let own = materials.iter().flat_map(|a| materials.iter().map(|_| a.capacity));
        Self {
            particles: &problem.particles,
            shape: kernel.kind().definition().shape_dw_over_r,
            inverse_radius: 1.0 / kernel.support_radius(),
            factor: mean.iter().zip(own).map(|(mean, own)| mean * scale / own).collect(),
            conductivity: mean.iter().map(|mean| 0.5 * mean * lattice_ratio / moment).collect(),
            materials: materials.len(),
            lattice_ratio,
            interfaces: Interfaces::of(problem),
        }
    }

    /// w_ab of particles `a` and `b` at distance `dist` (m, below the kernel's cutoff), 1/s, never
    /// negative, with what is known of where their materials meet.
    pub fn between(&self, a: usize, b: usize, dist: f64) -> f64 {
        let weight = self.of(a, b, dist);
        self.interfaces.as_ref().map_or(weight, |interfaces| weight * interfaces.factor(a, b))
    }

    /// Whether it is known where materials meet, so that weights are not always those of the pair mean.
    pub fn knows_interfaces(&self) -> bool {
        self.interfaces.is_some()
    }

    /// The same as if the materials met half way.
    pub fn of(&self, a: usize, b: usize, dist: f64) -> f64 {
        let factor = self.factor[self.materials_of(a, b)];
        -self.particles.volume[b] * factor * (self.shape)(dist * self.inverse_radius)
    }

    /// Half the mean of the pair `a`, `b` as the operator conducts it: the plain one has a factor
    /// Deff / D. For two particles of one material it is that material's conductivity.
    pub fn conductivity(&self, a: usize, b: usize) -> f64 {
        self.conductivity[self.materials_of(a, b)]
    }

    /// The same with what is known of where their materials meet.
    pub fn conductivity_between(&self, a: usize, b: usize) -> f64 {
        let half_way = self.conductivity(a, b);
        self.interfaces.as_ref().map_or(half_way, |interfaces| half_way * interfaces.factor(a, b))
    }

    /// Deff / D of the plain operator on the lattice.
    pub fn lattice_ratio(&self) -> f64 {
        self.lattice_ratio
    }

    fn materials_of(&self, a: usize, b: usize) -> usize {
        let material = |particle: usize| usize::from(self.particles.material[particle]);
        material(a) * self.materials + material(b)
    }
}
