//! Runs of scenes that melt, on either machine.

use std::ops::ControlFlow;

use diffusph::case::Scene;
use diffusph::report::run::RunReport;
use diffusph::solver::{Machine, PathWish, Precision};
use diffusph::study::{self, Outcome, RunOptions};
use serde_json::{Value, json};

use super::cases::load;

use passes::device;

#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "../gpu_passes/support.rs"]
mod passes;

pub(crate) fn outcome(scene: &Scene, machine: &Machine, path: PathWish) -> Outcome {
    let options = RunOptions { path, ..RunOptions::new(machine) };
    study::run(scene, &options, &mut |_| ControlFlow::Continue(()))
        .unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn run_on(scene: &Scene, machine: &Machine, path: PathWish) -> (RunReport, Vec<f64>) {
    let Outcome { report, state, stopped } = outcome(scene, machine, path);
    assert!(stopped.is_none(), "{stopped:?}");
    (report, state)
}

pub(crate) fn on_gpu(precision: Precision) -> Machine {
    Machine::Gpu { device: device().clone(), precision }
}

pub(crate) fn run(scene: &Scene) -> (RunReport, Vec<f64>) {
    run_on(scene, &Machine::Cpu, PathWish::Auto)
}

/// The same case straight to its steady state.
pub(crate) fn steady(mut case: Value) -> Scene {
    case["time"] = json!({ "end": 1, "method": "steady", "linear_tolerance": 1e-13 });
    load(&case).unwrap_or_else(|error| panic!("{error}"))
}
