//! The fastest mode of a scene: the one that explicit Euler loses first.

use crate::model::Problem;
use crate::model::ScalarField;
use crate::model::stability::{Tridiagonal, rough_field};
use crate::solver::{Backend, SolverError};

/// Iterations at most.
const MOST_ITERATIONS: usize = 300;

/// Iterations between two looks at the residual.
const LOOK_EVERY: usize = 10;

/// Iterations of a matrix without symmetry.
const MOST_POWERS: usize = 2000;

/// The iteration ends when the residual of the largest Ritz value is below this part of it.
const RESIDUAL: f64 = 1e-9;

/// A next vector of this part of the last is rounding: the space is exhausted.
const EXHAUSTED: f64 = 1e-12;

/// The largest eigenvalue of -A with its eigenvector, in a backend's vector.
pub(super) struct FastestMode<V> {
    /// lambda_max, 1/s; 0 where there are no pairs.
    pub(super) rate: f64,
    /// The mode, of whatever norm.
    pub(super) mode: V,
}

/// The same scene where walls, surfaces and held particles impose nothing and the field is 0: what is left
/// is rate = A C.
pub(super) fn homogeneous(problem: &Problem) -> Problem {
    let mut problem = problem.clone();
    let nothing = || ScalarField::constant(0.0);
    problem.walls.iter_mut().for_each(|wall| wall.condition.imposed = nothing());
    problem.surfaces.iter_mut().for_each(|surface| surface.condition.imposed = nothing());
    problem.initial.fill(0.0);
    problem
}

impl<V> FastestMode<V> {
    /// By a Lanczos iteration on `backend` (Lanczos 1950), for a matrix that is symmetric. The vectors are
    /// made twice, so that none has to be kept.
    pub(super) fn of<B: Backend<Vector = V>>(
        backend: &mut B,
        problem: &Problem,
    ) -> Result<Self, SolverError> {
        let mut matrix = Tridiagonal::default();
        let mut count = 0;
        let rate = iterate(backend, problem, |_, step| {
            matrix.extend(step.before, step.alpha);
            count += 1;
            let looks = step.is_over || count % LOOK_EVERY == 0 || count == MOST_ITERATIONS;
            if !looks {
                return Ok(None);
            }
            let (ritz, last) = matrix.largest();
            let is_good = step.beta * last.abs() <= RESIDUAL * ritz.abs();
            Ok((is_good || step.is_over || count == MOST_ITERATIONS).then_some(ritz))
        })?;
        let share = matrix.largest_vector();
        let mut mode = backend.vector()?;
        let mut number = 0;
        iterate(backend, problem, |backend, step| {
            backend.update(&mut mode, 1.0, &[(share[number], step.vector)])?;
            number += 1;
            Ok((number == count).then_some(0.0))
        })?;
        Ok(Self { rate: rate.max(0.0), mode })
    }

    /// By a power iteration on `backend`, which a matrix without symmetry allows as well.
    pub(super) fn by_power<B: Backend<Vector = V>>(
        backend: &mut B,
        problem: &Problem,
    ) -> Result<Self, SolverError> {
        let [mut mode, mut next] = [backend.vector()?, backend.vector()?];
        backend.load(&rough_field(problem.particles.len()), &mut mode)?;
        let mut rate = 0.0;
        for _ in 0..MOST_POWERS {
            let norm = backend.dot(&mode, &mode)?.sqrt();
            if norm <= 0.0 {
                break;
            }
            backend.update(&mut mode, 1.0 / norm, &[])?;
            backend.apply(&mode, 0.0, -1.0, &mut next)?;
            rate = backend.dot(&mode, &next)?;
            std::mem::swap(&mut mode, &mut next);
        }
        Ok(Self { rate: rate.max(0.0), mode })
    }
}

/// An iteration, as who follows it sees it.
struct Iteration<'a, V> {
    vector: &'a V,
    /// The diagonal entry of the small matrix, and those beside it before and after.
    alpha: f64,
    before: f64,
    beta: f64,
    /// Whether there is no next vector.
    is_over: bool,
}

/// Makes Lanczos vectors until `follow` returns something.
fn iterate<B: Backend>(
    backend: &mut B,
    problem: &Problem,
    mut follow: impl FnMut(&mut B, &Iteration<'_, B::Vector>) -> Result<Option<f64>, SolverError>,
) -> Result<f64, SolverError> {
    let [mut old, mut vector, mut next] = [backend.vector()?, backend.vector()?, backend.vector()?];
    backend.load(&rough_field(problem.particles.len()), &mut vector)?;
    let norm = backend.dot(&vector, &vector)?.sqrt();
    if norm > 0.0 {
        backend.update(&mut vector, 1.0 / norm, &[])?;
    }
    let mut before = 0.0;
    loop {
        backend.apply(&vector, 0.0, -1.0, &mut next)?;
        let alpha = backend.dot(&vector, &next)?;
        let size = backend.dot(&next, &next)?.max(0.0).sqrt();
        backend.update(&mut next, 1.0, &[(-alpha, &vector), (-before, &old)])?;
        let beta = backend.dot(&next, &next)?.max(0.0).sqrt();
        let is_over = beta <= EXHAUSTED * size;
        let iteration = Iteration { vector: &vector, alpha, before, beta, is_over };
        if let Some(found) = follow(backend, &iteration)? {
            return Ok(found);
        }
        backend.update(&mut next, 1.0 / beta, &[])?;
        std::mem::swap(&mut old, &mut vector);
        std::mem::swap(&mut vector, &mut next);
        before = beta;
    }
}
