//! Exact solutions with a source, layers or a phase change, and what they take from the scene.

use glam::DVec3;
use serde_json::{Value, json};

use super::base;
use crate::case::from_json;
use crate::exact::Solution;

/// The base case with this solution and these changes, of whole sections.
fn with(exact: &Value, changes: &[(&str, Value)]) -> Result<Solution, String> {
    let mut case = base();
    case["exact"] = exact.clone();
    for (section, json) in changes {
        case[section] = json.clone();
    }
    let scene = from_json("base", case, &[]).map_err(|error| error.to_string())?;
    Ok(scene.exact.expect("a solution"))
}

/// `json` with `value` at `pointer`, or without it where there is none.
fn changed(json: &Value, pointer: &str, value: &Value) -> Value {
    let mut json = json.clone();
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = json.pointer_mut(parent).expect("a parent").as_object_mut().expect("an object");
    match value {
        Value::Null => parent.remove(key),
        value => parent.insert(key.to_owned(), value.clone()),
    };
    json
}

fn refused(exact: &Value, changes: &[(&str, Value)], expected: &str) {
    let error = with(exact, changes).expect_err(expected);
    assert!(error.starts_with(expected), "{exact}\n  {error}\n  {expected}");
}

fn neumann() -> Value {
    json!({ "name": "neumann", "axis": "x", "at": 0, "initial": 300, "wall": 500,
        "melting_temperature": 400, "latent_heat": "19300*63.7e3",
        "solid": { "conductivity": "1.28e-4*19300*129", "capacity": "19300*129" },
        "liquid": { "conductivity": "1.1e-4*19300*129", "capacity": "19300*129" } })
}

fn stefan() -> Value {
    json!({ "name": "stefan", "axis": "y", "wall": 260, "melting_temperature": 273,
        "latent_heat": 3e8, "phase": { "conductivity": 2.2, "capacity": 1.9e6 } })
}

/// Both x faces held.
fn walls() -> (&'static str, Value) {
    let wall =
        |face: &str, value: f64| json!({ "wall": { "faces": [face], "kind": { "value": value } } });
    ("boundaries", json!([wall("x_min", 7.0), wall("x_max", 9.0)]))
}

fn gold() -> (&'static str, Value) {
    ("materials", json!({ "rock": { "conductivity": 300, "density": 100, "heat_capacity": 2 } }))
}

#[test]
fn a_body_that_melts() {
    let Ok(Solution::Neumann(melts)) = with(&neumann(), &[]) else { panic!("refused") };
    assert!((melts.lambda() - 0.243_463_771_4).abs() < 5.1e-11);
    assert!((melts.at(DVec3::X * 0.03, 15.0) - 383.819_284).abs() < 5.1e-7);
    // The face of the domain where nothing is said: x = 4 for a body below it.
    let below = changed(&changed(&neumann(), "/at", &Value::Null), "/body", &json!("below"));
    let below = with(&below, &[]).expect("good");
    assert_eq!((below.name(), below.at(DVec3::X * 4.1, 15.0)), ("neumann", 500.0));
    assert!((below.at(DVec3::X * 3.97, 15.0) - 383.819_284).abs() < 5.1e-7);
    // Of the wall of the scene.
    let cold = json!({ "name": "stefan", "axis": "x", "melting_temperature": 8, "latent_heat": 2,
        "phase": { "conductivity": 1, "capacity": 1 } });
    let cold = with(&cold, &[walls()]).expect("good");
    assert_eq!([0.0, 9.0].map(|x| cold.at(DVec3::X * x, 0.1)), [7.0, 8.0]);
    let frozen = with(&stefan(), &[]).expect("good");
    assert_eq!((frozen.name(), frozen.allows_sources()), ("stefan", false));
    assert_eq!(frozen.at(DVec3::Y, 60.0), 273.0);
}

#[test]
fn bad_parameters_of_a_body_that_melts() {
    for (key, value, expected) in [
        ("/latent_heat", json!(0), "exact.latent_heat: is 0, must be positive"),
        ("/latent_heat", Value::Null, "exact.latent_heat: missing key"),
        ("/wall", json!(400), "exact.wall: is 400, must be above or below the melting temperature"),
        ("/wall", Value::Null, "exact.wall: missing key: the face x_min has no wall"),
        ("/axis", json!("z"), "exact.axis: unknown name \"z\""),
        ("/axis", json!("w"), "exact.axis: unknown name \"w\"; did you mean"),
        ("/name", json!("x"), "exact.name: unknown name \"x\""),
        ("/body", json!("beside"), "exact.body: unknown name \"beside\""),
        ("/initial", json!(401), "exact.initial: is 401, must be at most the melting temperature"),
        ("/solid/conductivity", json!(0), "exact.solid.conductivity: is 0, must be positive"),
        ("/liquid/capacity", json!(-1), "exact.liquid.capacity: is -1, must be positive"),
        ("/liquid/capacity", Value::Null, "exact.liquid.capacity: missing key"),
        ("/liquid/density", json!(1), "exact.liquid.density: unknown key"),
    ] {
        refused(&changed(&neumann(), key, &value), &[], expected);
    }
    let freezing = changed(&neumann(), "/wall", &json!(350));
    let expected = "exact.initial: is 300, must be at least the melting temperature";
    refused(&freezing, &[], expected);
    let expected = "exact.phase.capacity: is 0, must be positive";
    refused(&changed(&stefan(), "/phase/capacity", &json!(0)), &[], expected);
    refused(&changed(&stefan(), "/initial", &json!(0)), &[], "exact.initial: unknown key");
    let insulated = json!([{ "wall": { "faces": ["x_min"], "kind": "insulated" } }]);
    let expected = "exact.wall: missing key: the wall on x_min holds no value";
    let unheld = changed(&neumann(), "/wall", &Value::Null);
    refused(&unheld, &[("boundaries", insulated)], expected);
    let sources = ("sources", json!([{ "rate": 1 }]));
    refused(&neumann(), &[sources], "exact: the solution neumann knows no sources");
}

