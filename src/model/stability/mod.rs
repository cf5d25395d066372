//! How large a step of explicit Euler may be.

mod lanczos;

pub use lanczos::{LargestEigenvalue, largest_eigenvalue};

use super::Problem;

/// The report's step bounds for explicit Euler, s. Neither follows from the matrix: on the report's
/// lattice (116) is 1.5 times above the true limit and (117) six times below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportBounds {
    /// (116): 0.125 H^2 / D.
    pub cfl: f64,
    /// (117): (116) with H / 3 for H, 0.125 H^2 / (9 D).
    pub cfl_third: f64,
}

impl ReportBounds {
    /// The bounds for the scene's largest diffusivity.
    pub fn of(problem: &Problem) -> Self {
        let radius = problem.kernel.support_radius();
        let cfl = 0.125 * radius * radius / problem.max_diffusivity();
        Self { cfl, cfl_third: cfl / 9.0 }
    }
}

/// The safe bound 1 / max_a |A_aa| (s) from the largest diagonal (1/s).
///
/// Where every weight is non-negative, a step up to here makes each new value a mean of old ones:
/// stable, and the maximum principle holds. Infinite for a scene without pairs.
pub fn safe_step(max_diagonal: f64) -> f64 {
    if max_diagonal > 0.0 { 1.0 / max_diagonal } else { f64::INFINITY }
}
