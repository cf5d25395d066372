//! Conductivities that depend on temperature: steady profiles, every method and path, and where they end.

#[expect(dead_code, reason = "these scenes are no shipped cases")]
#[path = "cases/support.rs"]
mod cases;
#[path = "melting/support.rs"]
mod support;

use diffusph::solver::{Machine, PathWish, Precision, SolverError};
use serde_json::{Value, json};

use cases::load;
use support::{on_gpu, outcome, run, run_on, steady};

/// A slab of conductivity 5 (1 + (T - 300) / 100) between 300 and 400 K, as table or expression.
fn slab(conductivity: &Value, support_ratio: f64) -> Value {
    json!({
        "title": "k(T)", "dimension": 1,
        "particles": { "spacing": 0.05,
            "fill": [{ "shape": { "box": { "min": [0], "max": [1] } }, "material": "m" }] },
        "kernel": { "name": "cubic_spline", "support_ratio": support_ratio },
        "materials": { "m": { "conductivity": conductivity, "density": 1000, "heat_capacity": 1 } },
        "initial": [{ "value": 300 }],
        "boundaries": [
            { "wall": { "faces": ["x_min"], "kind": { "value": 300 } } },
            { "wall": { "faces": ["x_max"], "kind": { "value": 400 } } }
        ],
        "exact": { "name": "expression", "value": "200 + 100*sqrt(1 + 3*x)" },
        "time": { "end": 5000, "method": "tr_bdf2", "tolerance": { "relative": 1e-6 } }
    })
}

#[test]
fn a_steady_profile_of_a_conductivity_of_temperature_is_exact() {
    let table = json!([[300, 5], [400, 10]]);
    for (conductivity, most) in [(table, 1e-6), (json!("5*(1 + (T - 300)/100)"), 1e-6)] {
        for support_ratio in [2.0, 3.0] {
            for path in [PathWish::Lattice, PathWish::List] {
                let scene = load(&slab(&conductivity, support_ratio)).expect("a case");
                let (report, _) = run_on(&scene, &Machine::Cpu, path);
                let error = report.error.expect("exact").linf;
                assert!(error < most, "{conductivity}, {support_ratio}, {path:?}: {error:e}");
            }
        }
    }
    // The wrong law is noticed.
    let scene = load(&slab(&json!([[300, 5], [400, 9.9]]), 2.0)).expect("a case");
    assert!(run(&scene).0.error.expect("exact").linf > 0.01);
}

#[test]
fn the_steady_state_of_a_conductivity_of_temperature_is_one_linear_system() {
    let scene = steady(slab(&json!([[300, 5], [400, 10]]), 2.0));
    for (machine, paths, most) in [
        (Machine::Cpu, vec![PathWish::Lattice, PathWish::List], 1e-9),
        (on_gpu(Precision::F64), vec![PathWish::Lattice, PathWish::List], 1e-9),
        (on_gpu(Precision::Compensated), vec![PathWish::MatrixFree], 1e-2),
    ] {
        let mut case = slab(&json!([[300, 5], [400, 10]]), 2.0);
        case["time"] = json!({ "end": 1, "method": "steady" });
        let scene = match machine.kind().precision() {
            Precision::F64 => scene.clone(),
            _ => load(&case).expect("a case"),
        };
        for path in paths {
            let (report, _) = run_on(&scene, &machine, path);
            let error = report.error.expect("exact").linf;
            assert!(error < most, "{path:?}: {error:e}");
            assert!(report.operator_applications < 100, "{}", report.operator_applications);
        }
    }
    // What is known of an expression ends, here at 200 K.
    let scene = steady(slab(&json!("5*(1 + (T - 300)/100)"), 2.0));
    for machine in [Machine::Cpu, on_gpu(Precision::F64)] {
        let error = run_on(&scene, &machine, PathWish::Auto).0.error.expect("exact").linf;
        assert!(error < 1e-5, "{error:e}");
    }
    let wrong = steady(slab(&json!([[300, 5], [400, 9.9]]), 2.0));
    assert!(run(&wrong).0.error.expect("exact").linf > 0.01);
}

#[test]
fn far_longer_steps_than_explicit_ones_still_converge() {
    for table in [json!([[300, 100], [400, 100.001]]), json!([[300, 100], [400, 5]])] {
        let mut case = slab(&table, 2.0);
        case.as_object_mut().expect("an object").remove("exact");
        // Up to 8e4 times what explicit steps may take.
        case["time"] = json!({ "end": 100, "method": "tr_bdf2", "step": 10 });
        let (report, _) = run(&load(&case).expect("a case"));
        assert!(report.operator_applications < 10_000, "{}", report.operator_applications);
        // Flows of a step are up to 1e5 times what stays of them.
        let drift = report.conserved.relative_drift.abs();
        assert!(drift < 1e-10, "{drift:e}");
    }
}

