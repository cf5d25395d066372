//! The report's constant and affine cases on a column, against the exact discrete recurrence.
//!
//! The state of a column with periodic y and z depends on x alone, and the cubic spline at two
//! spacings reaches one layer to either side, so each step is
//! C_i += r (C_(i-1) - 2 C_i + C_(i+1)) with r = dt Deff / dx^2 between the two held layers. Its
//! solution is the steady line plus sine modes, each damped by 1 - 4 r sin^2(k pi / (2 (n - 1))) a
//! step: known without taking a step.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use diffusph::case::{self, Override, Scene};
use diffusph::model::lattice::effective_diffusivity_ratio;
use diffusph::solver::Machine;
use diffusph::study::{self, RunOptions};

/// Layers of the column.
const LAYERS: usize = 100;
/// A tenth of the report's steps.
const STEPS: u64 = 28_032;

fn load(name: &str, set: &[&str]) -> Scene {
    let overrides: Vec<Override> =
        set.iter().map(|text| Override::parse(text).expect("an override")).collect();
    case::load(name, &overrides).expect("a shipped case")
}

fn solve(scene: &Scene) -> Vec<f64> {
    let options = RunOptions::new(&Machine::Cpu);
    let outcome = study::run(scene, &options, &mut |_| ControlFlow::Continue(())).expect("it runs");
    assert_eq!(outcome.report.steps, STEPS);
    assert!(outcome.report.conserved.relative_drift.abs() < 1e-12);
    outcome.state
}

/// The recurrence's value in every layer after `steps` steps from 0, between held ends.
fn recurrence(left: f64, right: f64, r: f64, steps: u64) -> Vec<f64> {
    let last = (LAYERS - 1) as f64;
    let steady = |i: usize| left + (right - left) * i as f64 / last;
    let sine = |k: usize, i: usize| (k as f64 * PI * i as f64 / last).sin();
    let modes: Vec<(f64, f64)> = (1..LAYERS - 1)
        .map(|k| {
            let start: f64 = (1..LAYERS - 1).map(|i| -steady(i) * sine(k, i)).sum();
            let damping = 1.0 - 4.0 * r * (k as f64 * PI / (2.0 * last)).sin().powi(2);
            (2.0 / last * start, damping.powi(steps as i32))
        })
        .collect();
    let transient = |i: usize| -> f64 {
        modes.iter().zip(1..).map(|((start, damped), k)| start * damped * sine(k, i)).sum()
    };
    (0..LAYERS).map(|i| steady(i) + transient(i)).collect()
}

/// The largest deviation from the recurrence over the scale of the field.
fn deviation(scene: &Scene, state: &[f64], left: f64, right: f64, factor: f64) -> f64 {
    let problem = &scene.problem;
    let ratio = effective_diffusivity_ratio(&problem.kernel, problem.spacing);
    let r = 225.0 * problem.materials[0].diffusivity() * ratio * factor / problem.spacing.powi(2);
    let exact = recurrence(left, right, r, STEPS);
    let layer = |x: f64| (x / problem.spacing - 0.5).round() as usize;
    let places = problem.particles.position.iter().zip(state);
    let worst = places.map(|(p, value)| (value - exact[layer(p.x)]).abs()).fold(0.0, f64::max);
    worst / 1000.0
}

#[test]
fn columns_follow_the_exact_recurrence() {
    for (name, left, right) in
        [("constant_column", 1000.0, 1000.0), ("affine_column", 104.5, 995.5)]
    {
        let scene = load(name, &["time.end=0.2*year", "output={}"]);
        let state = solve(&scene);
        let found = deviation(&scene, &state, left, right, 1.0);
        assert!(found < 1e-11, "{name}: {found:e}");
        // The comparison is sharp: a diffusivity off by 1e-9 does not pass it.
        assert!(deviation(&scene, &state, left, right, 1.0 + 1e-9) > 1e-11);
    }
}

#[test]
fn the_recurrence_reaches_the_published_figures_after_all_steps() {
    let column = load("constant_column", &[]);
    let problem = &column.problem;
    let ratio = effective_diffusivity_ratio(&problem.kernel, problem.spacing);
    let r = 225.0 * problem.materials[0].diffusivity() * ratio / problem.spacing.powi(2);
    let constant = recurrence(1000.0, 1000.0, r, 280_320);
    let least = constant.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((least - 999.999_740_757).abs() < 5e-9, "{least}");
    let affine = recurrence(104.5, 995.5, r, 280_320);
    let line = |i: usize| 18.0 * (i as f64 + 0.5) * 0.5 + 100.0;
    let worst = affine.iter().enumerate().map(|(i, c)| (c - line(i)).abs()).fold(0.0, f64::max);
    assert!((worst - 1.425_835e-4).abs() < 5e-10, "{worst:e}");
}
