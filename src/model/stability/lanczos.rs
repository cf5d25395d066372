//! The largest eigenvalue of the operator by a Lanczos iteration.

use rayon::prelude::*;

use super::Tridiagonal;
use crate::model::operator::rows::Rows;

/// Iterations at most; the largest eigenvalue of a lattice's operator needs about 50.
const MAX_ITERATIONS: usize = 300;
/// The iteration ends when the residual of the largest Ritz value falls below this fraction of it.
const TOLERANCE: f64 = 1e-4;
/// Iterations between two looks at the residual.
const CHECK_EVERY: usize = 10;
/// Rows that one task of a parallel product handles.
const ROWS_PER_TASK: usize = 4096;

/// What the iteration found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestEigenvalue {
    /// The largest Ritz value plus its residual, 1/s: an eigenvalue lies within the residual of
    /// the Ritz value, and the iteration finds the largest first.
    pub bound: f64,
    /// Operator applications spent.
    pub applications: u64,
}

/// lambda_max of -A for the rows of the particles that are not held (Lanczos 1950; Parlett 1998,
/// chapter 13). `volume` is in the rows' order; scaled by its roots, the matrix is symmetric. Held
/// particles have empty rows; their values stay 0 here.
pub fn largest_eigenvalue(rows: &Rows, volume: &[f64]) -> LargestEigenvalue {
    let n = volume.len();
    let root: Vec<f64> = volume.iter().map(|v| v.sqrt()).collect();
    let mut previous = vec![0.0; n];
    let mut vector = start_vector(rows, n);
    let (mut matrix, mut beta) = (Tridiagonal::default(), 0.0);
    for iteration in 1..=MAX_ITERATIONS {
        let mut next = apply(rows, &root, &vector);
        let alpha = dot(&vector, &next);
        axpy(&mut next, -alpha, &vector);
        axpy(&mut next, -beta, &previous);
        matrix.extend(beta, alpha);
        beta = dot(&next, &next).sqrt();
        let exhausted = beta <= 1e-12 * alpha.abs() || iteration == MAX_ITERATIONS;
        if exhausted || iteration % CHECK_EVERY == 0 {
            let (ritz, last) = matrix.largest();
            let residual = beta * last.abs();
            if exhausted || residual <= TOLERANCE * ritz {
                return LargestEigenvalue {
                    bound: ritz + residual,
                    applications: iteration as u64,
                };
            }
        }
        next.par_iter_mut().for_each(|x| *x /= beta);
        previous = std::mem::replace(&mut vector, next);
    }
    unreachable!("the last iteration returns")
}

/// A field with a part in every mode: reproducible noise.
pub fn rough_field(count: usize) -> Vec<f64> {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..count).map(|_| noise()).collect()
}

/// A rough field of norm 1, but 0 for held particles.
fn start_vector(rows: &Rows, n: usize) -> Vec<f64> {
    let mut vector = rough_field(n);
    for &rank in rows.held_rank() {
        vector[rank as usize] = 0.0;
    }
    let norm = dot(&vector, &vector).sqrt();
    if norm > 0.0 {
        vector.iter_mut().for_each(|x| *x /= norm);
    }
    vector
}

/// y = V^(1/2) (-A) V^(-1/2) x.
fn apply(rows: &Rows, root: &[f64], x: &[f64]) -> Vec<f64> {
    let scaled: Vec<f64> = x.par_iter().zip(root).map(|(x, r)| x / r).collect();
    let mut y = vec![0.0; x.len()];
    rows.apply(&scaled, &[], &mut y, |_, rate| -rate);
    y.par_iter_mut().zip(root).for_each(|(y, r)| *y *= r);
    y
}

/// A dot product whose order of summation does not depend on the number of threads.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let part = |(x, y): (&[f64], &[f64])| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let parts: Vec<f64> =
        x.par_chunks(ROWS_PER_TASK).zip(y.par_chunks(ROWS_PER_TASK)).map(part).collect();
    parts.iter().sum()
}

fn axpy(y: &mut [f64], factor: f64, x: &[f64]) {
    y.par_iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
}

#[cfg(test)]
#[path = "lanczos_tests.rs"]
mod tests;
