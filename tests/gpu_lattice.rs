//! Lattices on the GPU against the list path of the CPU: rates, fields, exchange, parts.

use diffusph::model::lattice::LatticeScene;
use diffusph::model::{KernelKind, Problem};
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::{Backend, Precision};
use diffusph::study;
use serde_json::{Value, json};

use bounds::{STEPS, allowed, furthest, roundings, step};
use scenes::{COUNTS, boundaries, difference, scene, without_far_bodies};
use support::device;

#[path = "gpu_lattice/bounds.rs"]
mod bounds;
#[path = "lattice_path/scenes.rs"]
mod scenes;
#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

fn gpu(problem: &Problem, options: GpuOptions) -> GpuBackend {
    let scene = LatticeScene::of(problem).expect("a lattice");
    let (walls, _) = study::lattice_walls(problem, &scene).expect("good walls");
    let (dt, _) = step(problem);
    GpuBackend::lattice(problem, &scene, walls, dt, device(), options).expect("backend")
}

/// How far rates, fields and exchange are apart, each over what is allowed.
fn apart(on_list: &Problem, on_lattice: &Problem, precision: Precision) -> [f64; 3] {
    let (dt, _) = step(on_list);
    let mut here = CpuBackend::of(on_list);
    let mut there = gpu(on_lattice, GpuOptions::new(precision));
    let (a, b) = (here.rate(0.3 * dt).expect("rate"), there.rate(0.3 * dt).expect("rate"));
    // Two machines, and up to four roundings of a term, which is a weight times up to twice 310.
    let terms = 620.0 / dt + a.as_ref().iter().fold(0.0, |m: f64, rate| m.max(rate.abs()));
    let rates = furthest(a.as_ref(), b.as_ref());
    here.euler(0.0, dt, STEPS).expect("steps");
    there.euler(0.0, dt, STEPS).expect("steps");
    let (a, b) = (here.read().expect("read"), there.read().expect("read"));
    let total: f64 = on_list.capacities().iter().sum::<f64>() * 300.0;
    let exchange = here.exchange().expect("exchange") - there.exchange().expect("exchange");
    let allowed = allowed(on_list, precision);
    [
        rates / (roundings(on_list, precision) * terms),
        difference(a.as_ref(), b.as_ref()) / allowed,
        exchange.abs() / total / allowed,
    ]
}

fn assert_agreement(problem: &Problem, name: &str) {
    // Precisions share their shaders but for the arithmetic, which knows no dimension; in f64 no fault
    // hides in what rounding allows.
    let all = problem.dimension == 2;
    for precision in Precision::ALL.into_iter().filter(|p| all || *p == Precision::F64) {
        let apart = apart(problem, problem, precision);
        let within = apart.iter().all(|part| *part <= 1.0);
        assert!(within, "{name} {precision:?}: rates, fields, exchange {apart:?}");
    }
}

#[test]
fn every_boundary_agrees_in_every_dimension() {
    for dimension in 1..=3 {
        for boundaries in boundaries(dimension) {
            let name = format!("{dimension}-D {boundaries}");
            let counts = COUNTS[dimension - 1];
            assert_agreement(
                &scene(KernelKind::CubicSpline, 2.0, counts, boundaries).problem,
                &name,
            );
        }
    }
}

#[test]
fn every_kernel_and_support_agrees() {
    let open = |axis: &str| {
        json!([
            { "wall": { "faces": [format!("{axis}_min")], "kind": { "value": "300 + 9*t" } } },
            { "wall": { "faces": [format!("{axis}_max")], "kind": "insulated" } }
        ])
    };
    for kernel in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
            let problem = scene(kernel, 2.4, COUNTS[dimension - 1], open("x")).problem;
            assert_agreement(&problem, &format!("{kernel:?} {dimension}-D"));
        }
    }
    // The widest has more neighbours than are written out.
    for support_ratio in [1.5, 3.0, 3.7, 4.4] {
        let problem = scene(KernelKind::WendlandC2, support_ratio, COUNTS[2], open("z")).problem;
        assert_agreement(&problem, &format!("{support_ratio}"));
    }
}

#[test]
fn one_changed_value_or_weight_is_noticed() {
    let problem = scene(KernelKind::CubicSpline, 2.0, COUNTS[2], boundaries(3).remove(2)).problem;
    for precision in Precision::ALL {
        let free = (500..).find(|particle| !problem.held.contains(particle)).expect("one") as usize;
        // Of 620 over the step, which is what the rates are compared with.
        let roundings = roundings(&problem, precision);
        let mut changed = problem.clone();
        changed.initial[free] *= 1.0 + 4.0 * roundings;
        assert!(apart(&problem, &changed, precision)[0] > 1.0, "{precision:?} value");
        let mut changed = problem.clone();
        changed.materials[0].conductivity *= 1.0 + 400.0 * roundings;
        assert!(apart(&problem, &changed, precision)[0] > 1.0, "{precision:?} weight");
        let mut changed = problem.clone();
        changed
            .initial
            .iter_mut()
            .for_each(|value| *value *= 1.0 + 4.0 * allowed(&problem, precision));
        assert!(apart(&problem, &changed, precision)[1] > 1.0, "{precision:?} field");
        let mut changed = problem.clone();
        changed.held.pop();
        assert!(apart(&problem, &changed, precision)[2] > 1.0, "{precision:?} exchange");
    }
}

#[test]
fn an_order_of_particles_other_than_that_of_sites_makes_no_difference() {
    let mut problem =
        scene(KernelKind::CubicSpline, 2.0, COUNTS[2], boundaries(3).remove(3)).problem;
    let count = problem.particles.len() as u32;
    problem.particles.position.reverse();
    problem.initial.reverse();
    problem.held = problem.held.iter().rev().map(|particle| count - 1 - particle).collect();
    assert!(LatticeScene::of(&problem).expect("a lattice").order.is_some());
    assert_agreement(&problem, "reversed");
}

