//! Straight to the steady state.

use super::cg::{Goal, LinearSolve};
use crate::model::Problem;
use crate::model::integrator::Preconditioner;
use crate::model::wall::WallKind;
use crate::solver::{Backend, SolverError};

/// What the flows through walls may leave over, of their sum of magnitudes, and still cancel.
const CONSISTENT: f64 = 1e-8;

/// Goes to the state where A C + s = 0, and returns the operator applications. Where nothing imposes a
/// value, that is known up to a constant: the one with the mean of the present state is taken.
///
/// Conjugate gradients solve -A x = A C + s for the change x, until the norm of the residual that the
/// preconditioner induces has fallen to `reduction` of what it was.
///
/// # Errors
/// Flows through walls that do not cancel where nothing imposes a value; walls that change in time; a
/// solve that does not converge.
pub fn solve_steady<B: Backend>(
    backend: &mut B,
    problem: &Problem,
    reduction: f64,
    preconditioner: Preconditioner,
) -> Result<u64, SolverError> {
    if backend.is_source_changing() {
        return Err(SolverError::NeverSteady);
    }
    let mut solve = LinearSolve::new(backend, problem, preconditioner)?;
    let [mut change, mut residual] = [backend.vector()?, backend.vector()?];
    backend.rate_into(0.0, &mut residual)?;
    let is_floating = !imposes_a_value(problem);
    if is_floating {
        let mut ones = backend.vector()?;
        backend.load(&vec![1.0; problem.particles.len()], &mut ones)?;
        let volume = backend.dot(&ones, &ones)?;
        let flow = backend.dot(&ones, &residual)?;
        let size = (backend.dot(&residual, &residual)? * volume).sqrt();
        if flow.abs() > CONSISTENT * size {
            return Err(SolverError::NoSteadyState { flow });
        }
        backend.update(&mut residual, 1.0, &[(-flow / volume, &ones)])?;
    }
    let goal = Goal::Relative(reduction);
    solve.solve(backend, [0.0, -1.0], &mut change, &mut residual, goal)?;
    if is_floating {
        let mut ones = backend.vector()?;
        backend.load(&vec![1.0; problem.particles.len()], &mut ones)?;
        let mean = backend.dot(&ones, &change)? / backend.dot(&ones, &ones)?;
        backend.update(&mut change, 1.0, &[(-mean, &ones)])?;
    }
    backend.add(&change)?;
    Ok(solve.applications() + 1)
}

/// Whether held particles, walls or surfaces pull the state towards a value.
fn imposes_a_value(problem: &Problem) -> bool {
    let pulls = |kind: WallKind| matches!(kind, WallKind::Value | WallKind::Convection);
    !problem.held.is_empty()
        || problem.walls.iter().any(|wall| pulls(wall.condition.kind))
        || problem.surfaces.iter().any(|surface| pulls(surface.condition.kind))
}
