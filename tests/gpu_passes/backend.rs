use diffusph::model::operator::PairWeight;
use diffusph::model::{KernelKind, Problem};
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::{Backend, Precision};

use crate::support::{device, epsilon, random_lattice};

/// A step well below the stability limit of [`random_lattice`], s.
const STEP: f64 = 5e-3;

fn backend(problem: &Problem, precision: Precision) -> GpuBackend {
    GpuBackend::new(problem, STEP, device(), precision).expect("backend")
}

fn after(problem: &Problem, options: GpuOptions, steps: u64) -> Vec<f64> {
    let mut backend = GpuBackend::with_options(problem, STEP, device(), options).expect("backend");
    backend.euler(0.0, STEP, steps).expect("steps");
    backend.read().expect("field").as_ref().to_vec()
}

/// `steps` Euler steps in f64, and what the held particles gave.
fn plain_euler(problem: &Problem, steps: usize) -> (Vec<f64>, f64) {
    let weight = PairWeight::new(problem);
    let position = &problem.particles.position;
    let count = position.len();
    let mut pairs = Vec::new();
    for a in 0..count {
        for b in (0..count).filter(|&b| b != a) {
            let apart = problem.domain.nearest_image(position[a] - position[b]);
            if apart.length() < problem.kernel.cutoff() {
                pairs.push((a, b, weight.of(a, b, apart.length())));
            }
        }
    }
    let (mut value, mut given) = (problem.initial.clone(), 0.0);
    for _ in 0..steps {
        let mut increment = vec![0.0; count];
        for &(a, b, w) in &pairs {
            increment[a] += STEP * w * (value[b] - value[a]);
        }
        for a in 0..count {
            if problem.held.contains(&(a as u32)) {
                given -= problem.capacity(a) * increment[a];
            } else {
                value[a] += increment[a];
            }
        }
    }
    (value, given)
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn steps_with_held_particles_equal_plain_steps() {
    let mut problem = random_lattice(KernelKind::CubicSpline, 2, 9);
    problem.held = vec![3, 40, 41, 80];
    for precision in Precision::ALL {
        let mut backend = backend(&problem, precision);
        backend.euler(0.0, STEP, 25).expect("steps");
        let field = backend.read().expect("field");
        let (expected, given) = plain_euler(&problem, 25);
        // Values near 320 are rounded in each step; a weight sum below 1 amplifies none of it. The
        // increments, below 20, carry up to 64 roundings.
        let rounded = if precision == Precision::Compensated { 0.0 } else { 320.0 };
        let tolerance = 25.0 * (rounded + 64.0 * 20.0) * epsilon(precision);
        assert!(largest_difference(field.as_ref(), &expected) <= tolerance);
        for &held in &problem.held {
            let kept = problem.initial[held as usize];
            assert!((field.as_ref()[held as usize] - kept).abs() <= kept * epsilon(precision));
        }
        let exchange = backend.exchange().expect("exchange");
        let volume: f64 = problem.capacities().iter().sum();
        assert!((exchange - given).abs() <= tolerance * volume);
        // What the held ones gave is what the others gained.
        let gained: f64 = (0..expected.len())
            .map(|i| problem.capacity(i) * (field.as_ref()[i] - problem.initial[i]))
            .sum();
        assert!((exchange - gained).abs() <= tolerance * volume);
        // One step fewer would be noticed: in the field always, in the exchange at least in f64.
        let (earlier, given_earlier) = plain_euler(&problem, 24);
        assert!(largest_difference(field.as_ref(), &earlier) > tolerance);
        let noticed = (exchange - given_earlier).abs() > tolerance * volume;
        assert!(noticed || precision != Precision::F64);
        let rate = backend.rate(0.0).expect("rate");
        assert!(problem.held.iter().all(|&h| rate.as_ref()[h as usize] == 0.0));
    }
}

#[test]
fn runs_repeat_bit_for_bit_and_do_not_depend_on_chunks_or_workgroups() {
    for precision in Precision::ALL {
        let problem = random_lattice(KernelKind::WendlandC2, 3, 11);
        let options = GpuOptions::new(precision);
        let field = after(&problem, options, 50);
        assert_eq!(field, after(&problem, options, 50));
        let split = GpuOptions { chunk_bytes: Some(32 * 50 * 8), ..options };
        let chunked = GpuBackend::with_options(&problem, STEP, device(), split).expect("backend");
        assert!(chunked.chunk_count() > 10);
        assert_eq!(field, after(&problem, split, 50));
        let wide = GpuOptions { workgroup_size: 256, ..options };
        assert_eq!(field, after(&problem, wide, 50));
        let mut changed = problem.clone();
        changed.initial[5] += 0.01;
        assert_ne!(field, after(&changed, options, 50));
    }
}

#[test]
fn a_slice_that_no_binding_holds_is_an_error_with_its_size() {
    let problem = random_lattice(KernelKind::WendlandC2, 3, 6);
    let options = GpuOptions { chunk_bytes: Some(128), ..GpuOptions::new(Precision::F32) };
    let error = GpuBackend::with_options(&problem, STEP, device(), options).expect_err("too large");
    assert!(error.to_string().contains("takes 128 in one piece"), "{error}");
}

#[test]
fn save_and_restore_bring_the_state_back() {
    let mut problem = random_lattice(KernelKind::Lucy, 2, 9);
    problem.held = vec![7];
    let mut backend = backend(&problem, Precision::F32);
    backend.euler(0.0, STEP, 3).expect("steps");
    let (field, given) = (backend.read().expect("field"), backend.exchange().expect("exchange"));
    backend.save().expect("save");
    backend.euler(0.0, STEP, 4).expect("steps");
    assert_ne!(backend.read().expect("field"), field);
    backend.restore().expect("restore");
    assert_eq!(backend.read().expect("field"), field);
    assert_eq!(backend.exchange().expect("exchange"), given);
}

#[test]
fn a_value_that_is_not_finite_is_noticed() {
    for precision in Precision::ALL {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut problem = random_lattice(KernelKind::CubicSpline, 1, 100);
            assert!(backend(&problem, precision).is_finite().expect("check"));
            problem.initial[77] = value;
            let mut backend = backend(&problem, precision);
            assert!(!backend.is_finite().expect("check"), "{value} {precision:?}");
        }
    }
}

#[test]
fn no_particle_and_one_particle_work() {
    for precision in Precision::ALL {
        for count in [0, 1] {
            let mut problem = random_lattice(KernelKind::CubicSpline, 3, 2);
            problem.particles.position.truncate(count);
            problem.particles.volume.truncate(count);
            problem.particles.material.truncate(count);
            problem.initial = vec![5.0; count];
            let mut backend = backend(&problem, precision);
            backend.euler(0.0, STEP, 10).expect("steps");
            backend.save().expect("save");
            backend.restore().expect("restore");
            assert_eq!(backend.read().expect("field").as_ref(), problem.initial);
            assert_eq!(backend.rate(0.0).expect("rate").as_ref(), vec![0.0; count]);
            assert_eq!(backend.exchange().expect("exchange"), 0.0);
            assert!(backend.is_finite().expect("check"));
        }
    }
}
