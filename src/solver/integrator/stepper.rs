//! The method of a run, ready on a backend.

use super::{
    Controller, Equal, EulerSteps, Explicit, Integrator, Steps, TrBdf2Steps, largest_eigenvalue,
};
use crate::model::Problem;
use crate::model::integrator::{Method, Recurrence};
use crate::solver::{Backend, Precision, SolverError, Step};

/// How well linear systems of `tr_bdf2` are solved with a given step, of the largest value.
const LINEAR: f64 = 1e-6;

/// How well that of `steady` is, of the first residual.
const REDUCTION: f64 = 1e-10;

/// The largest factor from one step to the next of explicit methods: from rough data, what is fast needs
/// time to decay.
const EXPLICIT_GROWTH: f64 = 1.2;

/// The same where steps damp what is fast.
const IMPLICIT_GROWTH: f64 = 2.0;

/// The method of a run, ready on a backend.
pub struct Stepper<B: Backend> {
    /// What takes its steps.
    pub kind: Kind<B>,
    /// Operator applications before the first step.
    applications: u64,
}

/// What takes the steps of a run.
pub enum Kind<B: Backend> {
    /// Equal steps.
    Equal(Box<dyn Steps<B>>),
    /// Steps that follow a tolerance.
    Adaptive(Box<dyn Integrator<B>>, Controller),
    /// None: straight to the steady state, until the residual has fallen to this part of itself.
    Steady {
        /// The part.
        reduction: f64,
        /// What rounding may leave of flows that cancel, of their size.
        rounding: f64,
        /// Operator applications so far.
        applications: u64,
    },
}

impl<B: Backend + 'static> Stepper<B> {
    /// Prepares the method of `step` for the state of `backend`.
    ///
    /// # Errors
    /// A tolerance below what `precision` can give; a device that fails.
    pub fn new(
        backend: &mut B,
        problem: &Problem,
        step: &Step,
        precision: Precision,
    ) -> Result<Self, SolverError> {
        let linear = problem.time.linear_tolerance;
        let finest = 0.1 * precision.finest();
        if let Some(tolerance) = linear.filter(|&tolerance| tolerance < finest) {
            return Err(SolverError::LinearTooTight { tolerance, finest, precision });
        }
        let preconditioner = problem.time.preconditioner;
        let mut applications = 0;
        // Without a duration there is nothing to prepare for.
        let method = if problem.time.end == 0.0 { Method::Euler } else { step.method };
        let integrator: Box<dyn Integrator<B>> = match method {
            Method::Euler => {
                let kind = Kind::Equal(Box::new(EulerSteps::default()));
                return Ok(Self { kind, applications });
            }
            Method::Steady => {
                let reduction = linear.unwrap_or(REDUCTION.max(finest));
                let rounding = precision.finest();
                let kind = Kind::Steady { reduction, rounding, applications };
                return Ok(Self { kind, applications });
            }
            Method::Heun => Box::new(Explicit::new(backend, Recurrence::Heun, 0.0)?),
            Method::Rkl2 => {
                let safe = 2.0 / step.limits.safe;
                let (largest, spent) = match step.symmetric {
                    true => largest_eigenvalue(backend, problem, safe)?,
                    false => (safe, 0),
                };
                applications = spent;
                Box::new(Explicit::new(backend, Recurrence::Rkl2, largest)?)
            }
            Method::TrBdf2 => {
                let accuracy = linear.unwrap_or(LINEAR.max(finest));
                let largest = 2.0 / step.limits.safe;
                Box::new(TrBdf2Steps::new(backend, problem, accuracy, preconditioner, largest)?)
            }
        };
        let Some(tolerance) = step.tolerance else {
            let kind = Kind::Equal(Box::new(Equal(integrator)));
            return Ok(Self { kind, applications });
        };
        let scale = backend.largest_value()?;
        let finest = precision.finest() * scale;
        let is_relative = tolerance.absolute == 0.0;
        if tolerance.of(scale) < finest || is_relative && tolerance.relative < precision.finest() {
            return Err(SolverError::TooTight {
                tolerance: tolerance.of(scale),
                finest,
                precision,
            });
        }
        let growth = if step.method.is_implicit() { IMPLICIT_GROWTH } else { EXPLICIT_GROWTH };
        let controller = Controller::new(tolerance, growth, step.dt);
        Ok(Self { kind: Kind::Adaptive(integrator, controller), applications })
    }

    /// Operator applications so far.
    pub fn applications(&self) -> u64 {
        let of_steps = match &self.kind {
            Kind::Equal(steps) => steps.applications(),
            Kind::Adaptive(integrator, _) => integrator.applications(),
            Kind::Steady { applications, .. } => *applications,
        };
        self.applications + of_steps
    }
}
