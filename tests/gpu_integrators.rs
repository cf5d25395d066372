//! Integrators on the GPU against the same on the CPU.

use std::ops::ControlFlow;

use diffusph::case::Scene;
use diffusph::report::run::RunReport;
use diffusph::solver::{Machine, PathWish, Precision};
use diffusph::study::{self, RunOptions};
use serde_json::json;

use cases::shipped;
use support::device;

#[path = "cases/support.rs"]
mod cases;
#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

fn run(scene: &Scene, machine: &Machine, path: PathWish) -> (RunReport, Vec<f64>) {
    let options = RunOptions { path, ..RunOptions::new(machine) };
    let outcome = study::run(scene, &options, &mut |_| ControlFlow::Continue(()));
    let outcome = outcome.unwrap_or_else(|error| panic!("{error}"));
    assert!(outcome.stopped.is_none(), "{:?}", outcome.stopped);
    (outcome.report, outcome.state)
}

fn gpu(precision: Precision) -> Machine {
    Machine::Gpu { device: device().clone(), precision }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// What each method is given of `constant_column`: two years, of which the values go to 1000.
const WAYS: [(&str, &[&str]); 4] = [
    ("heun", &["time.step=1000", "time.end=100000"]),
    ("rkl2", &["time.step=2*year/32"]),
    ("tr_bdf2", &["time.step=2*year/8", "time.linear_tolerance=3e-5"]),
    ("steady", &[]),
];

#[test]
fn in_f64_the_gpu_does_what_the_cpu_does() {
    for (method, keys) in WAYS {
        let method = format!("time.method={method}");
        let keys: Vec<&str> = std::iter::once(&*method).chain(keys.iter().copied()).collect();
        let scene = shipped("constant_column", &keys);
        for path in [PathWish::Auto, PathWish::List] {
            let (here, on_cpu) = run(&scene, &Machine::Cpu, path);
            let (there, on_gpu) = run(&scene, &gpu(Precision::F64), path);
            let off = distance(&on_cpu, &on_gpu);
            assert!(off < 1e-6, "{method} {path:?}: {off:e}");
            let [here_exchange, there_exchange] =
                [&here, &there].map(|report| report.conserved.boundary_exchange);
            let off = (here_exchange - there_exchange).abs() / here_exchange.abs();
            assert!(off < 1e-8, "{method} {path:?}: exchange {off:e}");
            let [less, more] = [here.operator_applications, there.operator_applications];
            assert!(less.abs_diff(more) <= 4, "{method} {path:?}: {less} {more}");
        }
    }
}

#[test]
fn in_f32_increments_keep_what_states_would_lose() {
    for (method, keys) in &WAYS[1..] {
        let method = format!("time.method={method}");
        let keys: Vec<&str> = std::iter::once(&*method).chain(keys.iter().copied()).collect();
        let scene = shipped("constant_column", &keys);
        let (here, on_cpu) = run(&scene, &Machine::Cpu, PathWish::Auto);
        for (precision, most) in [(Precision::Compensated, 3e-4), (Precision::F32, 3e-3)] {
            let (there, on_gpu) = run(&scene, &gpu(precision), PathWish::Auto);
            let off = distance(&on_cpu, &on_gpu);
            let [less, more] = [here.operator_applications, there.operator_applications];
            assert!(off < most, "{method} {precision:?}: {off:e}");
            assert!(2 * more <= 3 * less, "{method} {precision:?}: {more} for {less}");
        }
    }
}

/// A body of 16 by 16 particles in which nothing is held: beside one that a wall holds, beside a particle
/// alone, or a sheet in three dimensions.
fn floating(beside: &str) -> Scene {
    let body = |min: &[f64], max: &[f64]| json!({ "shape": { "box": { "min": min, "max": max } }, "material": "m" });
    let held = json!({ "wall": { "faces": ["x_min"], "kind": { "value": 1 } } });
    let (dimension, fill, boundaries) = match beside {
        "a wall" => {
            (2, vec![body(&[0.0, 0.0], &[0.8, 1.6]), body(&[1.0, 0.0], &[2.6, 1.6])], json!([held]))
        }
        "a particle" => {
            (2, vec![body(&[0.0, 0.0], &[1.6, 1.6]), body(&[2.5, 0.0], &[2.6, 0.1])], json!([]))
        }
        _ => (3, vec![body(&[0.0; 3], &[1.6, 1.6, 0.1])], json!([])),
    };
    let case = json!({
        "title": "floating", "dimension": dimension,
        "particles": { "spacing": 0.1, "fill": fill },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "materials": { "m": { "diffusivity": 1 } },
        "initial": [{ "value": "0.5*sin(137.3*x + 91.7*y^2 + 50*x*y)" }],
        "boundaries": boundaries,
        "time": { "end": 1, "method": "steady" }
    });
    cases::load(&case).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn bodies_in_which_nothing_is_held_have_a_steady_state_in_every_precision() {
    for beside in ["a wall", "a particle", "nothing"] {
        let scene = floating(beside);
        let (_, here) = run(&scene, &Machine::Cpu, PathWish::List);
        for precision in Precision::ALL {
            let (report, there) = run(&scene, &gpu(precision), PathWish::List);
            let off = distance(&here, &there);
            assert!(off < 10.0 * precision.finest(), "{beside}, {precision:?}: {off:e}");
            assert!(report.operator_applications < 100, "{}", report.operator_applications);
        }
    }
}
