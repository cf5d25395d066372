//! Newton's method for the implicit stages of a state that is an enthalpy.

use super::cg::SolveFailure;
use crate::solver::{Backend, SolverError};

/// Iterations after which a stage is given up.
const MOST_ITERATIONS: u64 = 60;

/// Iterations of the linear solve of one at most.
const MOST_LINEAR: u64 = 5_000;

/// How much of the residual of a stage its linear system may leave, and how much of what the stage may leave.
const FORCING: f64 = 1e-2;
const LINEAR: f64 = 0.1;

/// What rounding leaves of the residual of a linear system.
const ROUNDING: f64 = 1e-14;

/// Solves x - c A (psi(C + x) - psi(C)) = b for the change x of the state.
///
/// psi is not smooth where a material melts, and flat where all heat is latent; its slope S on one side
/// does (a semi-smooth Newton method: Qi and Sun 1993, Math. Programming 58, 353). With x' = r + c A S^1/2 y
/// for the residual r, (1 - c S^1/2 A S^1/2) y = S^1/2 r is symmetric and positive also where S is 0, and
/// conjugate gradients solve it. The last residual is added to x: so x = b + c A (...) holds to rounding,
/// and with it the balance of energy. What is left of the linear system's residual counts c A S^1/2 times in
/// that of the stage: it is solved so much better. Where several materials meet, the slope of what seams add is
/// left out: large steps then take more iterations, and may not converge.
pub(super) struct Newton<B: Backend> {
    root: B::Vector,
    unknown: B::Vector,
    rest: B::Vector,
    direction: B::Vector,
    product: B::Vector,
    scaled: B::Vector,
    /// No eigenvalue of -A S is above this, 1/s.
    largest: f64,
    pub(super) applications: u64,
}

impl<B: Backend> Newton<B> {
    /// Work vectors on `backend`, for a scene where no eigenvalue of -A S is above `largest` (1/s).
    pub(super) fn new(backend: &mut B, largest: f64) -> Result<Self, SolverError> {
        Ok(Self {
            root: backend.vector()?,
            unknown: backend.vector()?,
            rest: backend.vector()?,
            direction: backend.vector()?,
            product: backend.vector()?,
            scaled: backend.vector()?,
            largest,
            applications: 0,
        })
    }

    /// Operator applications so far.
    pub(super) fn applications(&self) -> u64 {
        self.applications
    }

    /// Makes `x`, a first guess to which the outside gave nothing, solve for `b`, to within `most` in every
    /// particle; `residual` ends with what the outside gave to x.
    ///
    /// # Errors
    /// [`SolverError::NotConverged`].
    pub(super) fn solve(
        &mut self,
        backend: &mut B,
        c: f64,
        b: &B::Vector,
        x: &mut B::Vector,
        residual: &mut B::Vector,
        most: f64,
    ) -> Result<(), SolverError> {
        for iteration in 0..=MOST_ITERATIONS {
            backend.rate_change(x, residual)?;
            self.applications += 1;
            backend.update(residual, c, &[(1.0, b), (-1.0, x)])?;
            let reached = backend.largest(residual)?;
            if reached <= most {
                backend.update(x, 1.0, &[(1.0, residual)])?;
                return backend.update_given(x, 0.0, &[]);
            }
            if iteration == MOST_ITERATIONS || !reached.is_finite() {
                let failed = SolveFailure { iterations: iteration, reached, goal: most };
                return Err(SolverError::NotConverged { failed });
            }
            self.correct(backend, c, x, residual, most)?;
            backend.update(x, 1.0, &[(1.0, residual)])?;
            backend.update_given(x, 0.0, &[])?;
        }
        unreachable!("the last iteration returns")
    }

    /// Replaces `residual` by what solves (1 - c A S) y = residual, with the slopes S at the change `at`.
    pub(super) fn correct(
        &mut self,
        backend: &mut B,
        c: f64,
        at: &B::Vector,
        residual: &mut B::Vector,
        most: f64,
    ) -> Result<(), SolverError> {
        backend.slope_root(at, &mut self.root)?;
        backend.update(&mut self.rest, 0.0, &[(1.0, residual)])?;
        backend.multiply(&mut self.rest, &self.root)?;
        backend.update(&mut self.unknown, 0.0, &[])?;
        backend.update(&mut self.direction, 0.0, &[(1.0, &self.rest)])?;
        let mut square = backend.dot(&self.rest, &self.rest)?;
        let amplified = 1.0 + c * self.largest;
        let goal = square * (FORCING / amplified).max(ROUNDING).powi(2);
        let most = LINEAR * most / amplified;
        for iteration in 0.. {
            let is_small = square <= goal || backend.largest(&self.rest)? <= most;
            if is_small || square == 0.0 {
                break;
            }
            self.apply_scaled(backend, c)?;
            let curvature = backend.dot(&self.direction, &self.product)?;
            if curvature <= 0.0 || !curvature.is_finite() || iteration == MOST_LINEAR {
                let reached = square.sqrt();
                let failed = SolveFailure { iterations: iteration, reached, goal: goal.sqrt() };
                return Err(SolverError::NotConverged { failed });
            }
            let length = square / curvature;
            backend.update(&mut self.unknown, 1.0, &[(length, &self.direction)])?;
            backend.update(&mut self.rest, 1.0, &[(-length, &self.product)])?;
            let after = backend.dot(&self.rest, &self.rest)?;
            backend.update(&mut self.direction, after / square, &[(1.0, &self.rest)])?;
            square = after;
        }
        backend.multiply(&mut self.unknown, &self.root)?;
        backend.apply(&self.unknown, 0.0, c, &mut self.product)?;
        self.applications += 1;
        backend.update(residual, 1.0, &[(1.0, &self.product)])
    }

    /// `product` = (1 - c S^1/2 A S^1/2) `direction`.
    fn apply_scaled(&mut self, backend: &mut B, c: f64) -> Result<(), SolverError> {
        let Self { root, direction, product, scaled, .. } = self;
        backend.update(scaled, 0.0, &[(1.0, direction)])?;
        backend.multiply(scaled, root)?;
        backend.apply(scaled, 0.0, -c, product)?;
        self.applications += 1;
        backend.multiply(product, root)?;
        backend.update(product, 1.0, &[(1.0, direction)])
    }
}
