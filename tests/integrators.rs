//! Every method on problems whose answer is known: orders, costs, tolerances, conservation, errors.

use std::ops::ControlFlow;

use diffusph::case::{self, Scene};
use diffusph::model::Problem;
use diffusph::model::integrator::Method;
use diffusph::report::run::RunReport;
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::{Backend, Machine, SolverError};
use diffusph::study::{self, RunOptions};
use serde_json::{Value, json};

use cases::shipped;

#[expect(dead_code, reason = "other tests write their own cases")]
#[path = "cases/support.rs"]
mod cases;

/// A case with other keys of `time`.
fn with(case: &Value, time: Value) -> Scene {
    let mut case = case.clone();
    case["time"] = time;
    case::from_json("test", case, &[]).unwrap_or_else(|error| panic!("{error}"))
}

struct Run {
    report: RunReport,
    state: Vec<f64>,
}

fn try_run(scene: &Scene) -> Result<Run, String> {
    let options = RunOptions::new(&Machine::Cpu);
    let outcome = study::run(scene, &options, &mut |_| ControlFlow::Continue(()));
    let outcome = outcome.map_err(|error| error.to_string())?;
    match outcome.stopped {
        None => Ok(Run { report: outcome.report, state: outcome.state }),
        Some(error) => Err(error.to_string()),
    }
}

