use glam::DVec3;

use super::*;
use crate::model::scenes::{Noise, lattice};
use crate::model::{Correction, KernelKind, Material, PairMean};

/// The rate of every particle in the problem's order, from assembled rows.
fn rates(problem: &Problem, state: &[f64]) -> Vec<f64> {
    let grid = cell_grid(problem);
    let (_, rows) = assemble(problem, &grid);
    let by_rank: Vec<f64> = grid.order().iter().map(|&p| state[p as usize]).collect();
    let mut rate = vec![f64::NAN; state.len()];
    rows.apply(&by_rank, &[], &mut rate, |_, rate| rate);
    let mut out = vec![0.0; state.len()];
    for (&p, rate) in grid.order().iter().zip(rate) {
        out[p as usize] = rate;
    }
    out
}

/// The rate by the report's formula (109) or (107) over rho c, pair by pair, and the sum of its terms'
/// magnitudes.
fn direct(problem: &Problem, state: &[f64]) -> Vec<(f64, f64)> {
    let particles = &problem.particles;
    let moment = problem.correction.moment(&problem.kernel, problem.spacing);
    let k = |i: usize| problem.materials[usize::from(particles.material[i])].conductivity;
    let mean = |a: f64, b: f64| match problem.pair_mean {
        PairMean::Harmonic => 4.0 * a * b / (a + b),
        PairMean::Arithmetic => a + b,
    };
    let term = |a: usize, b: usize| {
        let difference = particles.position[a] - particles.position[b];
        let dist = problem.domain.nearest_image(difference).length();
        if a == b || dist >= problem.kernel.cutoff() {
            return 0.0;
        }
        let f = problem.kernel.dw_over_r(dist) / moment;
        let flow = particles.volume[b] * mean(k(a), k(b)) * (state[a] - state[b]) * f;
        flow / problem.unit_capacity(a)
    };
    let row = |a: usize| (0..state.len()).map(move |b| term(a, b));
    (0..state.len()).map(|a| (row(a).sum(), row(a).map(f64::abs).sum())).collect()
}

/// A lattice with random values, random k over three decades and random rho c over two.
fn random_scene(kind: KernelKind, dimension: usize) -> (Problem, Vec<f64>) {
    let counts = [[40, 1, 1], [9, 8, 1], [6, 7, 6]][dimension - 1];
    let mut problem = lattice(kind, dimension, counts, 0.5, 2.6);
    let mut noise = Noise(5);
    problem.materials = (0..8)
        .map(|i| Material {
            name: i.to_string(),
            conductivity: 1e-3 * 10_f64.powf(3.0 * noise.next()),
            capacity: 10_f64.powf(2.0 * noise.next()),
            curve: None,
            density: 1000.0,
        })
        .collect();
    problem.particles.material.iter_mut().for_each(|m| *m = (8.0 * noise.next()) as u16);
    problem.domain.periodic[0] = true;
    let state = (0..problem.particles.len()).map(|_| noise.next()).collect();
    (problem, state)
}

#[test]
fn rows_equal_the_formula_for_every_kernel_mean_and_correction() {
    for kind in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kind.is_defined_in(d)) {
            for pair_mean in PairMean::ALL {
                for correction in Correction::ALL {
                    let (mut scene, state) = random_scene(kind, dimension);
                    // Off the lattice, where nobody knows where materials meet.
                    scene.particles.position[0].x += 1e-3 * scene.spacing;
                    let problem = Problem { pair_mean, correction, ..scene };
                    let found = rates(&problem, &state);
                    for (rate, (exact, size)) in found.iter().zip(direct(&problem, &state)) {
                        let bound = 64.0 * f64::EPSILON * size;
                        assert!((rate - exact).abs() <= bound, "{kind:?} {dimension}-D");
                    }
                }
            }
        }
    }
}

#[test]
fn one_changed_coefficient_is_noticed() {
    let (mut problem, state) = random_scene(KernelKind::CubicSpline, 2);
    let exact = direct(&problem, &state);
    problem.materials[3].conductivity *= 1.0 + 1e-9;
    let found = rates(&problem, &state);
    let worst = found.iter().zip(exact).map(|(r, (e, size))| (r - e).abs() / size.max(1e-300));
    assert!(worst.fold(0.0, f64::max) > 64.0 * f64::EPSILON);
}

#[test]
fn constants_have_no_rate_and_the_total_is_kept() {
    for kind in KernelKind::ALL {
        let (problem, state) = random_scene(kind, 1);
        assert!(rates(&problem, &vec![7.25; state.len()]).iter().all(|&r| r == 0.0));
        let rate = rates(&problem, &state);
        let sum: f64 = rate.iter().zip(&problem.capacities()).map(|(r, v)| r * v).sum();
        let size: f64 = rate.iter().zip(&problem.capacities()).map(|(r, v)| r.abs() * v).sum();
        assert!(sum.abs() < 64.0 * f64::EPSILON * size, "{kind:?} loses {sum:e} of {size:e}");
    }
}

