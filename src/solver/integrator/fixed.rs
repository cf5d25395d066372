//! Equal steps.

use super::Integrator;
use crate::solver::{Backend, SolverError};

/// What takes several equal steps.
pub trait Steps<B: Backend> {
    /// Takes `count` steps of `dt` (s) from `time` (s), which is where the state is.
    fn take(&mut self, backend: &mut B, time: f64, dt: f64, count: u64) -> Result<(), SolverError>;

    /// Forgets what it knows of the state: another will be there.
    fn reset(&mut self) {}

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
#[derive(Debug)]
pub struct Equal<I>(pub I);

impl<B: Backend, I: Integrator<B>> Steps<B> for Equal<I> {
    fn take(&mut self, backend: &mut B, time: f64, dt: f64, count: u64) -> Result<(), SolverError> {
        for step in 0..count {
            self.0.propose(backend, time + step as f64 * dt, dt)?;
            self.0.accept(backend)?;
        }
        Ok(())
    }

    fn reset(&mut self) {
        self.0.reset();
    }

    fn applications(&self) -> u64 {
        self.0.applications()
    }
}
