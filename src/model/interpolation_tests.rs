use glam::DVec3;

use super::*;
use crate::model::scenes::lattice;
use crate::model::{Condition, Face, KernelKind, Problem, ScalarField, Wall};

fn linear(problem: &Problem) -> Vec<f64> {
    problem.particles.position.iter().map(|p| 3.0 + 2.0 * p.x - p.y + 0.5 * p.z).collect()
}

#[test]
fn a_probe_at_a_particle_reads_that_particle() {
    let problem = lattice(KernelKind::CubicSpline, 3, [4, 4, 4], 0.5, 2.0);
    let state: Vec<f64> = (0..64).map(f64::from).collect();
    let at = problem.particles.position[37];
    let found = Interpolation::at(&problem, at + DVec3::splat(1e-10)).map(|i| i.of(&state, 0.0));
    assert_eq!(found, Some(37.0));
}

#[test]
fn linear_fields_are_exact_also_beside_free_edges() {
    for (dimension, counts) in [(1, [8, 1, 1]), (2, [8, 8, 1]), (3, [6, 6, 6])] {
        let problem = lattice(KernelKind::WendlandC2, dimension, counts, 0.5, 2.0);
        let state = linear(&problem);
        for x in [DVec3::new(0.1, 0.2, 0.05), DVec3::new(1.37, 1.01, 0.9), DVec3::ZERO] {
            let x = (0..dimension).fold(DVec3::ZERO, |mut p, axis| {
                p[axis] = x[axis];
                p
            });
            let exact = 3.0 + 2.0 * x.x - x.y + 0.5 * x.z;
            let found =
                Interpolation::at(&problem, x).expect("there are particles").of(&state, 0.0);
            assert!((found - exact).abs() < 1e-13, "{dimension}-D at {x}: {found}, not {exact}");
        }
    }
}

#[test]
fn a_sheet_is_fitted_along_the_sheet_and_nothing_near_is_none() {
    let problem = lattice(KernelKind::CubicSpline, 3, [6, 6, 1], 0.5, 2.0);
    let state: Vec<f64> = problem.particles.position.iter().map(|p| p.x).collect();
    let found =
        Interpolation::at(&problem, DVec3::new(1.1, 1.2, 0.3)).expect("near").of(&state, 0.0);
    assert!((found - 1.1).abs() < 1e-13);
    assert!(Interpolation::at(&problem, DVec3::new(0.0, 0.0, 9.0)).is_none());
}

#[test]
fn a_smooth_field_converges_at_second_order() {
    let error = |n: usize| {
        let spacing = 1.0 / n as f64;
        let problem = lattice(KernelKind::CubicSpline, 1, [n, 1, 1], spacing, 3.0);
        let state: Vec<f64> =
            problem.particles.position.iter().map(|p| (3.0 * p.x).sin()).collect();
        let x = DVec3::new(0.5 + 0.25 * spacing, 0.0, 0.0);
        let found = Interpolation::at(&problem, x).expect("near").of(&state, 0.0);
        (found - (3.0 * x.x).sin()).abs()
    };
    let slope = (error(40) / error(320)).log2() / 3.0;
    assert!((slope - 2.0).abs() < 0.1, "slope {slope}");
}

/// A wall of the unit conductivity of these scenes.
fn wall(axis: usize, upper: bool, condition: Condition) -> Wall {
    Wall { name: "wall".into(), face: Face { axis, upper }, covers: None, condition }
}

#[test]
fn a_probe_on_a_wall_reads_the_walls_own_relation() {
    let mut problem = lattice(KernelKind::CubicSpline, 2, [8, 8, 1], 0.5, 2.6);
    let state = linear(&problem);
    let exact = |x: DVec3, _: f64| 3.0 + 2.0 * x.x - x.y;
    problem.walls = vec![
        wall(0, false, Condition::value(ScalarField::new("T", exact))),
        wall(0, true, Condition::flux(ScalarField::constant(2.0))),
        // U (ambient - T) = -k dT/dy downwards out of the body.
        wall(
            1,
            true,
            Condition::convection(
                ScalarField::constant(4.0),
                ScalarField::new("T + q / U", move |x, t| exact(x, t) - 0.25),
            ),
        ),
    ];
    let on_walls = [
        [0.0, 1.3],
        [0.0, 0.75],
        [4.0, 2.2],
        [4.0, 0.25],
        [1.9, 4.0],
        [0.75, 4.0],
        // Corners.
        [0.0, 4.0],
        [4.0, 4.0],
    ];
    for [x, y] in on_walls {
        let x = DVec3::new(x, y, 0.0);
        let found = Interpolation::at(&problem, x).expect("near").of(&state, 0.0);
        assert!((found - exact(x, 0.0)).abs() < 1e-13, "at {x}: {found}");
    }
    // The wall's value counts, and when it changes.
    problem.walls[0].condition = Condition::value(ScalarField::new("100 t", |_, t| 100.0 * t));
    let probe = Interpolation::at(&problem, DVec3::new(0.0, 1.3, 0.0)).expect("near");
    assert!((probe.of(&state, 3.0) - 300.0).abs() < 1e-12);
}
