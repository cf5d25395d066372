//! The whole solver against exact solutions, with the order of accuracy asserted.
//!
//! Every case goes the way of a user's: JSON, scene, plan, CPU path, report. The error is taken
//! from the report, and its order is the least-squares slope over at least four resolutions.

use std::ops::ControlFlow;

use diffusph::case::{self, Override, Scene};
use diffusph::model::lattice::effective_diffusivity_ratio;
use diffusph::report::observed_order;
use diffusph::report::run::ErrorReport;
use diffusph::solver::Machine;
use diffusph::study::{self, RunOptions};
use serde_json::json;

/// Diffusivity of the modes, m2/s.
const DIFFUSIVITY: f64 = 2.0;

/// dt D / dx^2 of the modes in space. It is stable in one and two dimensions, and away from the 1/6
/// at which the errors of the three-point stencil in space and time, together
/// k^4 dx^2 (1/12 - ratio / 2) D t of the mode, cancel.
const STEP_RATIO: f64 = 0.05;

/// Kernels, each with its support radius over the spacing.
const KERNELS: [(&str, f64); 2] = [("cubic_spline", 2.0), ("wendland_c4", 3.0)];

/// What the exact solution says of the error of the state at the end.
fn error_of(scene: &Scene) -> ErrorReport {
    let options = RunOptions::new(&Machine::Cpu);
    let outcome = study::run(scene, &options, &mut |_| ControlFlow::Continue(())).expect("it runs");
    assert!(outcome.stopped.is_none());
    assert!(outcome.report.conserved.relative_drift.abs() < 1e-12);
    outcome.report.error.expect("the case has an exact solution")
}