/// What a backend gives.
struct Outcome {
    rates: Vec<f64>,
    /// After some steps, as the exchange.
    field: Vec<f64>,
    exchange: f64,
    parts: usize,
}

fn outcome(problem: &Problem, options: GpuOptions) -> Outcome {
    let mut backend = gpu(problem, options);
    let (dt, _) = step(problem);
    let rates = backend.rate(0.3 * dt).expect("rate").as_ref().to_vec();
    backend.euler(0.0, dt, STEPS).expect("steps");
    let field = backend.read().expect("read").as_ref().to_vec();
    assert!(backend.is_finite().expect("check"));
    let exchange = backend.exchange().expect("exchange");
    Outcome { rates, field, exchange, parts: backend.chunk_count() }
}

/// Parts of this many layers give what the whole gives: the same operations in the same order, but
/// for what a compiler fuses.
fn parts_agree(problem: &Problem, layers: usize, name: &str) {
    // The shaders are those of f32, and a fault cannot hide in what rounding allows.
    let precision = Precision::F64;
    let counts = LatticeScene::of(problem).expect("a lattice").counts;
    let layer = problem.particles.len() / counts[problem.dimension - 1];
    let whole = GpuOptions::new(precision);
    let bytes = (layers * layer) as u64 * precision.bytes();
    let (one, several) = (
        outcome(problem, whole),
        outcome(problem, GpuOptions { chunk_bytes: Some(bytes), ..whole }),
    );
    assert!(one.parts == 1 && several.parts >= 2, "{} {}", one.parts, several.parts);
    let allowed = allowed(problem, precision);
    // Rates show what a faulty border would do before diffusion blurs it.
    let rates = furthest(&one.rates, &several.rates) * step(problem).0 / 620.0;
    assert!(rates <= roundings(problem, precision), "{name}: rates {rates:e}");
    let fields = difference(&one.field, &several.field);
    assert!(fields <= allowed, "{name}: {fields:e}");
    let total: f64 = problem.capacities().iter().sum::<f64>() * 300.0;
    let exchange = (one.exchange - several.exchange).abs() / total;
    assert!(exchange <= allowed, "{name}: {} {}", one.exchange, several.exchange);
}

#[test]
fn parts_of_the_state_make_no_difference() {
    let many = |dimension: usize| boundaries(dimension).into_iter().enumerate();
    for dimension in 1..=3 {
        for (k, boundaries) in many(dimension).filter(|(k, _)| [1, 2, 6, 8].contains(k)) {
            let counts = COUNTS[dimension - 1];
            let problem = scene(KernelKind::CubicSpline, 2.0, counts, boundaries).problem;
            parts_agree(&problem, 4, &format!("{dimension}-D {k}"));
        }
    }
    // Stencils that reach several layers, the last by loops.
    for (support_ratio, layers) in [(3.0, 4), (4.4, 6)] {
        let periodic = boundaries(3).swap_remove(2);
        let problem = scene(KernelKind::WendlandC2, support_ratio, COUNTS[2], periodic).problem;
        parts_agree(&problem, layers, &format!("{support_ratio}"));
    }
}

#[test]
fn boxes_thinner_than_the_stencil_agree() {
    let counts = [3, 11];
    for (k, support_ratio) in [(0, 4.4), (3, 4.4), (5, 3.0), (7, 3.0)] {
        let boundaries = without_far_bodies(&boundaries(2)[k], counts);
        let problem = scene(KernelKind::WendlandC2, support_ratio, &counts, boundaries).problem;
        assert_agreement(&problem, &format!("{k}"));
    }
}

#[test]
fn parts_thinner_than_the_stencil_are_refused() {
    let problem = scene(KernelKind::CubicSpline, 2.0, COUNTS[2], json!([])).problem;
    let least = GpuOptions { chunk_bytes: Some(300), ..GpuOptions::new(Precision::F32) };
    let scene = LatticeScene::of(&problem).expect("a lattice");
    let refused = GpuBackend::lattice(&problem, &scene, Default::default(), 1.0, device(), least);
    let message = refused.expect_err("a layer has 90 values").to_string();
    assert!(message.contains("layers of a lattice"), "{message}");
}

#[test]
fn a_run_can_be_taken_back_and_divergence_is_seen_in_every_part() {
    let walls: Value = boundaries(2).pop().expect("several");
    let mut problem = scene(KernelKind::CubicSpline, 2.0, COUNTS[1], walls).problem;
    let (dt, _) = step(&problem);
    let options = GpuOptions { chunk_bytes: Some(8 * 4 * 13), ..GpuOptions::new(Precision::F64) };
    let (mut whole, mut split) = (gpu(&problem, options), gpu(&problem, options));
    whole.euler(0.0, dt, STEPS).expect("steps");
    split.euler(0.0, dt, 17).expect("steps");
    split.save().expect("save");
    split.euler(17.0 * dt, dt, 80).expect("steps");
    split.restore().expect("restore");
    split.euler(17.0 * dt, dt, STEPS - 17).expect("steps");
    let (a, b) = (whole.read().expect("read"), split.read().expect("read"));
    assert!(difference(a.as_ref(), b.as_ref()) < 1e-13);
    let (a, b) = (whole.exchange().expect("exchange"), split.exchange().expect("exchange"));
    assert!((a - b).abs() <= 1e-11 * a.abs(), "{a} {b}");
    for place in [0, 70, 142] {
        let before = std::mem::replace(&mut problem.initial[place], f64::NAN);
        assert!(!gpu(&problem, options).is_finite().expect("check"), "{place}");
        problem.initial[place] = before;
    }
}
