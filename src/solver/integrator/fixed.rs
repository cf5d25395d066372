//! Equal steps.

use super::Integrator;
use crate::solver::{Backend, SolverError};

/// What takes several equal steps.
pub trait Steps<B: Backend> {
    /// Takes `count` steps of `dt` (s) from `time` (s), which is where the state is.
    fn take(&mut self, backend: &mut B, time: f64, dt: f64, count: u64) -> Result<(), SolverError>;

    /// Operator applications so far.
    fn applications(&self) -> u64;
}

/// Explicit Euler, fused on the backend.
#[derive(Debug, Default)]
pub struct EulerSteps {
    applications: u64,
}

impl<B: Backend> Steps<B> for EulerSteps {
    fn take(&mut self, backend: &mut B, time: f64, dt: f64, count: u64) -> Result<(), SolverError> {
        self.applications += count;
        backend.euler(time, dt, count)
    }

    fn applications(&self) -> u64 {
        self.applications
    }
}

/// Equal steps of a method that proposes them.
pub struct Equal<B: Backend>(pub Box<dyn Integrator<B>>);

impl<B: Backend> Steps<B> for Equal<B> {
    fn take(&mut self, backend: &mut B, time: f64, dt: f64, count: u64) -> Result<(), SolverError> {
        for step in 0..count {
            self.0.propose(backend, time + step as f64 * dt, dt)?;
            self.0.accept(backend)?;
        }
        Ok(())
    }

    fn applications(&self) -> u64 {
        self.0.applications()
    }
}
