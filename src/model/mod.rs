//! The physics in f64: no wgpu, no input or output.

pub mod field;
pub mod integrator;
pub mod interpolation;
pub mod kernel;
pub mod lattice;
pub mod material;
pub mod neighbors;
pub mod operator;
pub mod particles;
pub mod problem;
#[cfg(test)]
pub(crate) mod scenes;
pub mod source;
pub mod stability;
pub mod sum;
pub mod wall;
pub mod wide;

pub use field::ScalarField;
pub use kernel::{Kernel, KernelKind};
pub use material::{Conductivity, HeatCurve, Material, Melting};
pub use operator::{Correction, PairMean};
pub use particles::{Domain, Particles};
pub use problem::{LinearSources, Probe, Problem, StepChoice, TimePlan};
pub use source::Source;
pub use wall::{Condition, Face, Region, Surface, Wall, WallKind};