#[test]
fn linear_and_quadratic_fields_in_the_interior() {
    for kind in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kind.is_defined_in(d)) {
            let counts = std::array::from_fn(|axis| if axis < dimension { 9 } else { 1 });
            let problem = lattice(kind, dimension, counts, 0.5, 3.0);
            let middle = problem.particles.len() / 2;
            let at = |f: fn(DVec3) -> f64| {
                let state: Vec<f64> = problem.particles.position.iter().map(|&p| f(p)).collect();
                rates(&problem, &state)[middle]
            };
            let linear = at(|p| 3.0 * p.x - 2.0 * p.y + p.z + 4.0);
            assert!(linear.abs() < 1e-12, "{kind:?} {dimension}-D linear: {linear:e}");
            // The moment correction makes the Laplacian of |x|^2 / 2, i.e. dim, exact.
            let quadratic = at(|p| 0.5 * p.length_squared());
            assert!((quadratic - dimension as f64).abs() < 1e-11, "{kind:?}: {quadratic}");
        }
    }
}

#[test]
fn the_plain_operator_is_off_by_the_lattice_ratio() {
    let mut problem = lattice(KernelKind::CubicSpline, 3, [9, 9, 9], 0.5, 2.0);
    problem.correction = Correction::None;
    let state: Vec<f64> =
        problem.particles.position.iter().map(|p| 0.5 * p.length_squared()).collect();
    let rate = rates(&problem, &state)[364];
    assert!((rate / 3.0 - 1.020_041_673_8).abs() < 1e-10, "{rate}");
}

#[test]
fn density_has_the_reports_values() {
    let problem = lattice(KernelKind::CubicSpline, 3, [8, 8, 8], 0.5, 2.0);
    let found = density(&problem);
    let at = |x: usize, y: usize, z: usize| found[(z * 8 + y) * 8 + x];
    assert!((at(4, 4, 4) - 999.972_466_09).abs() < 1e-7);
    assert!((at(0, 4, 4) - 850.2879).abs() < 1e-4);
    assert!((at(0, 0, 4) - 719.6610).abs() < 1e-4);
    assert!((at(0, 0, 0) - 606.560_836_12).abs() < 1e-7);
    let survey = survey(&problem, &cell_grid(&problem));
    assert_eq!(survey.max_density, found.iter().copied().fold(0.0, f64::max));
    assert_eq!(survey.min_density, at(0, 0, 0));
}

#[test]
fn harmonic_layers_are_exact_at_two_spacings() {
    // The steady flux through two layers of D = 1 | 1e-3 is the same in both.
    let mut problem = lattice(KernelKind::CubicSpline, 1, [20, 1, 1], 0.05, 2.0);
    problem.materials.push(Material::diffusive("slow", 1e-3, 1.0));
    problem.particles.material[10..].fill(1);
    // Slopes 1 and 1000 with the kink at the interface, x = 0.5.
    let steady = |x: f64| if x < 0.5 { x } else { 0.5 + 1000.0 * (x - 0.5) };
    let state: Vec<f64> = problem.particles.position.iter().map(|p| steady(p.x)).collect();
    let rate = rates(&problem, &state);
    let size = direct(&problem, &state)[10].1;
    assert!(rate[1..19].iter().all(|r| r.abs() < 1e-14 * size), "{rate:?}");
    problem.pair_mean = PairMean::Arithmetic;
    let worst = rates(&problem, &state)[1..19].iter().fold(0.0, |w: f64, r| w.max(r.abs()));
    assert!(worst > 1e-2 * size, "the arithmetic mean must not pass: {worst:e}");
}

#[test]
fn held_rows_are_kept_apart_and_do_not_bound_the_step() {
    let mut problem = lattice(KernelKind::CubicSpline, 1, [10, 1, 1], 1.0, 2.0);
    let all = survey(&problem, &cell_grid(&problem));
    problem.held = (1..10).collect();
    let grid = cell_grid(&problem);
    let (one, rows) = assemble(&problem, &grid);
    assert_eq!(one, survey(&problem, &grid));
    assert!((all.rate_bound - 2.0).abs() < 1e-14 && (one.rate_bound - 1.0).abs() < 1e-14);
    // Only the first particle moves; only the second held one would.
    let state: Vec<f64> = grid.order().iter().map(|&p| if p == 0 { 1.0 } else { 0.0 }).collect();
    let mut rate = vec![f64::NAN; 10];
    rows.apply(&state, &[], &mut rate, |_, rate| rate);
    let moved = |rate: &[f64]| rate.iter().filter(|r| **r != 0.0).count();
    let held: Vec<f64> = rows.held_rates(&state).collect();
    assert_eq!((moved(&rate), moved(&held), rows.held_rank().len()), (1, 1, 9));
    assert!((rate.iter().sum::<f64>() + held.iter().sum::<f64>()).abs() < 1e-15);
}

#[test]
fn coincident_particles_are_reported() {
    let mut problem = lattice(KernelKind::CubicSpline, 1, [10, 1, 1], 1.0, 2.0);
    assert_eq!(survey(&problem, &cell_grid(&problem)).coincident, None);
    problem.particles.position[4] = problem.particles.position[3];
    let found = survey(&problem, &cell_grid(&problem)).coincident.expect("3 and 4 coincide");
    assert_eq!((found.0.min(found.1), found.0.max(found.1)), (3, 4));
}
