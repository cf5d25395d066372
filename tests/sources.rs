//! Sources inside the body: exact solutions, orders, balances, every method, bad input.

use std::ops::ControlFlow;

use diffusph::case::{self, Override, Scene};
use diffusph::model::integrator::Method;
use diffusph::report::run::RunReport;
use diffusph::solver::{Machine, PathWish};
use diffusph::study::{self, RunOptions};
use serde_json::{Value, json};

/// A line of `n` particles with insulated ends, with these sources.
fn line(n: u32, sources: Value, initial: &str, time: Value) -> Value {
    json!({
        "title": "line",
        "dimension": 1,
        "particles": {
            "spacing": 1.0 / f64::from(n),
            "fill": [{ "shape": { "box": { "min": [0], "max": [1] } }, "material": "unit" }]
        },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "materials": { "unit": { "diffusivity": 1 } },
        "initial": [{ "value": initial }],
        "boundaries": [{ "wall": { "faces": ["x_min", "x_max"], "kind": "insulated" } }],
        "sources": sources,
        "time": time
    })
}

fn load(case: &Value, overrides: &[&str]) -> Result<Scene, String> {
    let overrides: Vec<Override> =
        overrides.iter().map(|text| Override::parse(text).expect("it is an override")).collect();
    case::from_json("test", case.clone(), &overrides).map_err(|error| error.to_string())
}

fn try_run(scene: &Scene, path: PathWish) -> Result<RunReport, String> {
    let options = RunOptions { path, ..RunOptions::new(&Machine::Cpu) };
    let outcome = study::run(scene, &options, &mut |_| ControlFlow::Continue(()));
    let outcome = outcome.map_err(|error| error.to_string())?;
    outcome.stopped.map_or(Ok(outcome.report), |error| Err(error.to_string()))
}

fn run(case: &Value) -> RunReport {
    let scene = load(case, &[]).unwrap_or_else(|error| panic!("{error}"));
    try_run(&scene, PathWish::Auto).unwrap_or_else(|error| panic!("{error}"))
}

fn linf(report: &RunReport) -> f64 {
    report.error.as_ref().expect("an exact solution").linf
}

/// log2 of the ratios of consecutive errors.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

#[test]
fn a_uniform_body_follows_its_equation_with_every_method() {
    // dC/dt = 30 - 4 C from 2: what conducts has nothing to do.
    let sources = json!([{ "rate": 30 }, { "linear": -5 }, { "linear": 1 }]);
    let exact = json!({ "name": "expression", "value": "7.5 - 5.5*exp(-4*t)" });
    let at = |method: Method, steps: u32| {
        let mut time = json!({ "end": 0.5, "method": method.name() });
        if method != Method::Steady {
            time["step"] = json!(0.5 / f64::from(steps));
        }
        if method == Method::TrBdf2 {
            time["linear_tolerance"] = json!(1e-12);
        }
        let mut case = line(8, sources.clone(), "2", time);
        case["exact"] = exact.clone();
        case
    };
    for method in Method::ALL {
        let expected = if method == Method::Euler { 1.0 } else { 2.0 };
        if method == Method::Steady {
            let mut case = at(method, 1);
            case["exact"] = json!({ "name": "uniform", "value": 7.5 });
            assert!(linf(&run(&case)) < 1e-9);
            continue;
        }
        let reports = [128, 256, 512, 1024].map(|steps| run(&at(method, steps)));
        let found = orders(&reports.each_ref().map(linf));
        let is_right = found.iter().all(|order| (order - expected).abs() < 0.1);
        assert!(is_right, "{}: {found:?}", method.name());
        for report in reports {
            let drift = report.conserved.relative_drift;
            assert!(drift < 1e-12, "{}: {drift:e}", method.name());
        }
    }
    // What is left out of the matrix is noticed.
    let mut wrong = at(Method::Rkl2, 512);
    wrong["sources"] = json!([{ "rate": 30 }, { "linear": -5 }]);
    assert!(linf(&run(&wrong)) > 0.1);
}

#[test]
fn a_source_that_moves_in_time_is_followed_at_second_order() {
    // C = cos(pi x) (1 + sin 5t), so that the source is dC/dt - D C'' + 2 C with what is damped.
    let sources = json!([{
        "rate": "cos(pi*x)*(5*cos(5*t) + (pi^2 + 2)*(1 + sin(5*t)))", "linear": -2
    }]);
    for path in [PathWish::Auto, PathWish::List] {
        let error = |n: u32| {
            let time = json!({ "end": 0.4, "method": "heun", "step": 0.02 / f64::from(n * n) });
            let mut case = line(n, sources.clone(), "cos(pi*x)", time);
            case["exact"] = json!({ "name": "expression", "value": "cos(pi*x)*(1 + sin(5*t))" });
            let scene = load(&case, &[]).expect("a case");
            linf(&try_run(&scene, path).expect("a run"))
        };
        let found = orders(&[10, 20, 40, 80].map(error));
        assert!(found.iter().all(|order| (order - 2.0).abs() < 0.05), "{path:?}: {found:?}");
    }
}

