use super::*;
use crate::model::operator::rows::{assemble, cell_grid};
use crate::model::scenes::lattice;
use crate::model::stability::safe_step;
use crate::model::{Correction, KernelKind, Problem};

fn limit(problem: &Problem) -> f64 {
    let grid = cell_grid(problem);
    let (survey, rows) = assemble(problem, &grid);
    let found = largest_eigenvalue(&rows, &problem.particles.volume);
    assert!(2.0 / found.bound >= safe_step(survey.rate_bound) * (1.0 - 1e-9));
    2.0 / found.bound
}

#[test]
fn euler_limit_of_the_cubic_lattice_in_every_dimension() {
    let published = [(1, 24, 0.5, 0.5), (2, 24, 0.3665, 0.3713), (3, 16, 0.3308, 0.3374)];
    for (dimension, n, plain, corrected) in published {
        let counts = std::array::from_fn(|axis| if axis < dimension { n } else { 1 });
        let mut problem = lattice(KernelKind::CubicSpline, dimension, counts, 0.5, 2.0);
        problem.domain.periodic = std::array::from_fn(|axis| axis < dimension);
        for (correction, expected) in [(Correction::None, plain), (Correction::Moment, corrected)] {
            problem.correction = correction;
            let found = limit(&problem) / (0.5 * 0.5);
            assert!((found / expected - 1.0).abs() < 1e-3, "{dimension}-D: {found}");
        }
    }
}

#[test]
fn known_eigenvalues_of_a_held_chain() {
    // 1-D, cubic 2.0: the second difference. Ends held: lambda = 4 sin^2(k pi / 2(n - 1)).
    let mut problem = lattice(KernelKind::CubicSpline, 1, [12, 1, 1], 1.0, 2.0);
    problem.held = vec![0, 11];
    let exact = 4.0 * (10.0 * std::f64::consts::PI / 22.0).sin().powi(2);
    assert!((2.0 / limit(&problem) / exact - 1.0).abs() < 1e-9);
    problem.materials[0].conductivity = 1.01;
    assert!((2.0 / limit(&problem) / exact - 1.0).abs() > 5e-3, "a changed D must be noticed");
}

#[test]
fn a_scene_without_pairs_has_no_limit() {
    let problem = lattice(KernelKind::CubicSpline, 1, [3, 1, 1], 1.0, 0.5);
    assert_eq!(limit(&problem), f64::INFINITY);
}