fn run(scene: &Scene) -> Run {
    try_run(scene).unwrap_or_else(|error| panic!("{error}"))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A line of `n` particles with walls, and what is in it first.
fn walled(n: u32, left: &str, right: &str, initial: &str) -> Value {
    let wall = |face: &str, value: &str| json!({ "wall": { "faces": [face], "kind": { "value": value } } });
    json!({
        "title": "line",
        "dimension": 1,
        "particles": {
            "spacing": 1.0 / f64::from(n),
            "fill": [{ "shape": { "box": { "min": [0], "max": [1] } }, "material": "unit" }]
        },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "operator": { "correction": "none" },
        "materials": { "unit": { "diffusivity": 1 } },
        "initial": [{ "value": initial }],
        "boundaries": [wall("x_min", left), wall("x_max", right)],
        "time": { "end": 1 }
    })
}

/// Two layers whose diffusivities differ by a factor of 1e6: 1 held on the fast side, 0 on the other.
fn layers() -> Value {
    let held = |from: f64, to: f64, value: f64| {
        json!({ "held": {
            "where": { "box": { "min": [from], "max": [to] } }, "value": value
        } })
    };
    let layer = |from: f64, to: f64, name: &str| json!({ "shape": { "box": { "min": [from], "max": [to] } }, "material": name });
    json!({
        "title": "layers",
        "dimension": 1,
        "particles": {
            "spacing": 0.01, "fill": [layer(0.0, 0.5, "fast"), layer(0.5, 1.0, "slow")]
        },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "operator": { "correction": "none" },
        "materials": { "fast": { "diffusivity": 1 }, "slow": { "diffusivity": 1e-6 } },
        "initial": [{ "value": 0 }],
        "boundaries": [held(0.0, 0.01, 1.0), held(0.99, 1.0, 0.0)],
        "time": { "end": 1 }
    })
}

/// log2 of the ratios of consecutive errors.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

#[test]
fn every_method_has_its_order() {
    // A decaying sine mode, whose rate is that of the second difference; and walls that change.
    let (n, end) = (8, 0.1);
    let sine = walled(n, "0", "0", "sin(pi*x)");
    let rate = 4.0 * f64::from(n * n) * (0.5 * std::f64::consts::PI / f64::from(n)).sin().powi(2);
    let moving = walled(n, "sin(20*t)", "t^2", "x");
    let time = |method: Method, steps: f64| json!({ "end": end, "step": end / steps, "method": method.name(), });
    let first = run(&with(&sine, time(Method::Heun, 1.6e4))).state;
    let start: Vec<f64> = (0..n)
        .map(|i| (std::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(n)).sin())
        .collect();
    let exact: Vec<f64> = start.iter().map(|c| c * (-rate * end).exp()).collect();
    assert!(distance(&first, &exact) < 1e-9);
    let reference = run(&with(&moving, time(Method::Heun, 1.6e4))).state;
    for method in Method::ALL {
        if method == Method::Steady {
            let steady = run(&with(&sine, json!({ "end": end, "method": "steady" })));
            assert!(distance(&steady.state, &vec![0.0; n as usize]) < 1e-12);
            continue;
        }
        let expected = if method == Method::Euler { 1.0 } else { 2.0 };
        for (case, exact) in [(&sine, &exact), (&moving, &reference)] {
            let error = |steps: f64| {
                let mut time = time(method, steps);
                if method == Method::TrBdf2 {
                    time["linear_tolerance"] = json!(1e-12);
                }
                distance(&run(&with(case, time)).state, exact)
            };
            let found = orders(&[32.0, 64.0, 128.0, 256.0].map(error));
            let is_right = found.iter().all(|order| (order - expected).abs() < 0.25);
            assert!(is_right, "{}: {found:?}", method.name());
        }
    }
}

#[test]
fn costs_of_equal_steps() {
    let year = 31_536_000.0;
    let constant = |keys: &[&str]| run(&shipped("constant_column", keys));
    // The 280 320 steps of the case have an error of 2.6e-4 of 1000 that time does not add to.
    let found =
        constant(&["time.method=tr_bdf2", "time.step=2*year/8", "time.linear_tolerance=3e-5"]);
    let error = found.report.error.expect("it has an exact solution").linf / 1000.0;
    let applications = found.report.operator_applications;
    assert!(error < 1e-3 && applications <= 850, "{error:e} {applications}");
    let found = constant(&["time.method=rkl2", "time.step=2*year/32"]);
    let error = found.report.error.expect("it has an exact solution").linf / 1000.0;
    let applications = found.report.operator_applications;
    assert!(error < 1e-3 && applications <= 2520, "{error:e} {applications}");
    assert!((found.report.simulated_s - 2.0 * year).abs() < 1.0);
    for (name, jacobi) in [("constant_column", 50), ("affine_column", 99)] {
        let steady = |preconditioner: &str| {
            let key = format!("time.preconditioner={preconditioner}");
            let found = run(&shipped(name, &["time.method=steady", &key]));
            let error = found.report.error.expect("it has an exact solution").linf;
            assert!(error < 1e-6, "{name} {error:e}");
            found.report.operator_applications
        };
        assert_eq!(steady("jacobi"), jacobi);
        assert!(steady("two_level") < jacobi);
    }
    let layers = layers();
    let fine = |end: f64, method: &str, steps: f64| {
        run(&with(&layers, json!({ "end": end, "method": method, "step": end / steps }))).state
    };
    let fast = fine(1.0, "rkl2", 4096.0);
    let check = |time: Value, reference: &[f64], most: f64, dearest: u64| {
        let found = run(&with(&layers, time.clone()));
        let error = distance(&found.state, reference);
        let applications = found.report.operator_applications;
        assert!(error <= most && applications <= dearest, "{time}: {error:e} {applications}");
        error
    };
    let by = |end: f64, method: &str, steps: f64, linear: f64| {
        let mut time = json!({ "end": end, "method": method, "step": end / steps });
        if method == "tr_bdf2" {
            time["linear_tolerance"] = json!(linear);
        }
        time
    };
    check(by(1.0, "tr_bdf2", 8.0, 3e-5), &fast, 1e-3, 450);
    check(by(1.0, "rkl2", 16.0, 0.0), &fast, 1e-3, 1200);
    let end = 1.25e4;
    let slow = run(&with(&layers, by(end, "tr_bdf2", 2000.0, 1e-9))).state;
    check(by(end, "tr_bdf2", 20.0, 4e-6), &slow, 1e-4, 1000);
}

/// Errors of tolerances of 1e-3 to 1e-6 of `scale`, over these.
fn follow(case: &Value, end: f64, method: Method, reference: &[f64], scale: f64) -> Vec<f64> {
    let error = |relative: f64| {
        let time = json!({
            "end": end, "method": method.name(), "tolerance": { "relative": relative }
        });
        distance(&run(&with(case, time)).state, reference) / (scale * relative)
    };
    [1e-3, 1e-4, 1e-5, 1e-6].map(error).to_vec()
}

#[test]
fn the_error_follows_the_tolerance() {
    let check = |case: &Value, end: f64, methods: &[Method], reference: &[f64], scale: f64| {
        for &method in methods {
            let parts = follow(case, end, method, reference, scale);
            assert!(parts.iter().all(|&part| part <= 3.0), "{}: {parts:?}", method.name());
            // By 5 a decade, over three decades. The steps of heun are limited by stability as well, and
            // then better than asked for.
            let falls = 1e3 * parts[0] / parts[3];
            assert!(falls >= 125.0 || method == Method::Heun, "{}: {parts:?}", method.name());
        }
    };
    let all = [Method::Heun, Method::Rkl2, Method::TrBdf2];
    let stiff = [Method::Rkl2, Method::TrBdf2];
    // A jump at both ends, which decays; and an amount in one place, which stays.
    let filling = walled(50, "1", "1", "0");
    let fine = |case: &Value, end: f64| {
        let time = json!({ "end": end, "method": "heun", "step": end / 131_072.0 });
        run(&with(case, time)).state
    };
    check(&filling, 0.1, &all, &fine(&filling, 0.1), 1.0);
    // The report's `constant` on a line, two years of it.
    let mut constant = layers();
    constant["materials"]["slow"]["diffusivity"] = json!(1);
    constant["boundaries"][1]["held"]["value"] = json!(1);
    check(&constant, 1.5, &stiff, &fine(&constant, 1.5), 1.0);
    let mut deposit = walled(50, "0", "0", "0");
    deposit["initial"] = json!([{ "value": 0 }, { "amount": 1, "at": [0.5] }]);
    let spread = fine(&deposit, 0.02);
    let peak = spread.iter().copied().fold(0.0, f64::max);
    check(&deposit, 0.02, &all, &spread, peak);
    let layers = layers();
    let fast = fine(&layers, 1.0);
    check(&layers, 1.0, &stiff, &fast, 1.0);
    let end = 1.25e4;
    let slow = with(
        &layers,
        json!({ "end": end, "method": "tr_bdf2", "step": end / 8000.0, "linear_tolerance": 1e-10 }),
    );
    check(&layers, end, &[Method::TrBdf2], &run(&slow).state, 1.0);
}

#[test]
fn nothing_is_lost_whatever_the_method() {
    let mut insulated = walled(40, "0", "0", "0");
    insulated["boundaries"] = json!([]);
    insulated["initial"] = json!([{ "value": "1 + sin(7*x)" }]);
    let held = layers();
    // Boxes of the coarse space round periodic axes, four to eight of them, of two materials.
    let round = |counts: [u32; 2]| {
        let [x, y] = counts.map(|n| f64::from(n) * 0.05);
        let layer = |from: f64, to: f64, name: &str| {
            json!({
                "shape": { "box": { "min": [0, from], "max": [x, to] } }, "material": name
            })
        };
        json!({
            "title": "round",
            "dimension": 2,
            "particles": {
                "spacing": 0.05, "fill": [layer(0.0, 0.4, "fast"), layer(0.4, y, "slow")]
            },
            "kernel": { "name": "cubic_spline", "support_ratio": 2 },
            "materials": { "fast": { "diffusivity": 1 }, "slow": { "diffusivity": 1e-4 } },
            "initial": [{ "value": "1 + sin(7*x)*y" }],
            "boundaries": [{ "periodic": { "axes": ["x", "y"] } }],
            "time": { "end": 1 }
        })
    };
    for counts in [[16, 20], [28, 32]] {
        for method in ["tr_bdf2", "steady"] {
            let mut time = json!({ "end": 50, "method": method });
            if method == "tr_bdf2" {
                time["step"] = json!(10);
            }
            let found = run(&with(&round(counts), time)).report;
            let drift = found.conserved.relative_drift.abs();
            assert!(drift < 1e-12, "{counts:?} {method}: {drift:e}");
            assert!(method != "steady" || found.field.max - found.field.min < 1e-6);
        }
    }
    let walls = walled(40, "2 + sin(t)", "1", "x");
    for method in ["heun", "rkl2", "tr_bdf2"] {
        for case in [&insulated, &held, &walls] {
            let found = run(&with(case, json!({ "end": 0.05, "method": method })));
            let drift = found.report.conserved.relative_drift.abs();
            assert!(drift < 1e-12, "{method}: {drift:e}");
        }
    }
    // Without the coarse space, what linear systems leave over is missing in the balance.
    let time = json!({ "end": 0.05, "method": "tr_bdf2", "preconditioner": "jacobi" });
    let drift = run(&with(&held, time)).report.conserved.relative_drift.abs();
    assert!(drift > 1e-9, "{drift:e}");
}

#[test]
fn what_cannot_be_done_is_an_error() {
    let line = walled(20, "0", "1", "x");
    let fails = |case: &Value, time: Value, words: &str| {
        let mut case = case.clone();
        case["time"] = time;
        let found = case::from_json("test", case, &[])
            .map_err(|error| error.to_string())
            .and_then(|scene| try_run(&scene).map(|run| run.report.method));
        let message = found.expect_err(words);
        assert!(message.contains(words), "{message}");
    };
    fails(&line, json!({ "end": 1, "method": "heun", "step": 0.1 }), "above the stability limit");
    let tight = json!({ "end": 1, "method": "rkl2", "tolerance": { "relative": 1e-14 } });
    fails(&line, tight, "less than f64 can give");
    let solved = json!({ "end": 1, "method": "tr_bdf2", "step": 0.1, "linear_tolerance": 1e-14 });
    fails(&line, solved, "time.linear_tolerance is 1.0e-14, less than f64 can give");
    let euler = json!({ "end": 1, "tolerance": { "relative": 1e-3 } });
    fails(&line, euler, "time.tolerance: not used: the method euler has no estimate");
    let both = json!({
        "end": 1, "method": "rkl2", "step": 0.1, "tolerance": { "relative": 1e-3 }
    });
    fails(&line, both, "time.step: not used: a tolerance is given");
    let none = json!({ "end": 1, "method": "rkl2", "tolerance": {} });
    fails(&line, none, "time.tolerance");
    let late = json!({ "end": 1, "method": "rkl2", "breaks": [0.5, 0.25] });
    fails(&line, late, "time.breaks[1]");
    let steady = json!({ "end": 1, "method": "steady" });
    fails(&walled(20, "sin(t)", "1", "x"), steady.clone(), "there is no steady state");
    let flux = |left: f64, right: f64| {
        let mut case = line.clone();
        let wall = |face: &str, flux: f64| json!({ "wall": { "faces": [face], "kind": { "flux": flux } } });
        case["boundaries"] = json!([wall("x_min", left), wall("x_max", right)]);
        case
    };
    fails(&flux(1.0, -0.5), steady.clone(), "there is no steady state: ");
    // Convection that reaches past the first particles.
    let mut skew = line.clone();
    skew["kernel"]["support_ratio"] = json!(3);
    skew["boundaries"][0]["wall"]["kind"] =
        json!({ "convection": { "coefficient": 1, "ambient": 0 } });
    fails(&skew, json!({ "end": 1, "method": "tr_bdf2" }), "unsymmetric");
    // Two bodies, of which one gains what the other loses.
    let mut apart = flux(1.0, -1.0);
    let body = |from: f64, to: f64| json!({ "shape": { "box": { "min": [from], "max": [to] } }, "material": "unit" });
    apart["particles"]["fill"] = json!([body(0.0, 0.4), body(0.6, 1.0)]);
    fails(&apart, steady.clone(), "there is no steady state: ");
    // Flows that cancel: a slope of -1 about the mean that was there.
    let found = run(&with(&flux(1.0, -1.0), steady));
    let exact: Vec<f64> = (0..20).map(|i| 1.0 - (f64::from(i) + 0.5) / 20.0).collect();
    assert!(distance(&found.state, &exact) < 1e-8, "{:?}", found.state);
}

/// A step of the implicit Euler method of `dt` (s) by conjugate gradients with the diagonal, until the
/// plain norm of the residual has fallen to `part` of itself.
fn solved_on_the_plain_residual(
    problem: &Problem,
    dt: f64,
    part: f64,
) -> Result<Vec<f64>, SolverError> {
    let mut b = CpuBackend::of(problem);
    let [mut x, mut r, mut z, mut p, mut q] =
        [b.vector()?, b.vector()?, b.vector()?, b.vector()?, b.vector()?];
    b.rate_into(0.0, &mut r)?;
    b.update(&mut r, dt, &[])?;
    let first = b.dot(&r, &r)?;
    let mut before = 1.0;
    for iteration in 0.. {
        if b.dot(&r, &r)? <= part * part * first {
            break;
        }
        b.divide(&r, 1.0, -dt, &mut z)?;
        let square = b.dot(&r, &z)?;
        b.update(&mut p, if iteration == 0 { 0.0 } else { square / before }, &[(1.0, &z)])?;
        b.apply(&p, 1.0, -dt, &mut q)?;
        let length = square / b.dot(&p, &q)?;
        b.update(&mut x, 1.0, &[(length, &p)])?;
        b.update(&mut r, 1.0, &[(-length, &q)])?;
        before = square;
    }
    b.add(&x)?;
    Ok(b.read()?.as_ref().to_vec())
}

#[test]
fn the_plain_residual_says_little_where_materials_differ_much() {
    let scene = with(&layers(), json!({ "end": 1, "method": "steady" }));
    // In series: 1 through the fast layer, down to 0 in the slow one.
    let resistance = [1.0, 1e6].map(|r: f64| r * 0.01);
    let jump = 0.5 * (resistance[0] + resistance[1]);
    let total = 49.0 * resistance[0] + jump + 49.0 * resistance[1];
    let down_to = |i: i32| match i {
        0..50 => f64::from(i) * resistance[0],
        _ => 49.0 * resistance[0] + jump + f64::from(i - 50) * resistance[1],
    };
    let exact: Vec<f64> = (0..100).map(|i| 1.0 - down_to(i) / total).collect();
    let right = distance(&run(&scene).state, &exact);
    assert!(right < 1e-8, "{right:e}");
    let solved =
        |part| solved_on_the_plain_residual(&scene.problem, 625.0, part).expect("it solves");
    let off = distance(&solved(1e-8), &solved(1e-15));
    assert!(off > 1e-4, "{off:e}");
}

#[test]
fn a_step_ends_where_something_jumps() {
    // A wall that is switched on at a third of the time.
    let mut case = walled(20, "0", "0", "0");
    case["boundaries"][0]["wall"]["kind"]["value"] = json!("step(t - 0.1)");
    let time = |breaks: Value| {
        let tolerance = json!({ "relative": 1e-4 });
        json!({ "end": 0.3, "method": "rkl2", "tolerance": tolerance, "breaks": breaks })
    };
    let found = run(&with(&case, time(json!([0.1]))));
    let constant = walled(20, "1", "0", "0");
    let exact = run(&with(&constant, json!({ "end": 0.2, "method": "rkl2", "step": 1e-4 }))).state;
    assert!(distance(&found.state, &exact) < 1e-3, "{:e}", distance(&found.state, &exact));
    let off = |breaks: Value| {
        let time = json!({ "end": 0.3, "method": "heun", "step": 0.001, "breaks": breaks });
        distance(&run(&with(&case, time)).state, &exact)
    };
    let [with_break, without] = [off(json!([0.1])), off(json!([]))];
    assert!(without > 5.0 * with_break, "{with_break:e} {without:e}");
}

#[test]
fn a_field_of_zeros_is_set_in_motion() {
    // A wall that starts with neither value nor slope.
    let case = walled(20, "t^2", "0", "0");
    let exact = run(&with(&case, json!({ "end": 0.3, "method": "heun", "step": 1e-5 }))).state;
    for method in ["rkl2", "tr_bdf2"] {
        let time = json!({ "end": 0.3, "method": method, "tolerance": { "relative": 1e-4 } });
        let off = distance(&run(&with(&case, time)).state, &exact);
        assert!(off < 3e-4 * 0.09, "{method}: {off:e}");
    }
    let tight = json!({ "end": 0.3, "method": "rkl2", "tolerance": { "relative": 1e-14 } });
    assert!(try_run(&with(&case, tight)).is_err_and(|message| message.contains("can give")));
}

#[test]
fn bodies_where_nothing_holds_a_value_keep_what_they_have() {
    // A line between walls, a body apart from it, and a particle alone.
    let mut case = walled(40, "2", "1", "x^2");
    let body = |from: f64, to: f64| json!({ "shape": { "box": { "min": [from], "max": [to] } }, "material": "unit" });
    case["particles"]["fill"] =
        json!([body(0.0, 0.25), body(0.35, 0.6), body(0.7, 0.725), body(0.8, 1.0)]);
    for preconditioner in ["jacobi", "two_level"] {
        let time = json!({ "end": 1, "method": "steady", "preconditioner": preconditioner });
        let scene = with(&case, time);
        let state = run(&scene).state;
        let mean = |values: &[f64]| values[10..20].iter().sum::<f64>() / 10.0;
        let apart = mean(&scene.problem.initial);
        assert!(distance(&state[..10], &[2.0; 10]) < 1e-7, "{preconditioner}: {state:?}");
        assert!(distance(&state[10..20], &[apart; 10]) < 1e-7, "{preconditioner}: {state:?}");
        assert!((state[20] - scene.problem.initial[20]).abs() < 1e-12);
        assert!(distance(&state[21..], &[1.0; 8]) < 1e-7, "{preconditioner}: {state:?}");
    }
}

#[test]
fn auto_takes_what_the_stiffness_asks_for() {
    let taken = |case: &Value, end: f64| {
        let found = run(&with(case, json!({ "end": end, "method": "auto" })));
        let why = found.report.why_method.expect("it says why");
        assert!(why.contains("stiffness"), "{why}");
        found.report.method
    };
    let line = walled(20, "0", "1", "0");
    assert_eq!(taken(&line, 0.01), "heun");
    assert_eq!(taken(&layers(), 0.05), "rkl2");
    assert_eq!(taken(&layers(), 1.25e4), "tr_bdf2");
}
