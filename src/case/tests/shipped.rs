//! The shipped cases, and the schema that they name.

use glam::DVec3;
use serde_json::Value;

use crate::case::{Scene, from_json, load, schema, shipped};
use crate::exact::Solution;
use crate::model::{Correction, StepChoice};

const YEAR: f64 = 31_536_000.0;

fn file(path: &str) -> Value {
    let path = format!("{}/cases/{path}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("the file is there");
    serde_json::from_str(&text).expect("valid JSON")
}

fn scene(name: &str) -> Scene {
    load(name, &[]).expect(name)
}

#[test]
fn the_schema_file_is_current() {
    let expected = schema();
    assert_eq!(
        file("schema/case.schema.json"),
        expected,
        "run: diffusph schema > cases/schema/case.schema.json"
    );
}

/// The kind of the shape of the first fill.
fn shape(case: &Value) -> String {
    let shape = case.pointer("/particles/fill/0/shape").and_then(Value::as_object).expect("there");
    shape.keys().next().expect("of some kind").clone()
}

#[test]
fn shipped_cases_satisfy_the_schema() {
    let validator = jsonschema::validator_for(&schema()).expect("a valid schema");
    for (name, _) in shipped() {
        let case = file(&format!("{name}.json"));
        assert!(validator.is_valid(&case), "{name}: {:?}", validator.validate(&case));
        assert_eq!(case["$schema"], "schema/case.schema.json", "{name}");
        for (pointer, key, wrong) in [
            ("", "titel", Value::from("x")),
            ("/kernel", "name", "cubic".into()),
            ("/particles", "spacing", true.into()),
            ("/time", "stp", 1.into()),
            (&format!("/particles/fill/0/shape/{}", shape(&case)), "middle", 1.into()),
        ] {
            let mut mutated = case.clone();
            mutated.pointer_mut(pointer).expect("there")[key] = wrong;
            assert!(!validator.is_valid(&mutated), "{name}: {pointer}/{key}");
        }
        for (pointer, key) in [
            ("/exact", "sparation"),
            ("/initial/0", "at"),
            ("/boundaries/0/wall", "fces"),
            ("/boundaries/0/surface", "off"),
        ] {
            let mut mutated = case.clone();
            let Some(target) = mutated.pointer_mut(pointer) else {
                continue;
            };
            target[key] = 1.into();
            assert!(!validator.is_valid(&mutated), "{name}: {pointer}/{key}");
        }
    }
}

#[test]
fn every_shipped_case_loads_and_repeats_from_its_resolved_form() {
    let cases = shipped();
    let names: Vec<&str> = cases.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "affine",
            "affine_column",
            "annulus",
            "annulus_steady",
            "constant",
            "constant_column",
            "contact",
            "cooling_plate",
            "density",
            "fin",
            "flux_half_space",
            "flux_plate",
            "freezing_pipe",
            "gaussian",
            "gaussian_small",
            "heated_plate",
            "hot_inclusion",
            "laser_track",
            "melting_rod",
            "patches",
            "rod",
            "sphere_convection",
            "sphere_cooling",
            "square",
            "swinging_bar"
        ]
    );
    for (name, title) in &cases {
        let first = scene(name);
        assert_eq!(&first.title, title);
        assert!(first.warnings.is_empty(), "{name}: {:?}", first.warnings);
        let second = from_json(name, first.resolved.clone(), &[]).expect(name);
        assert_eq!(first.resolved, second.resolved, "{name}");
        assert_eq!(first.problem.initial, second.problem.initial, "{name}");
        assert_eq!(first.problem.held, second.problem.held, "{name}");
        assert_eq!(first.problem.time, second.problem.time, "{name}");
        assert_eq!(first.problem.probes, second.problem.probes, "{name}");
        assert_eq!(first.fields, second.fields, "{name}");
        assert_eq!(format!("{:?}", first.exact), format!("{:?}", second.exact), "{name}");
    }
}

#[test]
fn layers_are_held_on_either_side() {
    for (name, count, values) in [
        ("constant", 1_000_000, [1000.0, 1000.0]),
        ("affine", 1_000_000, [104.5, 995.5]),
        ("constant_column", 1600, [1000.0, 1000.0]),
        ("affine_column", 1600, [104.5, 995.5]),
    ] {
        let scene = scene(name);
        let problem = &scene.problem;
        assert_eq!(problem.particles.len(), count, "{name}");
        assert_eq!(problem.held.len(), count / 50, "{name}");
        assert_eq!(problem.domain.periodic, [false, true, true], "{name}");
        for (particle, (&x, &value)) in
            problem.particles.position.iter().zip(&problem.initial).enumerate()
        {
            let held = problem.held.binary_search(&(particle as u32)).is_ok();
            assert_eq!(held, x.x == 0.25 || x.x == 49.75, "{name} {x}");
            let expected = match (held, x.x < 25.0) {
                (false, _) => 0.0,
                (true, left) => values[usize::from(!left)],
            };
            assert_eq!(value, expected, "{name} {x}");
            if held {
                assert_eq!(scene.exact.as_ref().expect(name).at(x, 0.0), value, "{name}");
            }
        }
        assert_eq!(problem.time.step, StepChoice::Given(225.0));
        assert_eq!(problem.time.end / 225.0, 280_320.0);
        assert_eq!(problem.correction, Correction::None);
        assert_eq!(problem.materials[0].conductivity, 1875.0 / YEAR);
    }
}

#[test]
fn deposits_lie_on_the_eight_central_particles() {
    for (name, count, value, steps) in
        [("gaussian", 1_000_000, 1000.0, 2160.0), ("gaussian_small", 13_824, 15.625, 135.0)]
    {
        let scene = scene(name);
        let problem = &scene.problem;
        assert_eq!(problem.particles.len(), count, "{name}");
        let filled: Vec<f64> = problem.initial.iter().copied().filter(|v| *v != 0.0).collect();
        assert_eq!(filled, [value; 8], "{name}");
        assert!(problem.held.is_empty());
        let StepChoice::Given(step) = problem.time.step else { panic!("{name}") };
        assert_eq!(problem.time.end / step, steps, "{name}");
        assert_eq!(problem.probes[0].at, scene.problem.domain.max / 2.0 + problem.spacing / 2.0);
        let Some(Solution::MassesInBox(masses)) = &scene.exact else { panic!("{name}") };
        assert_eq!((masses.amount, masses.separation), (1000.0, problem.spacing));
    }
    let exact = scene("gaussian").exact.expect("exact");
    let found = exact.at(DVec3::splat(25.25), 2.0 * YEAR);
    assert!((found - 0.13619051).abs() < 5e-9, "{found}");
}