#[test]
fn a_body_that_heats_up_leaves_the_temperatures_that_the_case_names() {
    let mut case = slab(&json!("5*(1 + (T - 300)/1000)"), 2.0);
    case.as_object_mut().expect("an object").remove("exact");
    case["boundaries"] = json!([{ "wall": { "faces": ["x_min"], "kind": { "flux": 2e4 } } }]);
    case["time"] = json!({ "end": 20, "method": "euler" });
    let (report, _) = run(&load(&case).expect("a case"));
    assert!(report.field.max > 700.0, "{:?}", report.field);
}

#[test]
fn on_a_body_with_holes_an_expression_goes_with_every_method() {
    let shape = json!({ "difference": {
        "of": { "box": { "min": [0, 0], "max": [1, 1] } },
        "minus": [{ "sphere": { "center": [0.5, 0.5], "radius": 0.3 } }]
    } });
    for method in ["euler", "rkl2", "tr_bdf2"] {
        let mut case = slab(&json!("5*(1 + (T - 300)/1000)"), 2.0);
        case.as_object_mut().expect("an object").remove("exact");
        case["dimension"] = json!(2);
        case["particles"]["fill"][0]["shape"] = shape.clone();
        case["time"] = json!({ "end": 20, "method": method });
        let scene = load(&case).expect("a case");
        let (report, _) = run_on(&scene, &Machine::Cpu, PathWish::Lattice);
        assert_eq!(report.path, "mixed");
        assert!(report.field.max < 400.0 && report.field.min >= 299.999, "{:?}", report.field);
        assert!(report.conserved.relative_drift.abs() < 1e-12);
    }
}

#[test]
fn a_conductivity_of_temperature_and_another_material_share_a_flow() {
    // Where they meet u = T - 300 has 3 (200 - u) / 0.4 = 10 (u + u^2 / 200) / 0.6.
    let u = 100.0 * ((1.45_f64 * 1.45 + 1.8).sqrt() - 1.45);
    let flow = 3.0 * (200.0 - u) / 0.4;
    assert!((10.0 * (u + u * u / 200.0) / 0.6 / flow - 1.0).abs() < 1e-12, "{u}");
    let error = |spacing: f64, conductivity: Value| {
        let bar = |from: f64, to: f64, material: &str| json!({ "shape": { "box": { "min": [from], "max": [to] } }, "material": material });
        let right = format!("200 + 100*sqrt(1 + 0.02*{flow}*(1 - x)/10)");
        let scene = load(&json!({
            "title": "two", "dimension": 1,
            "particles": { "spacing": spacing, "fill": [bar(0.0, 0.4, "left"), bar(0.4, 1.0, "right")] },
            "kernel": { "name": "cubic_spline", "support_ratio": 2 },
            "materials": {
                "left": { "conductivity": 3, "density": 1000, "heat_capacity": 1 },
                "right": { "conductivity": conductivity, "density": 1000, "heat_capacity": 1 }
            },
            "initial": [{ "value": 300 }],
            "boundaries": [
                { "wall": { "faces": ["x_min"], "kind": { "value": 500 } } },
                { "wall": { "faces": ["x_max"], "kind": { "value": 300 } } }
            ],
            "exact": { "name": "expression",
                "value": format!("(1 - step(x - 0.4))*(500 - {flow}*x/3) + step(x - 0.4)*({right})") },
            "time": { "end": 5000, "method": "tr_bdf2", "tolerance": { "relative": 1e-7 } }
        }));
        run(&scene.unwrap_or_else(|error| panic!("{error}"))).0.error.expect("exact").linf
    };
    let table = json!([[300, 10], [500, 30]]);
    let errors = [0.05, 0.025, 0.0125].map(|spacing| error(spacing, table.clone()));
    assert!(
        errors[0] < 0.5 && errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1],
        "{errors:?}"
    );
    assert!(error(0.05, json!([[300, 10], [500, 27]])) > 1.0, "another law is noticed");
}

#[test]
fn a_conductivity_that_ends_is_named_with_the_temperature_and_the_particle() {
    let mut case = slab(&json!("2 - T/500"), 2.0);
    case.as_object_mut().expect("an object").remove("exact");
    case["sources"] = json!([{ "rate": 1e5 }]);
    for method in ["euler", "rkl2", "tr_bdf2", "steady"] {
        case["time"] = json!({ "end": 100, "method": method });
        let scene = load(&case).expect("a case");
        let stopped = outcome(&scene, &Machine::Cpu, PathWish::Auto).stopped;
        let Some(SolverError::ConductivityUnknown {
            temperature, particle, material, limits, ..
        }) = &stopped
        else {
            panic!("{stopped:?}");
        };
        assert!(*temperature > 0.99 * limits[1] && limits[1] <= 1000.0);
        assert!(material == "m" && *particle < 20);
        let text = stopped.expect("it stopped").to_string();
        assert!(text.contains("reached T = ") && text.contains("particle"), "{text}");
        assert!(!text.contains("  "), "{text}");
    }
}
