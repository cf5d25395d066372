//! Lattices with stored rows on the GPU against the list path of the CPU: rates, fields, exchange, parts,
//! and whole runs with every method.

use diffusph::case::Scene;
use diffusph::model::lattice::MixedScene;
use diffusph::model::{KernelKind, Problem};
use diffusph::report::run::RunReport;
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::plan::Path;
use diffusph::solver::{Backend, Machine, MachineKind, PathChoice, PathWish, Precision};
use diffusph::study::{self, RunOptions};
use serde_json::json;
use std::ops::ControlFlow;

use bounds::{STEPS, allowed, furthest, roundings, step};
use scenes::{COUNTS, ball, cut, faces, part, problems, scene};
use support::device;

#[path = "gpu_lattice/bounds.rs"]
mod bounds;
#[expect(dead_code, reason = "the tests of the plain lattice use the rest")]
#[path = "lattice_path/scenes.rs"]
mod boxes;
#[path = "mixed_path/scenes.rs"]
mod scenes;
#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

fn gpu(problem: &Problem, options: GpuOptions) -> GpuBackend {
    let scene = MixedScene::of(problem).expect("a lattice in part");
    let (_, rows) = scene.assemble(problem);
    GpuBackend::mixed(problem, &scene, &rows, step(problem).0, device(), options).expect("backend")
}

/// What a backend makes of a problem.
struct Made {
    rates: Vec<f64>,
    field: Vec<f64>,
    exchange: f64,
}

fn made<B: Backend>(problem: &Problem, backend: &mut B) -> Made {
    let (dt, _) = step(problem);
    let rates = backend.rate(0.3 * dt).expect("rate").as_ref().to_vec();
    backend.euler(0.0, dt, STEPS).expect("steps");
    assert!(backend.is_finite().expect("check"));
    let field = backend.read().expect("read").as_ref().to_vec();
    Made { rates, field, exchange: backend.exchange().expect("exchange") }
}

/// How far rates, fields and exchange are apart, each over what is allowed.
fn apart(problem: &Problem, a: &Made, b: &Made, precision: Precision) -> [f64; 3] {
    let (dt, _) = step(problem);
    // Two machines, and up to four roundings of a term, which is a weight times up to twice 310.
    let terms = 620.0 / dt + a.rates.iter().fold(0.0, |m: f64, rate| m.max(rate.abs()));
    let total: f64 = problem.capacities().iter().sum::<f64>() * 300.0;
    let allowed = allowed(problem, precision);
    [
        furthest(&a.rates, &b.rates) / (roundings(problem, precision) * terms),
        furthest(&a.field, &b.field) / 310.0 / allowed,
        (a.exchange - b.exchange).abs() / total / allowed,
    ]
}

#[test]
fn rates_fields_and_exchange_agree_for_every_scene_dimension_and_precision() {
    for dimension in 1..=3 {
        // A device compiles the stencil of each scene anew, which takes long in 3-D.
        let every = [2, 1, 3][dimension - 1];
        let scenes = problems(KernelKind::CubicSpline, 2.0, dimension).into_iter().step_by(every);
        for (name, problem) in scenes {
            let on_list = made(&problem, &mut CpuBackend::of(&problem));
            // Precisions share their shaders but for the arithmetic, which knows no dimension.
            let all = dimension == 2;
            for precision in Precision::ALL.into_iter().filter(|p| all || *p == Precision::F64) {
                let here = made(&problem, &mut gpu(&problem, GpuOptions::new(precision)));
                let apart = apart(&problem, &on_list, &here, precision);
                let within = apart.iter().all(|part| *part <= 1.0);
                assert!(within, "{dimension}-D {name} {precision:?}: {apart:?}");
            }
        }
    }
}

#[test]
fn wide_stencils_and_parts_of_the_state_make_no_difference() {
    let options = GpuOptions::new(Precision::F64);
    for (kernel, support_ratio, layers) in
        [(KernelKind::CubicSpline, 2.0, 4), (KernelKind::WendlandC2, 3.7, 5)]
    {
        for (name, problem) in problems(kernel, support_ratio, 2).into_iter().step_by(3) {
            let counts = MixedScene::of(&problem).expect("a lattice in part").lattice.counts;
            let bytes = (layers * counts[0]) as u64 * Precision::F64.bytes();
            let split = GpuOptions { chunk_bytes: Some(bytes), ..options };
            let of_parts = gpu(&problem, split);
            assert!(of_parts.chunk_count() >= 2, "{name}");
            let on_list = made(&problem, &mut CpuBackend::of(&problem));
            for mut backend in [gpu(&problem, options), of_parts] {
                let apart =
                    apart(&problem, &on_list, &made(&problem, &mut backend), Precision::F64);
                assert!(apart.iter().all(|part| *part <= 1.0), "{support_ratio} {name}: {apart:?}");
            }
        }
    }
}

