//! How large a step of explicit Euler may be.

mod lanczos;
mod symbol;
mod tridiagonal;

pub use lanczos::{LargestEigenvalue, largest_eigenvalue, rough_field};
pub use symbol::lattice_eigenvalue;
pub use tridiagonal::Tridiagonal;

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

/// The safe bound (s) from the survey's rate bound (1/s): 1 / max_a |A_aa| where no weight is
/// negative, and no more than 2 / max_a sum_b |A_ab| elsewhere.
///
/// Up to the first, each new value is a mean of old ones and of what walls impose: stable, and the
/// maximum principle holds. Infinite for a scene without pairs.
pub fn safe_step(rate_bound: f64) -> f64 {
    if rate_bound > 0.0 { 1.0 / rate_bound } else { f64::INFINITY }
}