/// A mode of the periodic unit box on a lattice of `count` particles an axis: 1 plus the product of
/// cos(2 pi x) over the axes, against `decay` as the rate (1/s) at which the product fades.
struct Mode {
    dimension: usize,
    count: usize,
    kernel: (&'static str, f64),
    correction: &'static str,
    /// dt D / dx^2.
    step_ratio: f64,
    decay: String,
}

impl Mode {
    fn error(&self) -> ErrorReport {
        let axes = &["x", "y", "z"][..self.dimension];
        let waves: Vec<String> = axes.iter().map(|axis| format!("cos(2*pi*{axis})")).collect();
        let wave = waves.join("*");
        let (min, max) = (vec![0; self.dimension], vec![1; self.dimension]);
        let case = json!({
            "title": "a mode of the periodic unit box",
            "dimension": self.dimension,
            "particles": {
                "spacing": 1.0 / self.count as f64,
                "fill": [{ "shape": { "box": { "min": min, "max": max } }, "material": "m" }]
            },
            "kernel": { "name": self.kernel.0, "support_ratio": self.kernel.1 },
            "operator": { "correction": self.correction },
            "materials": { "m": { "diffusivity": DIFFUSIVITY } },
            "initial": [{ "value": format!("1+{wave}") }],
            "boundaries": [{ "periodic": { "axes": axes } }],
            "time": { "end": 0.01, "step": format!("{}*spacing^2/{DIFFUSIVITY}", self.step_ratio) },
            "exact": {
                "name": "expression",
                "value": format!("1+exp(-({})*t)*{wave}", self.decay)
            }
        });
        error_of(&case::from_json("mode", case, &[]).expect("a case"))
    }
}

/// The order in the L2 norm over lattices of `counts` particles an axis, the steps going with dx^2.
/// The exact product of modes fades at dim 4 pi^2 D.
fn order_in_space(
    dimension: usize,
    counts: [usize; 4],
    kernel: (&'static str, f64),
    correction: &'static str,
) -> f64 {
    let decay = format!("{dimension}*4*pi^2*{DIFFUSIVITY}");
    let error = counts.map(|count| {
        let decay = decay.clone();
        Mode { dimension, count, kernel, correction, step_ratio: STEP_RATIO, decay }.error().l2
    });
    observed_order(&counts.map(|count| 1.0 / count as f64), &error).expect("four errors")
}

/// The moment-corrected operator reproduces the Laplacian of a quadratic exactly on a lattice; its
/// first error, of the fourth moment, is O(dx^2) at a fixed H / dx. Euler's, O(dt), goes with it.
#[test]
fn modes_converge_with_the_square_of_the_spacing() {
    for kernel in KERNELS {
        for (dimension, counts) in [(1, [20, 40, 80, 160]), (2, [10, 20, 40, 80])] {
            let order = order_in_space(dimension, counts, kernel, "moment");
            assert!((order - 2.0).abs() < 0.05, "{dimension}-D {kernel:?}: {order}");
        }
    }
}

/// Without the correction the scheme converges to another diffusivity, Deff = D (1/dim) sum_b
/// V r |W'(r)|, unless the kernel happens to make that D: no refinement at fixed H / dx helps.
#[test]
fn the_plain_operator_does_not_converge() {
    let order = order_in_space(1, [20, 40, 80, 160], KERNELS[1], "none");
    assert!(order < 0.5, "{order}");
}

/// The errors at fixed spacing with steps of dt, dt/2, dt/4, dt/8, and their order.
fn order_in_time(decay: &str) -> f64 {
    let ratios = [0.4, 0.2, 0.1, 0.05];
    let error = ratios.map(|step_ratio| {
        let (kernel, correction, decay) = (KERNELS[0], "moment", decay.to_owned());
        Mode { dimension: 1, count: 40, kernel, correction, step_ratio, decay }.error().l2
    });
    observed_order(&ratios, &error).expect("four errors")
}

/// In one dimension the cubic spline at two spacings is the three-point stencil, of which the modes
/// are eigenvectors: each fades at D 4 sin^2(k dx / 2) / dx^2, exact in time. What is left against
/// that is Euler's error alone.
#[test]
fn euler_is_of_first_order_in_time() {
    let order = order_in_time(&format!("4*sin(pi*spacing)^2/spacing^2*{DIFFUSIVITY}"));
    assert!((order - 1.0).abs() < 0.05, "{order}");
    // Against the decay of the continuum the error in space would stay, and hide it.
    let order = order_in_time(&format!("4*pi^2*{DIFFUSIVITY}"));
    assert!((order - 1.0).abs() > 0.05, "{order}");
}

/// Lattice distances of the point source, m: 10, 20, 30 and 40 particles along each axis of 50 m.
const SPACINGS: [&str; 4] = ["5", "2.5", "50/30", "1.25"];

/// The report's third case against a point source of all the substance, with steps of (117):
/// support radii H (m) and root mean squares of the error. `ratio` times the material's diffusivity
/// is that of the exact solution.
fn point_sources(correction: &str, ratio: f64) -> ([f64; 4], [f64; 4]) {
    let mut radius = [0.0; 4];
    let mut error = [0.0; 4];
    for (n, spacing) in SPACINGS.iter().enumerate() {
        let exact = format!(
            "exact={{\"name\":\"point_source_in_box\",\"diffusivity\":\"{ratio}*15/year\"}}"
        );
        let set = [
            &format!("particles.spacing={spacing}"),
            &format!("operator.correction={correction}"),
            "time.step=0.125*(2*spacing)^2/(9*15/year)",
            exact.as_str(),
            "output={}",
            "probes=[]",
        ];
        let set = set.map(|text| Override::parse(text).expect("an override"));
        let scene = case::load("gaussian", &set).expect("a shipped case");
        radius[n] = scene.problem.kernel.support_radius();
        error[n] = error_of(&scene).root_mean_square;
    }
    (radius, error)
}

/// A kernel of radius H smooths, and the deposit is on eight particles H / 4 away from the source
/// along each axis: both move the second moment of the field by O(H^2).
#[test]
fn the_corrected_point_source_converges_with_the_square_of_the_support_radius() {
    let (radius, error) = point_sources("moment", 1.0);
    let order = observed_order(&radius, &error).expect("four errors");
    assert!((order - 2.0).abs() < 0.1, "{order}");
    // The published figure at H = 5 m, to its three digits.
    assert!((error[1] - 2.41e-4).abs() <= 0.005e-4, "{:e}", error[1]);
}

/// The plain operator solves the equation of Deff: against D its error stays, against Deff it falls
/// as the corrected one's does against D.
#[test]
fn the_plain_point_source_converges_to_another_diffusivity() {
    let scene = case::load("gaussian_small", &[]).expect("a shipped case");
    let ratio = effective_diffusivity_ratio(&scene.problem.kernel, scene.problem.spacing);
    let (_, [.., coarser, finest]) = point_sources("none", 1.0);
    assert!((coarser / finest - 1.0).abs() < 0.25 && finest > 3e-4, "{coarser:e} {finest:e}");
    let (radius, error) = point_sources("none", ratio);
    let order = observed_order(&radius, &error).expect("four errors");
    assert!((order - 2.0).abs() < 0.1, "{order}");
}
