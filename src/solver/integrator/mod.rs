//! Time integrators, each written once over the backend trait.
//!
//! | method | file | what it is |
//! |---|---|---|
//! | `euler` | `fixed` | the backend's own fused steps |
//! | `heun`, `rkl2` | `explicit` | recurrences of [`crate::model::integrator::Recurrence`] |
//! | `tr_bdf2` | `tr_bdf2` | two linear systems a step, by conjugate gradients (`cg`), or where the state is an
//! enthalpy two that are not linear (`newton`) |
//! | `steady` | `steady` | one linear system, of an enthalpy that of its `potentials` |
//!
//! Steps are equal (`fixed`) or follow a tolerance (`control`).

mod cg;
mod coarse;
mod control;
mod explicit;
mod fixed;
mod newton;
mod potentials;
mod spectrum;
mod steady;
mod stepper;
mod tr_bdf2;

pub use cg::{Goal, LinearSolve, SolveFailure};
pub use control::Controller;
pub use explicit::Explicit;
pub use fixed::{Equal, EulerSteps, Steps};
pub use spectrum::largest_eigenvalue;
pub use steady::solve_steady;
pub use stepper::{Kind, Stepper};
pub use tr_bdf2::TrBdf2Steps;

use super::{Backend, SolverError};

/// A method with an error estimate: it computes the change of the state over a step, which is then taken
/// or not.
pub trait Integrator<B: Backend> {
    /// Computes the change over a step of `dt` (s) from `time` (s), where the state is.
    fn propose(&mut self, backend: &mut B, time: f64, dt: f64) -> Result<(), SolverError>;

    /// The estimated error of what was proposed, the largest over all particles; what is below
    /// `negligible` need not be known well.
    fn error(&mut self, backend: &mut B, negligible: f64) -> Result<f64, SolverError>;

    /// Takes what was proposed.
    fn accept(&mut self, backend: &mut B) -> Result<(), SolverError>;

    /// What an error of a step matters, in the unit of the field: linear systems are solved as well as
    /// that needs.
    fn aim(&mut self, _limit: f64) {}

    /// Operator applications so far.
    fn applications(&self) -> u64;
}
