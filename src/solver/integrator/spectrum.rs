//! The largest eigenvalue of the operator on a backend.

use crate::model::Problem;
use crate::model::stability::{Tridiagonal, rough_field};
use crate::solver::{Backend, SolverError};

/// Iterations at most.
const MOST_ITERATIONS: usize = 60;

/// Iterations at least: the first value that looks settled need not be the largest.
const LEAST_ITERATIONS: usize = 10;

/// The iteration ends when the residual of the largest Ritz value is below this part of it.
const RESIDUAL: f64 = 0.02;

/// What the bound is above what was found: the eigenvalue may lie a little further off than the residual
/// says, if the iteration has not met it yet.
const MARGIN: f64 = 1.01;

/// A bound of the largest eigenvalue of -A (1/s), no more than `safe`, with the applications that it
/// took: a few steps of a Lanczos iteration (Lanczos 1950), whose residual is added, and a margin of 1 %.
/// A has to be symmetric. Where the state is an enthalpy, that of A S with the largest slope S.
pub fn largest_eigenvalue<B: Backend>(
    backend: &mut B,
    problem: &Problem,
    safe: f64,
) -> Result<(f64, u64), SolverError> {
    let [mut before, mut vector, mut next] =
        [backend.vector()?, backend.vector()?, backend.vector()?];
    backend.load(&rough_field(problem.particles.len()), &mut vector)?;
    let norm = backend.dot(&vector, &vector)?.sqrt();
    if norm <= 0.0 {
        return Ok((safe, 0));
    }
    backend.update(&mut vector, 1.0 / norm, &[])?;
    let margin = MARGIN * problem.largest_slope();
    let (mut matrix, mut beta) = (Tridiagonal::default(), 0.0);
    for iteration in 1..=MOST_ITERATIONS {
        backend.apply(&vector, 0.0, -1.0, &mut next)?;
        let alpha = backend.dot(&vector, &next)?;
        backend.update(&mut next, 1.0, &[(-alpha, &vector), (-beta, &before)])?;
        matrix.extend(beta, alpha);
        beta = backend.dot(&next, &next)?.max(0.0).sqrt();
        let (ritz, last) = matrix.largest();
        let residual = beta * last.abs();
        let is_over = iteration >= LEAST_ITERATIONS && residual <= RESIDUAL * ritz;
        if is_over || residual == 0.0 || iteration == MOST_ITERATIONS {
            return Ok(((margin * (ritz + residual)).min(safe), iteration as u64));
        }
        backend.update(&mut next, 1.0 / beta, &[])?;
        std::mem::swap(&mut before, &mut vector);
        std::mem::swap(&mut vector, &mut next);
    }
    unreachable!("the last iteration returns")
}
