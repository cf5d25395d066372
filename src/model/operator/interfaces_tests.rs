//! What lies between two particles.

use super::*;
use crate::model::KernelKind;
use crate::model::scenes::lattice;

/// A row of ten cells: six of k = 1, one of k = 0.01, three of k = 10.
fn row() -> Problem {
    let mut problem = lattice(KernelKind::CubicSpline, 2, [10, 4, 1], 0.5, 3.5);
    let base = problem.materials[0].clone();
    let of = |conductivity| crate::model::Material { conductivity, capacity: 1.0, ..base.clone() };
    problem.materials = vec![of(1.0), of(0.01), of(10.0)];
    for (particle, x) in problem.particles.position.iter().enumerate() {
        let column = (x.x / 0.5) as usize;
        problem.particles.material[particle] = [0, 0, 0, 0, 0, 0, 1, 2, 2, 2][column];
    }
    problem
}

/// Conductivity of the pair between two columns of the first line, and the other line so far up.
fn between(problem: &Problem, from: usize, to: usize, up: usize) -> f64 {
    let interfaces = Interfaces::of(problem).expect("there are several");
    let [a, b] = [from, to + 10 * up];
    let k = |p: usize| problem.materials[usize::from(problem.particles.material[p])].conductivity;
    let harmonic = 2.0 * k(a) * k(b) / (k(a) + k(b));
    assert_eq!(interfaces.factor(a, b), interfaces.factor(b, a));
    harmonic * interfaces.factor(a, b)
}

#[test]
fn resistances_on_the_way_add_up() {
    let problem = row();
    let is = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-13, "{found}");
    is(between(&problem, 1, 3, 0), 1.0);
    is(between(&problem, 5, 6, 0), 1.0 / (0.5 + 50.0));
    is(between(&problem, 4, 6, 0), 1.0 / (0.75 + 25.0));
    // Past the thin layer, and at a slant: x is crossed at a quarter and three quarters.
    is(between(&problem, 5, 7, 0), 1.0 / (0.25 + 50.0 + 0.025));
    is(between(&problem, 5, 7, 1), 1.0 / (0.25 + 50.0 + 0.025));
    is(between(&problem, 6, 9, 2), 1.0 / (100.0 / 6.0 + 5.0 / 60.0));
}

#[test]
fn a_contact_resists_across_its_face() {
    let mut problem = row();
    problem.contacts = vec![ContactResistance { between: [0, 1], resistance: 3.0 }];
    let is = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-13, "{found}");
    // One spacing across, two, and two with one to the side.
    is(between(&problem, 5, 6, 0), 1.0 / (50.5 + 3.0 / 0.5));
    is(between(&problem, 4, 6, 0), 1.0 / (25.75 + 3.0 / 1.0));
    is(between(&problem, 4, 6, 1), 1.0 / (25.75 + 3.0 / 1.0));
    is(between(&problem, 6, 7, 0), 1.0 / (50.0 + 0.05));
}

#[test]
fn where_the_interface_is_half_way_or_not_known_there_is_nothing_to_add() {
    let mut near = row();
    near.kernel = crate::model::Kernel::new(KernelKind::CubicSpline, 2, 1.0).expect("a kernel");
    assert!(Interfaces::of(&near).is_none());
    let mut off = row();
    off.particles.position[3].x += 0.1;
    assert!(Interfaces::of(&off).is_none());
    let mut one = row();
    one.particles.material.fill(0);
    assert!(Interfaces::of(&one).is_none());
}