#[test]
fn one_changed_row_factor_or_held_particle_is_noticed() {
    let precision = Precision::F64;
    let scenes = problems(KernelKind::CubicSpline, 2.0, 2).into_iter();
    let named = |wanted: &str| {
        scenes.clone().find(|(name, _)| *name == wanted).expect("a scene of this name").1
    };
    let noticed = |problem: &Problem, changed: &Problem| {
        let on_list = made(problem, &mut CpuBackend::of(problem));
        let here = made(changed, &mut gpu(changed, GpuOptions::new(precision)));
        apart(problem, &on_list, &here, precision)
    };
    let layers = named("layers");
    let mut changed = layers.clone();
    changed.materials[2].conductivity *= 1.0 + 1e-9;
    assert!(noticed(&layers, &changed)[0] > 1.0, "a factor of the stencil");
    let holed = named("hole beside a held ball");
    let row = MixedScene::of(&holed).expect("a lattice in part").first_row().expect("rows");
    let mut changed = holed.clone();
    let scene = MixedScene::of(&holed).expect("a lattice in part");
    changed.initial[scene.lattice.particle(row as usize)] += 1e-9;
    assert!(noticed(&holed, &changed)[0] > 1.0, "a value in a stored row");
    let mut changed = holed.clone();
    changed.held.pop();
    assert!(noticed(&holed, &changed)[2] > 1.0, "a held particle");
}

#[test]
fn a_run_can_be_taken_back() {
    let (_, problem) = problems(KernelKind::CubicSpline, 2.0, 2)
        .into_iter()
        .find(|(name, _)| *name == "hole, fluxes and held")
        .expect("a scene of this name");
    let (dt, _) = step(&problem);
    let options = GpuOptions::new(Precision::F64);
    let (mut whole, mut split) = (gpu(&problem, options), gpu(&problem, options));
    whole.euler(0.0, dt, STEPS).expect("steps");
    split.euler(0.0, dt, 17).expect("steps");
    split.save().expect("save");
    split.euler(17.0 * dt, dt, 80).expect("steps");
    split.restore().expect("restore");
    split.euler(17.0 * dt, dt, STEPS - 17).expect("steps");
    let (a, b) = (whole.read().expect("read"), split.read().expect("read"));
    assert!(furthest(a.as_ref(), b.as_ref()) < 1e-11);
    let (a, b) = (whole.exchange().expect("exchange"), split.exchange().expect("exchange"));
    assert!((a - b).abs() <= 1e-11 * a.abs(), "{a} {b}");
}

/// A plate of two materials with a hole, between walls.
fn plate() -> Problem {
    let hole = ball(2, 0.3, 0.6);
    let shapes = [(cut(&part(2, 0.0, 0.6), &[hole]), 1.0), (part(2, 0.6, 1.0), 0.02)];
    let wall = json!({ "wall": { "faces": faces(&["x"]), "kind": { "value": "300 + 20*x" } } });
    let held = json!({ "held": { "where": ball(2, 0.8, 0.7), "value": 250 } });
    scene(KernelKind::CubicSpline, 2.0, 2, &shapes, &[wall, held])
}

fn run(problem: &Problem, machine: &Machine, path: PathWish) -> (RunReport, Vec<f64>) {
    let scene = Scene {
        problem: problem.clone(),
        ..boxes::scene(KernelKind::CubicSpline, 2.0, COUNTS[1], json!([]))
    };
    let options = RunOptions { path, ..RunOptions::new(machine) };
    let outcome = study::run(&scene, &options, &mut |_| ControlFlow::Continue(()));
    let outcome = outcome.unwrap_or_else(|error| panic!("{error}"));
    (outcome.report, outcome.state)
}

#[test]
fn every_method_agrees_with_the_cpu_and_the_list() {
    use diffusph::model::StepChoice;
    use diffusph::model::integrator::{Method, MethodChoice};
    let machine = Machine::Gpu { device: device().clone(), precision: Precision::F64 };
    for method in [Method::Euler, Method::Heun, Method::Rkl2, Method::TrBdf2, Method::Steady] {
        let mut problem = plate();
        problem.time.method = MethodChoice::Given(method);
        problem.time.step = match method {
            Method::Steady => StepChoice::Automatic,
            Method::Euler | Method::Heun => StepChoice::Given(0.4 * step(&problem).0),
            _ => StepChoice::Given(8.0 * step(&problem).0),
        };
        problem.time.end = 64.0 * step(&problem).0;
        let (_, on_cpu) = run(&problem, &Machine::Cpu, PathWish::List);
        let (report, here) = run(&problem, &machine, PathWish::Auto);
        assert_eq!(report.path, "mixed", "{method:?}");
        let off = furthest(&on_cpu, &here) / 310.0;
        // What solves linear systems ends by a residual.
        let most = if matches!(method, Method::TrBdf2 | Method::Steady) { 1e-6 } else { 1e-12 };
        assert!(off < most, "{method:?}: {off:e}");
        let drift = report.conserved.relative_drift;
        assert!(drift.abs() < 1e-10, "{method:?}: drift {drift:e}");
    }
}

#[test]
fn a_device_takes_it_where_it_pays_and_it_saves_the_list() {
    let problem = problems(KernelKind::CubicSpline, 2.0, 3)
        .into_iter()
        .find(|(name, _)| *name == "hole")
        .expect("a scene of this name")
        .1;
    let machine = MachineKind::Gpu(Precision::F32);
    let choice = PathChoice::new(&problem, machine, PathWish::Auto).expect("a path");
    assert_eq!(choice.path(), Path::Mixed);
    let options = GpuOptions::new(Precision::F32);
    let mixed = gpu(&problem, options).memory_bytes();
    let list = GpuBackend::new(&problem, step(&problem).0, device(), Precision::F32);
    let list = list.expect("backend").memory_bytes();
    assert!(2 * mixed < list, "{mixed} {list}");
}
