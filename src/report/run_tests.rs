use serde_json::{Value, json};

use super::*;

/// A report with a value in every place.
pub(crate) fn example() -> RunReport {
    RunReport {
        report_version: REPORT_VERSION,
        case: "deposit".into(),
        title: "Instant deposit in a box".into(),
        diffusph_version: DIFFUSPH_VERSION.into(),
        backend: "gpu".into(),
        adapter: Some("A fast one".into()),
        precision: "compensated".into(),
        why_precision: Some("in f32 it would stand still".into()),
        dimension: 3,
        particles: 1_000_000,
        path: "lattice".into(),
        method: "euler".into(),
        why_method: None,
        steps: 2160,
        steps_refused: 0,
        dt_largest: 29_200.0,
        operator_applications: 2160,
        dt: 29_200.0,
        dt_limit: 32_000.0,
        simulated_s: 63_072_000.0,
        wall_s: WallTimes { setup: 0.123, solve: 1.08, output: 0.56 },
        updates_per_s: 2.0e9,
        memory_bytes: 24_000_000,
        field: FieldRange { min: 0.0, max: 0.1301, mean: 0.008 },
        conserved: Conserved::new(1000.0, 1010.0, 10.0, 0.0),
        front: Some(Front { position: 0.25, liquid_volume: 1.5, exact: Some(0.24) }),
        density: Range { min: 999.5, max: 1000.5 },
        error: Some(ErrorReport::new("point_source", Norms::new(&[1.1], &[1.0], &[2.0]))),
        probes: vec![ProbeReport {
            name: "centre".into(),
            at: vec![25.25; 3],
            time: 63_072_000.0,
            value: 0.13,
            exact: Some(0.1301),
        }],
        left_out: vec![LeftOut {
            what: "neighbour list".into(),
            why: "full lattice at rest".into(),
            bytes_saved: 128_000_000,
        }],
        warnings: vec!["the step was shortened to end on time".into()],
    }
}

#[test]
fn the_names_are_those_that_readers_rely_on() {
    let json = serde_json::to_value(example()).unwrap();
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(
        keys(&json).join(" "),
        "report_version case title diffusph_version backend adapter precision why_precision dimension \
         particles path method why_method steps steps_refused operator_applications dt dt_largest dt_limit simulated_s wall_s updates_per_s \
         memory_bytes field conserved front density error probes left_out warnings"
    );
    for (place, names) in [
        ("/wall_s", "setup solve output"),
        ("/field", "min max mean"),
        ("/conserved", "initial final boundary_exchange relative_drift"),
        ("/density", "min max"),
        ("/error", "against l1 l2 linf l2_relative mean_square root_mean_square"),
        ("/probes/0", "name at time value exact"),
        ("/left_out/0", "what why bytes_saved"),
    ] {
        assert_eq!(keys(json.pointer(place).unwrap()).join(" "), names, "{place}");
    }
}

#[test]
fn reads_back_as_it_was() {
    let text = serde_json::to_string_pretty(&example()).unwrap();
    assert_eq!(serde_json::from_str::<RunReport>(&text).unwrap(), example());
    let other = RunReport { dt: 29_200.000_000_000_004, ..example() };
    assert_ne!(serde_json::from_str::<RunReport>(&text).unwrap(), other);
}

#[test]
fn what_is_not_finite_is_null() {
    let mut report = example();
    report.dt_limit = f64::INFINITY;
    report.field = FieldRange::of(&[1.0, f64::NAN]);
    report.conserved = Conserved::new(1.0, f64::NEG_INFINITY, f64::NAN, 1.0);
    report.probes[0].exact = Some(f64::NAN);
    report.probes[0].at[1] = f64::NAN;
    report.error = Some(ErrorReport::new("x", Norms::new(&[f64::NAN], &[1.0], &[1.0])));
    let json = serde_json::to_value(&report).unwrap();
    for place in [
        "/dt_limit",
        "/field/min",
        "/field/max",
        "/field/mean",
        "/conserved/final",
        "/conserved/boundary_exchange",
        "/conserved/relative_drift",
        "/error/linf",
        "/error/root_mean_square",
        "/probes/0/exact",
        "/probes/0/at/1",
    ] {
        assert_eq!(json.pointer(place), Some(&Value::Null), "{place}");
    }
    assert_eq!(json["conserved"]["initial"], json!(1.0));
    report.probes[0].at[1] = 0.0;
    let back: RunReport = serde_json::from_value(serde_json::to_value(&report).unwrap()).unwrap();
    assert!(back.dt_limit.is_nan());
}

#[test]
fn drift_is_what_the_exchange_does_not_explain() {
    assert_eq!(Conserved::new(1000.0, 1010.0, 10.0, 0.0).relative_drift, 0.0);
    assert_eq!(Conserved::new(1000.0, 1000.5, 0.0, 0.0).relative_drift, 0.5 / 1000.5);
    assert_eq!(Conserved::new(0.0, 8.0, 10.0, 0.0).relative_drift, -0.2, "scaled by the largest");
    assert_eq!(Conserved::new(0.0, 0.0, 0.0, 0.0).relative_drift, 0.0);
    assert_eq!(Conserved::new(0.0, 1e-16, 0.0, 1.0).relative_drift, 1e-16, "a signed field");
    assert!(Conserved::new(1.0, 1.0, f64::NAN, 1.0).relative_drift.is_nan());
}

#[test]
fn ranges_cover_all_values() {
    let FieldRange { min, max, mean } = FieldRange::of(&[2.0, -1.0, 5.0]);
    assert_eq!((min, max, mean), (-1.0, 5.0, 2.0));
    assert_eq!(Range::of(&[3.0]), Range { min: 3.0, max: 3.0 });
    assert!(Range::of(&[]).min.is_nan() && FieldRange::of(&[]).mean.is_nan());
    assert!(Range::of(&[f64::NAN, 1.0]).max.is_nan());
}

#[test]
fn the_summary_names_what_matters() {
    let text = example().summary();
    for part in [
        "Instant deposit in a box",
        "1 000 000 particles",
        "A fast one",
        "compensated",
        "63 072 000 s (2 years)",
        "2 160 steps of 29200 s",
        "91.25 % of the limit 32000 s",
        "8.75 % margin",
        "setup 123 ms, solve 1.08 s, output 560 ms",
        "2e9",
        "24 MB",
        "L2 relative",
        "(123)",
        "0.1",
        "999.5 to 1000.5",
        "warning",
        "point_source",
        "centre",
        "128 MB",
    ] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
    assert!(text.lines().all(|line| line.len() <= 100), "{text}");
}

#[test]
fn the_summary_shows_what_is_wrong() {
    let mut report = example();
    report.dt = 40_000.0;
    report.field = FieldRange::of(&[f64::NAN]);
    report.error = None;
    report.adapter = None;
    let text = report.summary();
    assert!(text.contains("ABOVE the limit"), "{text}");
    assert!(text.contains("not finite"), "{text}");
    assert!(!text.contains("L2 relative") && !text.contains("A fast one"), "{text}");
    report.dt_limit = f64::INFINITY;
    assert!(!report.summary().contains("limit"), "no limit, no margin");
}
