//! Steps of TR-BDF2.

use super::Integrator;
use super::cg::{Goal, LinearSolve, go_on};
use super::newton::Newton;
use crate::model::Problem;
use crate::model::integrator::{Preconditioner, TrBdf2};
use crate::solver::{Backend, SolverError};

/// How much of what a step may have of an error, linear systems may leave in |r_a / M_aa|: smooth errors
/// are up to some hundred times as large.
const LEFT: f64 = 0.03;

/// How much of what matters an error estimate may be off.
const ESTIMATE: f64 = 0.1;

/// Where nothing has a size yet, how far the residual has to fall.
const FIRST: f64 = 1e-8;

/// How small |r_a / M_aa| has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Accuracy {
    /// In the unit of the field.
    Absolute(f64),
    /// Of the largest magnitude of the field.
    Relative(f64),
}

/// What stages are solved by.
enum Solve<B: Backend> {
    Linear(Box<LinearSolve<B>>),
    /// Where the state is an enthalpy.
    Newton(Box<Newton<B>>),
}

/// TR-BDF2 with conjugate gradients: both stages are solved for the change of the state.
pub struct TrBdf2Steps<B: Backend> {
    solve: Solve<B>,
    accuracy: Accuracy,
    rate: B::Vector,
    /// The changes of the first stage and of the step.
    changes: [B::Vector; 2],
    residual: B::Vector,
    /// The right-hand side of a stage, only where the state is an enthalpy.
    base: Option<B::Vector>,
    /// What changing sources add by the first stage and by the end; only where there are any.
    imposed: Option<[B::Vector; 2]>,
    /// Length of the last proposal, s.
    dt: f64,
    rates: u64,
}

impl<B: Backend> TrBdf2Steps<B> {
    /// Linear systems are solved until no |r_a / M_aa| is above `accuracy`, of the largest value, and stages of
    /// an enthalpy until no |r_a| is. No eigenvalue of -A is above `largest` (1/s).
    pub fn new(
        backend: &mut B,
        problem: &Problem,
        accuracy: f64,
        preconditioner: Preconditioner,
        largest: f64,
    ) -> Result<Self, SolverError> {
        let imposed = match backend.is_source_changing() {
            true => Some([backend.vector()?, backend.vector()?]),
            false => None,
        };
        let solve = match backend.is_linear() {
            true => Solve::Linear(Box::new(LinearSolve::new(backend, problem, preconditioner)?)),
            false => Solve::Newton(Box::new(Newton::new(backend, largest)?)),
        };
        Ok(Self {
            solve,
            accuracy: Accuracy::Relative(accuracy),
            rate: backend.vector()?,
            changes: [backend.vector()?, backend.vector()?],
            residual: backend.vector()?,
            base: None,
            imposed,
            dt: 0.0,
            rates: 0,
        })
    }

    fn goal(&self, backend: &mut B) -> Result<Goal, SolverError> {
        Ok(match self.accuracy {
            Accuracy::Absolute(most) => Goal::Largest(most),
            Accuracy::Relative(part) => match backend.largest_value()? {
                0.0 => Goal::Relative(FIRST),
                scale => Goal::Largest(part * scale),
            },
        })
    }

    /// The same for a residual that is asked for in the unit of the field.
    fn newton_goal(backend: &mut B, goal: Goal) -> Result<f64, SolverError> {
        match goal {
            Goal::Largest(most) => Ok(most),
            Goal::Relative(part) => Ok(part * backend.largest_value()?.max(1.0)),
        }
    }

    fn matrix(&self) -> [f64; 2] {
        [1.0, -TrBdf2::D * self.dt]
    }
}

