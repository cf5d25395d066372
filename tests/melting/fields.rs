//! Fields of runs, and how far they are apart.

use diffusph::case::Scene;
use diffusph::report::run::RunReport;
use diffusph::solver::{Machine, PathWish};

use super::support::run_on;

/// The largest difference of two fields.
pub(crate) fn furthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The report of a run, and temperatures at its end.
pub(crate) fn temperatures(
    scene: &Scene,
    machine: &Machine,
    path: PathWish,
) -> (RunReport, Vec<f64>) {
    let (report, state) = run_on(scene, machine, path);
    (report, scene.problem.values(&state).into_owned())
}