#[test]
fn the_shipped_fin_is_second_order_with_every_method() {
    let at = |spacing: f64, more: &[&str]| {
        let spacing = format!("particles.spacing={spacing}");
        let keys: Vec<Override> = ["output={}", "probes=[]", &spacing]
            .iter()
            .chain(more)
            .map(|text| Override::parse(text).expect("it is an override"))
            .collect();
        let scene = case::load("fin", &keys).unwrap_or_else(|error| panic!("{error}"));
        try_run(&scene, PathWish::Auto).unwrap_or_else(|error| panic!("{error}"))
    };
    let l2 = |report: RunReport| report.error.expect("an exact solution").l2;
    let found = orders(&[0.01, 0.005, 0.0025, 0.00125].map(|spacing| l2(at(spacing, &[]))));
    assert!(found.iter().all(|order| (order - 2.0).abs() < 0.05), "{found:?}");
    let by_euler = linf(&at(0.002, &[]));
    for method in ["steady", "tr_bdf2", "rkl2", "auto"] {
        let key = format!("time.method={method}");
        let other = linf(&at(0.002, &[&key]));
        assert!((other / by_euler - 1.0).abs() < 0.05, "{method}: {other:e} {by_euler:e}");
    }
}

#[test]
fn fast_losses_bound_explicit_steps_and_not_implicit_ones() {
    let time = |method: &str, step: Option<f64>| {
        let mut time = json!({ "end": 1, "method": method });
        if let Some(step) = step {
            time["step"] = json!(step);
        }
        time
    };
    let sources = json!([{ "rate": "1e6*(1 + x)", "linear": -1e6 }]);
    let case = |time: Value| {
        let mut case = line(10, sources.clone(), "0", time);
        case["exact"] = json!({ "name": "expression", "value": "1 + x" });
        case
    };
    // Of 1e6 + 2 D/dx2, the safe bound; 2 over it is where Euler grows.
    let dt = 1.0 / (1e6 + 200.0);
    let mut short = case(json!({ "end": 1e-3 }));
    let report = run(&short);
    assert!((report.dt_limit / dt - 1.0).abs() < 1e-9, "{}", report.dt_limit);
    assert!(report.field.max <= 2.0 && report.field.min >= 0.0);
    short["time"]["step"] = json!(2.2 * dt);
    let refused = try_run(&load(&short, &[]).expect("a case"), PathWish::Auto);
    assert!(refused.is_err_and(|error| error.contains("above the stability limit")));
    let report = run(&case(time("tr_bdf2", Some(0.1))));
    assert!(linf(&report) < 1e-3, "{:e}", linf(&report));
}

#[test]
fn what_holds_a_body_up_decides_whether_it_has_a_steady_state() {
    let steady = || json!({ "end": 1, "method": "steady" });
    let run = |sources: Value| {
        let case = line(10, sources, "3", steady());
        try_run(&load(&case, &[]).expect("a case"), PathWish::Auto)
    };
    let held = run(json!([{ "rate": 8, "linear": -2 }])).expect("a steady state");
    assert!((held.field.max - 4.0).abs() < 1e-8 && (held.field.min - 4.0).abs() < 1e-8);
    let balanced = run(json!([{ "rate": "x - 0.5" }])).expect("sources that cancel");
    assert!((balanced.field.mean - 3.0).abs() < 1e-8);
    let errors = [
        (json!([{ "rate": 1 }]), "no steady state"),
        (json!([{ "rate": "sin(t)" }]), "changes in time"),
        (json!([{ "linear": 50 }]), "did not converge"),
    ];
    for (sources, message) in errors {
        let found = run(sources.clone()).expect_err("no steady state");
        assert!(found.contains(message), "{sources}: {found}");
    }
}

#[test]
fn growth_is_followed_and_warned_of() {
    let mut case = line(8, json!([{ "linear": 3 }]), "1", json!({ "end": 1, "method": "rkl2" }));
    case["exact"] = json!({ "name": "expression", "value": "exp(3*t)" });
    let report = run(&case);
    // What a step leaves grows with the field: the tolerance of 1e-4 is met to a small factor.
    assert!(linf(&report) < 5e-4 * 3_f64.exp(), "{:e}", linf(&report));
    let warned = report.warnings.iter().any(|warning| warning.contains("sources[0].linear: up to"));
    assert!(warned, "{:?}", report.warnings);
}

#[test]
fn bad_sources_are_refused_by_their_path() {
    let time = || json!({ "end": 1 });
    let nowhere = json!({ "box": { "min": [3], "max": [4] } });
    let faults = [
        (json!([{}]), "sources[0].rate: missing key"),
        (json!([{ "where": nowhere }]), "sources[0].rate: missing key"),
        (json!([{ "rate": 1, "where": nowhere }]), "sources[0].where: selects no particle"),
        (json!([{ "rate": 1 }, { "rates": 1 }]), "sources[1].rates: unknown key; did you mean"),
        (
            json!([{ "rate": "1/(x - 0.5)", "where": { "sphere": { "center": [0.55], "radius": 1 } } }, { "rate": "ln(x - 2)" }]),
            "sources[1].rate",
        ),
        (json!([{ "linear": "t" }]), "sources[0].linear: \"t\""),
        (json!([{ "rate": true }]), "sources[0].rate"),
    ];
    for (sources, message) in faults {
        let found = load(&line(10, sources.clone(), "0", time()), &[]);
        let found = found.expect_err("a bad source");
        assert!(found.starts_with(message), "{sources}: {found}");
    }
    let mut named = line(10, json!([{ "rate": 1 }]), "0", time());
    named["exact"] = json!({ "name": "slab", "axis": "x", "initial": 0 });
    let found = load(&named, &[]).expect_err("a solution without sources");
    assert!(found.contains("exact: the solution slab knows no sources"), "{found}");
}
