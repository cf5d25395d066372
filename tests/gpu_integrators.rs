//! Integrators on the GPU against the same on the CPU.

use std::ops::ControlFlow;

use diffusph::case::Scene;
use diffusph::report::run::RunReport;
use diffusph::solver::{Machine, PathWish, Precision};
use diffusph::study::{self, RunOptions};

use cases::shipped;
use support::device;

#[expect(dead_code, reason = "other tests write their own cases")]
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
