//! What two machines may differ by on a lattice.

use diffusph::model::Problem;
use diffusph::model::operator::rows::{cell_grid, survey};
use diffusph::solver::Precision;

use super::support::epsilon;

/// Steps of a run: more than the device holds changing sources for at once.
pub(crate) const STEPS: u64 = 70;

/// The stable step, s, and the most neighbours.
pub(crate) fn step(problem: &Problem) -> (f64, usize) {
    let survey = survey(problem, &cell_grid(problem));
    (0.9 / survey.rate_bound, survey.most_neighbors)
}

/// In the field and in the exchange over the total, after some steps: a step is a mean of old values, so that
/// roundings add up and do not grow.
pub(crate) fn allowed(problem: &Problem, precision: Precision) -> f64 {
    let (_, neighbors) = step(problem);
    match precision {
        // The list and the lattice are to agree as they do on the CPU.
        Precision::F64 => 1e-13,
        // Differences between neighbours are at most a fifth of the values.
        Precision::F32 | Precision::Compensated => {
            (8.0 + neighbors as f64 / 4.0) * STEPS as f64 * epsilon(precision)
        }
    }
}

/// In rates, over what a value changes by in the longest step that is stable.
pub(crate) fn roundings(problem: &Problem, precision: Precision) -> f64 {
    let (_, neighbors) = step(problem);
    (2 * (neighbors + 64)) as f64 * epsilon(precision)
}

/// The largest difference of two fields.
pub(crate) fn furthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