#[test]
fn a_power_at_a_point_is_that_of_the_scene() {
    let exact = json!({ "name": "continuous_point_source", "initial": 5 });
    let source = |power: Value| ("sources", json!([{ "power": power, "at": [2, 1] }]));
    let Ok(Solution::ContinuousPointSource(found)) =
        with(&exact, &[source(json!("2*200")), gold()])
    else {
        panic!("refused")
    };
    // Over rho c.
    assert_eq!((found.dimension, found.power, found.diffusivity), (2, 2.0, 1.5));
    assert_eq!((found.at, found.initial), (DVec3::new(2.0, 1.0, 0.0), 5.0));
    let given = json!({ "name": "continuous_point_source", "initial": 5, "power": 6,
        "at": [0, 1], "diffusivity": 3 });
    let Ok(Solution::ContinuousPointSource(given)) = with(&given, &[]) else { panic!("refused") };
    assert_eq!((given.power, given.at, given.diffusivity), (6.0, DVec3::Y, 3.0));
    refused(&exact, &[], "exact.power: missing key: the case has 0 sources");
    let expected = "exact.power: missing key: the source is not a constant power at a point";
    refused(&exact, &[source(json!("200*t"))], expected);
    refused(&exact, &[("sources", json!([{ "rate": 1 }]))], expected);
    let moving = json!([{ "power": 1, "path": [[1, 1], [2, 1]], "speed": 1 }]);
    refused(&exact, &[("sources", moving)], expected);
}

#[test]
fn a_heated_slab_is_that_of_the_scene() {
    let exact = json!({ "name": "heated_slab", "axis": "x", "initial": 5 });
    let source = |json: Value| ("sources", json!([json]));
    let steady = |rate: Value| {
        let found = with(&exact, &[source(json!({ "rate": rate })), gold(), walls()]);
        found.map(|solution| solution.at(DVec3::new(1.0, 1.0, 0.0), 1e6))
    };
    // 7 + 2 / 4 + rate / (2 k) * 1 * 3.
    assert!((steady(json!(200)).expect("good") - 8.5).abs() < 1e-12);
    let given = json!({ "name": "heated_slab", "axis": "x", "initial": 5, "from": 0, "to": 1,
        "left": 1, "right": 1, "rate": 8, "diffusivity": 1 });
    let given = with(&given, &[]).expect("good");
    assert!((given.at(DVec3::X * 0.5, 1e6) - 2.0).abs() < 1e-12);
    let expected = "exact.rate: missing key: the source is not a constant rate everywhere";
    assert!(steady(json!("200*x")).expect_err("it varies").starts_with(expected));
    refused(&exact, &[source(json!({ "rate": 1, "linear": -1 })), walls()], expected);
    let hot = json!({ "rate": 1, "where": { "sphere": { "center": [2, 1], "radius": 1 } } });
    refused(&exact, &[source(hot), walls()], expected);
    refused(&exact, &[walls()], "exact.rate: missing key: the case has 0 sources");
    let expected = "exact.left: missing key: the face x_min has no wall";
    refused(&exact, &[source(json!({ "rate": 1 }))], expected);
    refused(&changed(&exact, "/to", &json!(-1)), &[], "exact.to: is -1, must be above exact.from");
}

#[test]
fn layers_of_materials() {
    let exact = json!({ "name": "layers", "axis": "x", "layers": [
        { "material": "rock", "to": 1, "resistance": "1/300" }, { "conductivity": 150 }] });
    let Ok(Solution::Layers(layers)) = with(&exact, &[gold(), walls()]) else { panic!("refused") };
    // 1/300, 1/300 between, 3/150.
    assert!((layers.flux() + 2.0 / (8.0 / 300.0)).abs() < 1e-11);
    assert!((layers.at(DVec3::X) - 7.25).abs() < 1e-13);
    for (key, value, expected) in [
        ("/layers", json!([]), "exact.layers[0]: missing key"),
        ("/layers/0/to", Value::Null, "exact.layers[0].to: missing key"),
        (
            "/layers/0/to",
            json!(5),
            "exact.layers[1].to: is 4, must be above where the layer begins",
        ),
        ("/from", json!(1), "exact.layers[0].to: is 1, must be above where the layer begins"),
        ("/layers/0/material", json!("rok"), "exact.layers[0].material: unknown name \"rok\""),
        ("/layers/0/material", Value::Null, "exact.layers[0].material: missing key"),
        ("/layers/0/conductivity", json!(1), "exact.layers[0].conductivity: not used"),
        (
            "/layers/1/conductivity",
            json!(0),
            "exact.layers[1].conductivity: is 0, must be positive",
        ),
        ("/layers/0/resistance", json!(-1), "exact.layers[0].resistance: is -1, must be zero or"),
        (
            "/layers/1/resistance",
            json!(1),
            "exact.layers[1].resistance: not used: no layer follows",
        ),
    ] {
        refused(&changed(&exact, key, &value), &[gold(), walls()], expected);
    }
    refused(&exact, &[gold()], "exact.left: missing key: the face x_min has no wall");
}
