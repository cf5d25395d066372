//! The one description of a scene that every backend sees.

use std::borrow::Cow;

use glam::DVec3;
use rayon::prelude::*;

use super::integrator::{MethodChoice, Preconditioner, Tolerance};
use super::operator::ContactResistance;
use super::{
    Correction, Domain, HeatCurve, Kernel, Material, PairMean, Particles, ScalarField, Source,
    Surface, Wall,
};

/// A validated scene in SI units and f64: complete, so that no backend reads anything else.
///
/// [`crate::case`] is what makes one from a case file. What is derived from it (step bounds,
/// the moment of the lattice, the density) comes from functions of this module tree.
#[derive(Clone, Debug)]
pub struct Problem {
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Initial lattice distance dx, m.
    pub spacing: f64,
    /// The bounding box of the fills, and its periodic axes.
    pub domain: Domain,
    /// Positions, volumes and materials.
    pub particles: Particles,
    /// Materials, indexed by [`Particles::material`].
    pub materials: Vec<Material>,
    /// The smoothing kernel with its support radius.
    pub kernel: Kernel,
    /// How the two diffusivities of a pair are joined.
    pub pair_mean: PairMean,
    /// What resists where materials meet: only on a lattice, and with harmonic means.
    pub contacts: Vec<ContactResistance>,
    /// Plain or moment-corrected operator.
    pub correction: Correction,
    /// State of every particle at t = 0, its value or enthalpy (see [`HeatCurve`]); held particles carry
    /// their held one.
    pub initial: Vec<f64>,
    /// Indices of the particles whose value is held, strictly ascending.
    pub held: Vec<u32>,
    /// Walls on faces of the domain; what they do not cover is free.
    pub walls: Vec<Wall>,
    /// Surfaces that are no faces of the domain.
    pub surfaces: Vec<Surface>,
    /// What particles get from nobody.
    pub sources: Vec<Source>,
    /// Duration, step and output times.
    pub time: TimePlan,
    /// Where the value is recorded over time.
    pub probes: Vec<Probe>,
}

/// Duration, step and method.
#[derive(Clone, Debug, PartialEq)]
pub struct TimePlan {
    /// End of the simulated time, s; 0 writes the initial state and the density alone.
    pub end: f64,
    /// The step that the case asks for.
    pub step: StepChoice,
    /// The time integrator.
    pub method: MethodChoice,
    /// Times at which something changes at once (s, ascending): a step ends there.
    pub breaks: Vec<f64>,
    /// How well linear systems are solved where steps are not chosen by a tolerance: of the largest
    /// magnitude of the field, and for a steady state of the first residual.
    pub linear_tolerance: Option<f64>,
    /// What linear systems are preconditioned by.
    pub preconditioner: Preconditioner,
    /// Time between two outputs of the fields, s.
    pub output_every: f64,
    /// Time between two records of the probes, s.
    pub probe_every: f64,
}

/// Where the step comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepChoice {
    /// The largest that is known to be stable, or what the default tolerance allows, as it suits the
    /// method.
    Automatic,
    /// Given by the case, s.
    Given(f64),
    /// What this tolerance of the result allows.
    Tolerance(Tolerance),
}

/// What sources in proportion to the value do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearSources {
    /// The largest -s1, 1/s.
    pub damping: f64,
    /// The largest s1, 1/s.
    pub growth: f64,
}

/// A place where the value is recorded over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// The name in the case file.
    pub name: String,
    /// Position, m.
    pub at: DVec3,
}

impl Problem {
    /// Whether the value of particle `particle` is held.
    pub fn is_held(&self, particle: usize) -> bool {
        self.held.binary_search(&(particle as u32)).is_ok()
    }

    /// Mass of a particle, rho V, kg.
    pub fn mass(&self, particle: usize) -> f64 {
        let material = usize::from(self.particles.material[particle]);
        self.materials[material].density * self.particles.volume[particle]
    }

    /// Capacity rho c of a unit volume of a particle's material.
    pub fn unit_capacity(&self, particle: usize) -> f64 {
        self.materials[usize::from(self.particles.material[particle])].capacity
    }

    /// Capacity of a particle, rho c V: the total that is conserved is the sum of capacity x value.
    pub fn capacity(&self, particle: usize) -> f64 {
        self.unit_capacity(particle) * self.particles.volume[particle]
    }

    /// The capacities of all particles.
    pub fn capacities(&self) -> Vec<f64> {
        (0..self.particles.len()).map(|particle| self.capacity(particle)).collect()
    }

    /// What walls, surfaces and sources impose, in this order: their value, flux or ambient value, and
    /// the s0 of a source. The index is what [`crate::model::operator::fold::Term::imposed`] means.
    pub fn imposed(&self) -> Vec<&ScalarField> {
        let conditions = self.walls.iter().map(|wall| &wall.condition);
        let conditions = conditions.chain(self.surfaces.iter().map(|surface| &surface.condition));
        let sources = self.sources.iter().map(|source| &source.rate);
        conditions.map(|condition| &condition.imposed).chain(sources).collect()
    }

