//! Analytic solutions of dC/dt = D laplacian C, also with a source or a phase change, one file a family.

mod annulus;
mod contact;
mod continuous_point_source;
mod exponential_integral;
mod half_space;
mod heated_slab;
mod layers;
mod modes;
mod neumann;
mod oscillating_slab;
mod point_source;
mod quenched_box;
mod side;
mod slab;
mod sphere;
mod zero_flux_box;

use glam::DVec3;
use rayon::prelude::*;

use crate::model::ScalarField;

pub use annulus::{Annulus, AnnulusSetup};
pub use contact::{Contact, HalfBody};
pub use continuous_point_source::ContinuousPointSource;
pub use half_space::HalfSpace;
pub use heated_slab::{HeatedSlab, HeatedSlabSetup};
pub use layers::{Layer, Layers, LayersSetup};
pub use neumann::{Neumann, NeumannSetup, Phase};
pub use oscillating_slab::{OscillatingSlab, OscillatingSlabSetup};
pub use point_source::PointSource;
pub use quenched_box::QuenchedBox;
pub use side::Side;
pub use slab::{Slab, SlabSetup};
pub use sphere::{Sphere, SphereSetup};
pub use zero_flux_box::{MassesInBox, PointSourceInBox, ZeroFluxBox};

/// An analytic solution, evaluated at a position (m) and a time (s).
#[derive(Clone, Debug)]
pub enum Solution {
    /// The same value everywhere.
    Uniform {
        /// The value.
        value: f64,
    },
    /// offset + gradient . x, e.g. the report's (120).
    Affine {
        /// Value at the origin.
        offset: f64,
        /// Gradient, 1/m.
        gradient: DVec3,
    },
    /// A point source in free space, the report's (122).
    PointSource(PointSource),
    /// A point source in a box that nothing leaves.
    PointSourceInBox(PointSourceInBox),
    /// 2^dim equal point masses in a box that nothing leaves.
    MassesInBox(MassesInBox),
    /// A slab between two plane faces.
    Slab(Slab),
    /// A half space behind a plane surface.
    HalfSpace(HalfSpace),
    /// A solid sphere.
    Sphere(Sphere),
    /// The space between two held circles.
    Annulus(Annulus),
    /// A box whose faces are held at one value.
    QuenchedBox(QuenchedBox),
    /// Two bodies that touch.
    Contact(Contact),
    /// A slab one face of which swings about a mean.
    OscillatingSlab(OscillatingSlab),
    /// A point source that goes on, in free space.
    ContinuousPointSource(ContinuousPointSource),
    /// A slab with a uniform source, between held faces.
    HeatedSlab(HeatedSlab),
    /// The steady state of layers between held faces.
    Layers(Layers),
    /// A half space that melts or freezes from its surface.
    Neumann(Neumann),
    /// An expression of the case file.
    Expression(ScalarField),
}

impl Solution {
    /// The name in case files and reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Uniform { .. } => "uniform",
            Self::Affine { .. } => "affine",
            Self::PointSource(_) => "point_source",
            Self::PointSourceInBox(_) => "point_source_in_box",
            Self::MassesInBox(_) => "masses_in_box",
            Self::Slab(_) => "slab",
            Self::HalfSpace(_) => "half_space",
            Self::Sphere(_) => "sphere",
            Self::Annulus(_) => "annulus",
            Self::QuenchedBox(_) => "quenched_box",
            Self::Contact(_) => "contact",
            Self::OscillatingSlab(_) => "oscillating_slab",
            Self::ContinuousPointSource(_) => "continuous_point_source",
            Self::HeatedSlab(_) => "heated_slab",
            Self::Layers(_) => "layers",
            Self::Neumann(solution) if solution.is_one_phase() => "stefan",
            Self::Neumann(_) => "neumann",
            Self::Expression(_) => "expression",
        }
    }

    /// Whether it may be that of a scene with sources.
    pub fn allows_sources(&self) -> bool {
        matches!(
            self,
            Self::Uniform { .. }
                | Self::Affine { .. }
                | Self::ContinuousPointSource(_)
                | Self::HeatedSlab(_)
                | Self::Expression(_)
        )
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        match self {
            Self::Uniform { value } => *value,
            Self::Affine { offset, gradient } => offset + gradient.dot(x),
            Self::PointSource(solution) => solution.at(x, t),
            Self::PointSourceInBox(solution) => solution.at(x, t),
            Self::MassesInBox(solution) => solution.at(x, t),
            Self::Slab(solution) => solution.at(x, t),
            Self::HalfSpace(solution) => solution.at(x, t),
            Self::Sphere(solution) => solution.at(x, t),
            Self::Annulus(solution) => solution.at(x, t),
            Self::QuenchedBox(solution) => solution.at(x, t),
            Self::Contact(solution) => solution.at(x, t),
            Self::OscillatingSlab(solution) => solution.at(x, t),
            Self::ContinuousPointSource(solution) => solution.at(x, t),
            Self::HeatedSlab(solution) => solution.at(x, t),
            Self::Layers(solution) => solution.at(x),
            Self::Neumann(solution) => solution.at(x, t),
            Self::Expression(field) => field.at(x, t),
        }
    }

    /// How much of a body of this extent (m) along x is liquid at time `t` (s), m; `None` where the
    /// solution has no front across x.
    pub fn liquid_depth(&self, t: f64, extent: DVec3) -> Option<f64> {
        match self {
            Self::Neumann(solution) => solution.liquid_depth(t, extent),
            _ => None,
        }
    }

    /// Whether it is liquid at position `x` (m) and time `t` (s), which the temperature alone does not tell
    /// at a sharp melting point; `None` where the solution has no phases.
    pub fn is_liquid(&self, x: DVec3, t: f64) -> Option<bool> {
        match self {
            Self::Neumann(solution) => Some(solution.is_liquid(x, t)),
            _ => None,
        }
    }

    /// The values at `positions` (m) and time `t` (s), computed in parallel.
    pub fn evaluate(&self, positions: &[DVec3], t: f64) -> Vec<f64> {
        positions.par_iter().map(|&x| self.at(x, t)).collect()
    }
}

#[cfg(test)]
mod tests;
