//! Straight to the steady state.

use std::ops::ControlFlow;

use super::cg::{Goal, LinearSolve};
use super::potentials::add_to_potentials;
use crate::model::Problem;
use crate::model::operator::floating_bodies;
use crate::solver::{Backend, SolverError};

/// What the flows through walls may leave over, of their size, and still cancel.
const CONSISTENT: f64 = 1e-8;

/// Goes to the state where A C + s = 0, and returns the operator applications. In a body where nothing holds
/// a value, that is known up to a constant: the one with the mean of the present state is taken. Where the
/// state is an enthalpy, C are its potentials, of which the steady state is as linear.
///
/// Conjugate gradients solve -A x = A C + s for the change x, until the norm of the residual that the
/// preconditioner induces has fallen to `reduction` of what it was. `rounding` is what the precision may
/// leave of flows that cancel, of their size. `watch` may stop it, with the state as it was.
///
/// # Errors
/// Flows through walls that do not cancel in a body where nothing holds a value; a solve that does not
/// converge.
pub fn solve_steady<B: Backend>(
    backend: &mut B,
    problem: &Problem,
    reduction: f64,
    rounding: f64,
    watch: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<u64, SolverError> {
    let mut solve = LinearSolve::new(backend, problem, problem.time.preconditioner)?;
    let [mut change, mut residual] = [backend.vector()?, backend.vector()?];
    backend.rate_into(0.0, &mut residual)?;
    let size = backend.dot(&residual, &residual)?;
    let bodies = floating_bodies(problem);
    for body in &bodies {
        let (flow, volume) = take_mean(backend, problem, body, &mut residual)?;
        if flow.abs() > CONSISTENT.max(rounding) * (size * volume).sqrt() {
            return Err(SolverError::NoSteadyState { flow });
        }
    }
    let goal = Goal::Relative(reduction);
    solve.solve(backend, [0.0, -1.0], &mut change, &mut residual, goal, watch)?;
    for body in &bodies {
        take_mean(backend, problem, body, &mut change)?;
    }
    if backend.is_linear() {
        backend.add(&change)?;
    } else {
        add_to_potentials(backend, problem, &bodies, &change)?;
    }
    Ok(solve.applications() + 1)
}

/// Takes the mean over a body out of x; returns the sum of V x over it, and its volume.
fn take_mean<B: Backend>(
    backend: &mut B,
    problem: &Problem,
    body: &[u32],
    x: &mut B::Vector,
) -> Result<(f64, f64), SolverError> {
    let mut inside = vec![0.0; problem.particles.len()];
    body.iter().for_each(|&particle| inside[particle as usize] = 1.0);
    let mut ones = backend.vector()?;
    backend.load(&inside, &mut ones)?;
    let (sum, volume) = (backend.dot(&ones, x)?, backend.dot(&ones, &ones)?);
    backend.update(x, 1.0, &[(-sum / volume, &ones)])?;
    Ok((sum, volume))
}