    /// Whether a source acts on particle `particle`: on held ones none does.
    pub fn is_fed(&self, particle: usize) -> bool {
        self.sources.iter().any(|source| source.acts_on(particle)) && !self.is_held(particle)
    }

    /// The factor s1 of particle `particle` from all its sources together, 1/s.
    pub fn linear_source(&self, particle: usize) -> f64 {
        let here = self.sources.iter().filter(|source| source.acts_on(particle));
        let x = self.particles.position[particle];
        here.map(|source| source.linear.at(x, 0.0)).sum::<f64>() / self.unit_capacity(particle)
    }

    /// The largest factor -s1 by which sources damp a particle that is not held, and the largest s1 by
    /// which they make one grow, 1/s; 0 where there is none.
    pub fn linear_sources(&self) -> LinearSources {
        let mut found = LinearSources::default();
        let is_linear = |source: &&Source| source.linear.as_constant() != Some(0.0);
        for source in self.sources.iter().filter(is_linear) {
            for particle in source.indices(self.particles.len()).filter(|&p| !self.is_held(p)) {
                let factor = self.linear_source(particle);
                found.damping = found.damping.max(-factor);
                found.growth = found.growth.max(factor);
            }
        }
        found
    }

    /// Whether a particle is of a material whose value and potential differ from its state: see [`HeatCurve`].
    pub fn has_curves(&self) -> bool {
        let curved = |&m: &u16| self.materials[usize::from(m)].curve.is_some();
        self.materials.iter().any(|material| material.curve.is_some())
            && self.particles.material.iter().any(curved)
    }

    /// Whether all particles follow the same curve, or none.
    pub fn has_one_curve(&self) -> bool {
        if self.materials.iter().all(|material| material.curve.is_none()) {
            return true;
        }
        let material = |m: &u16| &self.materials[usize::from(*m)];
        let Some(first) = self.particles.material.first().map(material) else {
            return true;
        };
        self.particles.material.iter().all(|m| material(m).shares_curve(first))
    }

    /// The curve of a particle's material, if it has one.
    pub fn curve(&self, particle: usize) -> Option<&HeatCurve> {
        self.materials[usize::from(self.particles.material[particle])].curve.as_deref()
    }

    /// How much of a particle is liquid in a state, 0 to 1; 0 where it does not melt.
    pub fn liquid_fraction(&self, particle: usize, enthalpy: f64) -> f64 {
        self.curve(particle).map_or(0.0, |curve| curve.liquid_fraction(enthalpy))
    }

    /// Whether a particle is of a material that melts.
    pub fn melts(&self) -> bool {
        let melts = |m: &u16| {
            let curve = self.materials[usize::from(*m)].curve.as_ref();
            curve.is_some_and(|curve| curve.melting().is_some())
        };
        self.has_curves() && self.particles.material.iter().any(melts)
    }

    /// Values (temperatures) of particles in the state `state`.
    pub fn values<'a>(&self, state: &'a [f64]) -> Cow<'a, [f64]> {
        self.along_curves(state, HeatCurve::temperature)
    }

    /// Potentials of particles in the state `state`: what the operator acts on.
    pub fn potentials<'a>(&self, state: &'a [f64]) -> Cow<'a, [f64]> {
        self.along_curves(state, HeatCurve::potential)
    }

    fn along_curves<'a>(
        &self,
        state: &'a [f64],
        of: impl Fn(&HeatCurve, f64) -> f64 + Sync,
    ) -> Cow<'a, [f64]> {
        if !self.has_curves() {
            return Cow::Borrowed(state);
        }
        let of_particle = |(particle, &enthalpy): (usize, &f64)| {
            self.curve(particle).map_or(enthalpy, |curve| of(curve, enthalpy))
        };
        Cow::Owned(state.par_iter().enumerate().map(of_particle).collect())
    }

    /// How much faster than its state a potential can change, at most: what explicit steps have to be
    /// shorter by. Where materials meet it bounds the flow between them as well. 1 without curves.
    pub fn largest_slope(&self) -> f64 {
        let curves = || self.materials.iter().filter_map(|material| material.curve.as_deref());
        let slope = curves().map(HeatCurve::largest_slope).fold(1.0, f64::max);
        if self.materials.len() == 1 {
            return slope;
        }
        let conduction = curves().map(HeatCurve::largest_conductivity_ratio).fold(1.0, f64::max);
        let warming = curves().map(HeatCurve::largest_warming).fold(1.0, f64::max);
        slope.max(conduction * warming)
    }

    /// The largest diffusivity of any material, m2/s.
    pub fn max_diffusivity(&self) -> f64 {
        self.materials.iter().map(Material::diffusivity).fold(0.0, f64::max)
    }
}
