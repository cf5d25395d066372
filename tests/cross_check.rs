//! The CPU path against the GPU, through types that cannot be mixed up.

use std::ops::ControlFlow;

use diffusph::case::{self, Override, Scene};
use diffusph::model::operator::rows::{cell_grid, survey};
use diffusph::model::{KernelKind, PairMean, Problem};
use diffusph::solver::cpu::{CpuBackend, CpuField};
use diffusph::solver::gpu::{GpuBackend, GpuField};
use diffusph::solver::{Backend, Machine, PathWish, Precision};
use diffusph::study::{self, RunOptions};

use support::{brute_force, by_neighbors, device, epsilon, random_lattice};

#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

/// Steps of a comparison.
const STEPS: u64 = 50;

/// Every shipped case, cut to a size that takes a moment.
fn small_cases() -> Vec<Scene> {
    let coarse: &[&str] = &["particles.spacing=5", "time.step=4e4", "output={}", "probes=[]"];
    let layers: &[&str] =
        &["boundaries.1.held.where.box.max.0=5", "boundaries.2.held.where.box.min.0=45"];
    let cut = |name: &str| -> Vec<&str> {
        match name {
            "constant" | "affine" => [coarse, layers].concat(),
            "gaussian" => coarse.to_vec(),
            _ => Vec::new(),
        }
    };
    let load = |name: &str| {
        let parse = |text: &&str| Override::parse(text).expect("an override");
        let overrides: Vec<Override> = cut(name).iter().map(parse).collect();
        case::load(name, &overrides).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    case::shipped().iter().map(|(name, _)| load(name)).collect()
}

/// The largest difference over the largest value.
fn difference(cpu: &CpuField, gpu: &GpuField) -> f64 {
    let pairs = cpu.as_ref().iter().zip(gpu.as_ref());
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let scale = cpu.as_ref().iter().fold(0.0, |scale: f64, c| scale.max(c.abs()));
    worst / scale.max(f64::MIN_POSITIVE)
}

/// Roundings of one step, each worth half an epsilon of the largest value: 32 of the weights (see
/// the rate tests of the passes), one for each neighbour's addition, and the update. A step below
/// the safe bound is a mean of old values, so errors add up and do not grow.
fn tolerance(problem: &Problem, precision: Precision) -> f64 {
    let grid = cell_grid(problem);
    let most = survey(problem, &grid).most_neighbors;
    0.5 * epsilon(precision) * (34.0 + most as f64) * STEPS as f64
}

/// How many rates differ by more than the roundings of both sides explain.
fn rates_apart(cpu: &CpuField, gpu: &GpuField, allowed: &[f64]) -> usize {
    let (cpu, gpu) = (cpu.as_ref(), gpu.as_ref());
    assert!(cpu.len() == allowed.len() && gpu.len() == allowed.len());
    let apart = |&((a, b), allowed): &((&f64, &f64), &f64)| {
        let off = (a - b).abs();
        off > *allowed || off.is_nan()
    };
    cpu.iter().zip(gpu).zip(allowed).filter(apart).count()
}

/// What roundings in f64 on one side and in `precision` on the other allow each rate of `problem`.
fn rate_tolerance(problem: &Problem, precision: Precision) -> Vec<f64> {
    // Tolerances are proportional to epsilon.
    let both = f64::EPSILON + epsilon(precision);
    brute_force(problem, both).into_iter().map(|(_, tolerance)| tolerance).collect()
}

/// [`rates_apart`] with `on_cpu` on one side and `on_gpu`, by list and matrix-free, on the other.
fn compare_rates(on_cpu: &Problem, on_gpu: &Problem, precision: Precision) -> [usize; 2] {
    let rate = CpuBackend::of(on_cpu).rate(0.0).expect("rate");
    let allowed = rate_tolerance(on_cpu, precision);
    by_neighbors(on_gpu, 1e-3, precision)
        .map(|(_, mut backend)| rates_apart(&rate, &backend.rate(0.0).expect("rate"), &allowed))
}

/// A jittered lattice with random values, volumes and diffusivities of contrast 1e3.
fn jittered(kernel: KernelKind, dimension: usize) -> Problem {
    random_lattice(kernel, dimension, [33, 9, 6][dimension - 1])
}

#[test]
fn rates_agree_in_every_kernel_dimension_mean_and_precision() {
    for kernel in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
            for pair_mean in PairMean::ALL {
                let problem = Problem { pair_mean, ..jittered(kernel, dimension) };
                for precision in Precision::ALL {
                    let apart = compare_rates(&problem, &problem, precision);
                    assert_eq!(
                        apart,
                        [0, 0],
                        "{kernel:?} {dimension}-D {pair_mean:?} {precision:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_cross_check_of_rates_notices_one_volume_and_the_other_mean() {
    for precision in Precision::ALL {
        let problem = jittered(KernelKind::WendlandC4, 2);
        let mut volume = problem.clone();
        volume.particles.volume[40] *= 1.01;
        let apart = compare_rates(&problem, &volume, precision);
        assert!(apart.iter().all(|&apart| apart > 0), "{precision:?}: {apart:?}");
        let [one, other] = PairMean::ALL;
        let swapped = if problem.pair_mean == one { other } else { one };
        let mean = Problem { pair_mean: swapped, ..problem.clone() };
        let most = problem.particles.len();
        let apart = compare_rates(&problem, &mean, precision);
        assert!(apart.iter().all(|&apart| apart > most / 2), "{precision:?}: {apart:?}");
    }
}

#[test]
fn fields_agree_after_many_steps_of_every_shipped_case() {
    for scene in small_cases() {
        let mut problem = scene.problem;
        // Not at rest, so that there is something to compare.
        for (value, x) in problem.initial.iter_mut().zip(&problem.particles.position) {
            *value += 3.0 + (x.x + 2.0 * x.y).sin();
        }
        let dt = 0.9 / survey(&problem, &cell_grid(&problem)).rate_bound;
        let mut on_cpu = CpuBackend::of(&problem);
        on_cpu.euler(0.0, dt, STEPS).expect("steps");
        for precision in Precision::ALL {
            // A search takes long on a software adapter: once is enough.
            let paths = if precision == Precision::F64 { 2 } else { 1 };
            for (path, mut on_gpu) in by_neighbors(&problem, dt, precision).into_iter().take(paths)
            {
                on_gpu.euler(0.0, dt, STEPS).expect("steps");
                let name = format!("{} by {path} in {precision:?}", scene.name);
                let found =
                    difference(&on_cpu.read().expect("read"), &on_gpu.read().expect("read"));
                let allowed = tolerance(&problem, precision);
                assert!(found <= allowed, "{name}: {found:e} > {allowed:e}");
                let given = on_cpu.exchange().expect("exchange");
                let volume: f64 = problem.capacities().iter().sum();
                let scale = volume * problem.initial.iter().fold(0.0, |s: f64, c| s.max(c.abs()));
                let off = (given - on_gpu.exchange().expect("exchange")).abs();
                assert!(off <= allowed * scale, "{name}: exchange off by {off:e}");
            }
        }
    }
}

#[test]
fn the_cross_check_notices_one_changed_weight() {
    let scene = case::load("gaussian_small", &[]).expect("a shipped case");
    let dt = scene.problem.spacing.powi(2) / scene.problem.materials[0].diffusivity() / 10.0;
    let mut changed = scene.problem.clone();
    changed.particles.volume[6000] *= 1.0 + 1e-3;
    let mut on_cpu = CpuBackend::of(&scene.problem);
    let mut on_gpu = GpuBackend::new(&changed, dt, device(), Precision::F64).expect("backend");
    on_cpu.euler(0.0, dt, STEPS).expect("steps");
    on_gpu.euler(0.0, dt, STEPS).expect("steps");
    let found = difference(&on_cpu.read().expect("read"), &on_gpu.read().expect("read"));
    assert!(found > tolerance(&scene.problem, Precision::F64), "{found:e}");
}

#[test]
fn saved_states_come_back_on_both_sides() {
    let problem = case::load("gaussian_small", &[]).expect("a shipped case").problem;
    let dt = problem.spacing.powi(2) / problem.materials[0].diffusivity() / 10.0;
    let gpu = GpuBackend::new(&problem, dt, device(), Precision::F32).expect("backend");
    fn check<B: Backend>(mut backend: B, dt: f64) {
        backend.euler(0.0, dt, 3).expect("steps");
        backend.save().expect("save");
        let before = backend.read().expect("read").as_ref().to_vec();
        backend.euler(0.0, dt, 3).expect("steps");
        assert_ne!(backend.read().expect("read").as_ref(), before);
        backend.restore().expect("restore");
        assert_eq!(backend.read().expect("read").as_ref(), before);
        assert!(backend.is_finite().expect("check"));
    }
    check(CpuBackend::of(&problem), dt);
    check(gpu, dt);
}

#[test]
fn a_run_without_a_list_is_one_and_says_so() {
    let overrides = ["output={}", "probes=[]"].map(|text| Override::parse(text).expect("good"));
    let scene = case::load("annulus_steady", &overrides).expect("a shipped case");
    let on = |machine: &Machine, path| {
        let options = RunOptions { path, ..RunOptions::new(machine) };
        study::run(&scene, &options, &mut |_| ControlFlow::Continue(()))
    };
    let gpu = Machine::Gpu { device: device().clone(), precision: Precision::F64 };
    let listed = on(&gpu, PathWish::List).expect("a run");
    let searched = on(&gpu, PathWish::MatrixFree).expect("a run");
    let (list, search) = (&listed.report, &searched.report);
    assert_eq!((list.path.as_str(), search.path.as_str()), ("list", "matrix-free"));
    assert!(search.left_out.iter().any(|left| left.what == "neighbour list and weights"));
    // Nearly eight entries of 12 bytes a particle, and places in cells instead.
    let saved = list.memory_bytes - search.memory_bytes;
    assert!(saved > 50 * list.particles, "{} {}", list.memory_bytes, search.memory_bytes);
    let largest = listed.state.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    let apart = listed.state.iter().zip(&searched.state).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) <= 1e-12 * largest);
    let refused = on(&Machine::Cpu, PathWish::MatrixFree).expect_err("the CPU has no such path");
    assert!(refused.is_usage() && refused.to_string().contains("--backend gpu"), "{refused}");
}
