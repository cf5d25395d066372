//! Conjugate gradients for the linear systems of implicit methods.

use std::ops::ControlFlow;

use super::coarse::Coarse;
use crate::model::Problem;
use crate::model::integrator::Preconditioner;
use crate::solver::{Backend, SolverError};

/// When a solve is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// No |r_a / M_aa| is above this, in the unit of the unknown.
    Largest(f64),
    /// The norm of the residual that the preconditioner induces is this part of what it was.
    Relative(f64),
}

/// Watches a solve that nobody stops.
pub(super) fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// What a solve that did not get to its goal had come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveFailure {
    /// Iterations done.
    pub iterations: u64,
    /// What was reached, of what the goal is about.
    pub reached: f64,
    /// The goal.
    pub goal: f64,
}

/// Iterations after which a solve is given up.
const MOST_ITERATIONS: u64 = 20_000;

/// Conjugate gradients (Hestenes and Stiefel 1952) for matrices M = shift + scale A, with the work vectors
/// that they need.
pub struct LinearSolve<B: Backend> {
    direction: B::Vector,
    product: B::Vector,
    preconditioned: B::Vector,
    coarse: Option<Coarse>,
    applications: u64,
}

impl<B: Backend> LinearSolve<B> {
    /// Work vectors on `backend`, which holds `problem`.
    pub fn new(
        backend: &mut B,
        problem: &Problem,
        preconditioner: Preconditioner,
    ) -> Result<Self, SolverError> {
        let coarse = match preconditioner {
            Preconditioner::Jacobi => None,
            Preconditioner::TwoLevel => Coarse::new(backend, problem)?,
        };
        Ok(Self {
            direction: backend.vector()?,
            product: backend.vector()?,
            preconditioned: backend.vector()?,
            applications: coarse.as_ref().map_or(0, |coarse| coarse.applications),
            coarse,
        })
    }

    /// Operator applications so far.
    pub fn applications(&self) -> u64 {
        self.applications
    }

    /// Adds to `x` what takes its `residual` b - M x to the goal, for M = `shift` + `scale` A. What the
    /// outside gave to `x` is as before; to `residual` it follows. With a coarse space, the residual ends
    /// with the sum 0 over each aggregate: what is solved conserves exactly. `watch` is asked at every
    /// iteration, and may stop it.
    ///
    /// # Errors
    /// [`SolverError::NotConverged`]; [`SolverError::Interrupted`], at no step.
    pub fn solve(
        &mut self,
        backend: &mut B,
        matrix: [f64; 2],
        x: &mut B::Vector,
        residual: &mut B::Vector,
        goal: Goal,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<(), SolverError> {
        let [shift, scale] = matrix;
        let (mut before, mut start) = (1.0, None);
        for iteration in 0..=MOST_ITERATIONS {
            backend.divide(residual, shift, scale, &mut self.preconditioned)?;
            let mut square = None;
            let (reached, wanted) = match goal {
                Goal::Largest(most) => (backend.largest(&self.preconditioned)?, most),
                Goal::Relative(part) => {
                    let by_diagonal = backend.dot(residual, &self.preconditioned)?;
                    square = Some(by_diagonal);
                    (by_diagonal.sqrt(), part * *start.get_or_insert(by_diagonal.sqrt()))
                }
            };
            // Zero is as good as it gets.
            if reached <= wanted || reached == 0.0 {
                return self.end(backend, matrix, x, residual);
            }
            if watch().is_break() {
                return Err(SolverError::Interrupted { step: 0, time: 0.0 });
            }
            let failed = SolveFailure { iterations: iteration, reached, goal: wanted };
            if iteration == MOST_ITERATIONS || !reached.is_finite() {
                return Err(SolverError::NotConverged { failed });
            }
            if let Some(coarse) = &mut self.coarse {
                coarse.add(backend, matrix, residual, &mut self.preconditioned)?;
                square = None;
            }
            let square = match square {
                Some(known) => known,
                None => backend.dot(residual, &self.preconditioned)?,
            };
            let keep = if iteration == 0 { 0.0 } else { square / before };
            backend.update(&mut self.direction, keep, &[(1.0, &self.preconditioned)])?;
            backend.apply(&self.direction, shift, scale, &mut self.product)?;
            self.applications += 1;
            let curvature = backend.dot(&self.direction, &self.product)?;
            if curvature <= 0.0 {
                return Err(SolverError::NotConverged { failed });
            }
            let length = square / curvature;
            backend.update(x, 1.0, &[(length, &self.direction)])?;
            backend.update(residual, 1.0, &[(-length, &self.product)])?;
            before = square;
        }
        unreachable!("the last iteration returns")
    }

    /// Takes the sums of the residual over the aggregates out.
    fn end(
        &mut self,
        backend: &mut B,
        matrix: [f64; 2],
        x: &mut B::Vector,
        residual: &mut B::Vector,
    ) -> Result<(), SolverError> {
        let Some(coarse) = &mut self.coarse else {
            return Ok(());
        };
        let [shift, scale] = matrix;
        backend.update(&mut self.direction, 0.0, &[])?;
        coarse.add(backend, matrix, residual, &mut self.direction)?;
        backend.apply(&self.direction, shift, scale, &mut self.product)?;
        self.applications += 1;
        backend.update(x, 1.0, &[(1.0, &self.direction)])?;
        backend.update(residual, 1.0, &[(-1.0, &self.product)])
    }
}