impl<B: Backend> Integrator<B> for TrBdf2Steps<B> {
    fn propose(&mut self, backend: &mut B, time: f64, dt: f64) -> Result<(), SolverError> {
        const D: f64 = TrBdf2::D;
        self.dt = dt;
        let (matrix, goal) = (self.matrix(), self.goal(backend)?);
        backend.rate_into(time, &mut self.rate)?;
        self.rates += 1;
        if let Some([first, second]) = &mut self.imposed {
            backend.source_change(time, time + TrBdf2::GAMMA * dt, first)?;
            backend.source_change(time, time + dt, second)?;
        }
        let Self { solve, rate, changes: [first, second], residual, imposed, .. } = self;
        let imposed = imposed.as_ref();
        backend.update(first, 0.0, &[])?;
        let solve = match solve {
            Solve::Linear(solve) => solve,
            Solve::Newton(newton) => {
                let most = Self::newton_goal(backend, goal)?;
                let stages = Stages { rate, first, second, residual, imposed };
                return stages.solve(backend, newton, &mut self.base, dt, most);
            }
        };
        let mut terms = vec![(2.0 * D * dt, &*rate)];
        terms.extend(imposed.map(|[first, _]| (D * dt, first)));
        backend.update(residual, 0.0, &terms)?;
        solve.solve(backend, matrix, first, residual, goal, &mut go_on)?;
        // The change of the first stage goes on over the whole step: a first guess, whose residual
        // follows from that of the first stage.
        backend.update(second, 0.0, &[(1.0 / TrBdf2::GAMMA, first)])?;
        // What the outside gave in the first stage is in its residual, d dt times the rate of it.
        backend.update_given(second, 0.0, &[(TrBdf2::W / D, residual)])?;
        let mut terms = vec![(TrBdf2::ALPHA, &*first), ((D - 1.0) * dt, &*rate)];
        terms.extend(
            imposed.into_iter().flat_map(|[first, second]| [(-0.5 * dt, first), (D * dt, second)]),
        );
        backend.update(residual, 1.0 / TrBdf2::GAMMA, &terms)?;
        solve.solve(backend, matrix, second, residual, goal, &mut go_on)?;
        backend.update_given(second, 1.0, &[(1.0, residual)])
    }

    /// The difference to the embedded method, through the matrix of the step so that what is fast counts
    /// as little as in the step itself (Hosea and Shampine 1996, section 3).
    fn error(&mut self, backend: &mut B, negligible: f64) -> Result<f64, SolverError> {
        let matrix = self.matrix();
        let Self { solve, rate, changes: [first, second], residual, dt, .. } = self;
        let [of_rate, of_first, of_second] = TrBdf2::ERROR;
        let terms = [(of_rate * *dt, &*rate), (of_first, &*first), (of_second, &*second)];
        backend.update(residual, 0.0, &terms)?;
        backend.update(first, 0.0, &[])?;
        let most = ESTIMATE * negligible;
        match solve {
            Solve::Linear(solve) => {
                solve.solve(backend, matrix, first, residual, Goal::Largest(most), &mut go_on)?;
                backend.largest(first)
            }
            Solve::Newton(newton) => {
                newton.correct(backend, TrBdf2::D * *dt, second, residual, most)?;
                backend.largest(residual)
            }
        }
    }

    fn accept(&mut self, backend: &mut B) -> Result<(), SolverError> {
        backend.add(&self.changes[1])
    }

    fn aim(&mut self, limit: f64) {
        self.accuracy = Accuracy::Absolute(LEFT * limit);
    }

    fn applications(&self) -> u64 {
        let of_solve = match &self.solve {
            Solve::Linear(solve) => solve.applications(),
            Solve::Newton(newton) => newton.applications(),
        };
        self.rates + of_solve
    }
}

/// What the stages of a step read and write where the state is an enthalpy.
struct Stages<'a, B: Backend> {
    rate: &'a B::Vector,
    first: &'a mut B::Vector,
    second: &'a mut B::Vector,
    residual: &'a mut B::Vector,
    imposed: Option<&'a [B::Vector; 2]>,
}

impl<B: Backend> Stages<'_, B> {
    /// With R(x) = A (psi(C + x) - psi(C)) and the rate f at the start, the changes x of the first stage and
    /// y of the step are x = d dt (2 f + R(x)) and y = dt f + w dt R(x) + d dt R(y), and what sources change
    /// is added to each R.
    fn solve(
        self,
        backend: &mut B,
        newton: &mut Newton<B>,
        base: &mut Option<B::Vector>,
        dt: f64,
        most: f64,
    ) -> Result<(), SolverError> {
        const D: f64 = TrBdf2::D;
        let Self { rate, first, second, residual, imposed } = self;
        let base = match base {
            Some(base) => base,
            none => none.insert(backend.vector()?),
        };
        let mut terms = vec![(2.0 * D * dt, rate)];
        terms.extend(imposed.map(|[first, _]| (D * dt, first)));
        backend.update(base, 0.0, &terms)?;
        newton.solve(backend, D * dt, base, first, residual, most)?;
        backend.rate_change(first, residual)?;
        newton.applications += 1;
        let mut terms = vec![(dt, rate), (TrBdf2::W * dt, &*residual)];
        terms.extend(
            imposed
                .into_iter()
                .flat_map(|[first, second]| [(TrBdf2::W * dt, first), (D * dt, second)]),
        );
        backend.update(base, 0.0, &terms)?;
        // The change of the first stage goes on over the whole step: a first guess.
        backend.update(second, 0.0, &[(1.0 / TrBdf2::GAMMA, first)])?;
        backend.update_given(second, 0.0, &[])?;
        newton.solve(backend, D * dt, base, second, residual, most)?;
        backend.update_given(second, 0.0, &[(1.0, residual)])
    }
}
