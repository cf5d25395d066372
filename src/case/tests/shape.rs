//! Shapes: what they hold, their bounds, and what is refused.

use glam::DVec3;
use serde_json::json;

use crate::case::CaseError;
use crate::case::number::Evaluator;
use crate::case::shape::{Shape, ShapeSpec};

fn shape(json: serde_json::Value) -> Result<Shape, CaseError> {
    let spec: ShapeSpec = serde_json::from_value(json).expect("shape");
    spec.resolve(&Evaluator { dimension: 3, spacing: Some(0.1) }, "s")
}

#[test]
fn shapes_hold_what_they_should() {
    let unit = json!({ "box": { "min": [0, 0, 0], "max": [1, 1, 1] } });
    let ball = json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } });
    let tube = json!({ "cylinder": { "from": [0, 0, 0], "to": [0, 0, 2], "radius": 1 } });
    let shell = json!({ "annulus": { "center": [0, 0, 0], "inner_radius": 1,
        "outer_radius": 2 } });
    let half = json!({ "half_space": { "point": [0.5, 0, 0], "normal": [2, 0, 0] } });
    for (json, inside, outside) in [
        (unit.clone(), [1.0, 0.0, 0.5], [1.1, 0.0, 0.5]),
        (ball.clone(), [0.0, 0.0, 0.0], [0.8, 0.8, 0.0]),
        (tube, [0.0, 1.0, 2.0], [0.0, 0.0, 2.1]),
        (shell, [0.0, 1.0, 0.0], [0.0, 0.9, 0.0]),
        (half.clone(), [-9.0, 5.0, 0.0], [0.6, 0.0, 0.0]),
        (json!({ "union": [unit.clone(), ball.clone()] }), [-0.9, 0.0, 0.0], [1.0, -1.0, 0.0]),
        (
            json!({ "difference": { "of": unit, "minus": [ball] } }),
            [0.9, 0.9, 0.9],
            [1.0, 0.0, 0.0],
        ),
    ] {
        let shape = shape(json.clone()).expect("good");
        assert!(shape.contains(inside.into(), 1e-10), "{json}");
        assert!(!shape.contains(outside.into(), 1e-10), "{json}");
    }
}

#[test]
fn bounds_enclose() {
    let tilted = json!({ "cylinder": { "from": [0, 0, 0], "to": [1, 0, 0], "radius": 2 } });
    let bounds = shape(tilted).expect("good").bounds().expect("bounded");
    assert_eq!(bounds, (DVec3::new(0.0, -2.0, -2.0), DVec3::new(1.0, 2.0, 2.0)));
    let half = json!({ "half_space": { "point": [0.5, 0, 0], "normal": [2, 0, 0] } });
    assert_eq!(shape(half.clone()).expect("good").bounds(), None);
    let cut = json!({ "difference": { "of": { "sphere": { "center": [0, 0, 0], "radius": 1 } },
        "minus": [half] } });
    assert_eq!(shape(cut).expect("good").bounds(), Some((-DVec3::ONE, DVec3::ONE)));
}

#[test]
fn contradictions_are_named() {
    for (json, message) in [
        (json!({ "box": { "min": [0, 2, 0], "max": [1, 1, 1] } }), "s: box.min must not"),
        (json!({ "sphere": { "center": [0, 0, 0], "radius": 0 } }), "s.sphere.radius: is 0,"),
        (json!({ "sphere": { "center": [0, 0], "radius": 1 } }), "s.sphere.center: has 2 "),
        (
            json!({ "cylinder": { "from": [0, 0, 0], "to": [0, 0, 0], "radius": 1 } }),
            "s: cylinder.from and",
        ),
        (
            json!({ "shell": { "center": [0, 0, 0], "inner_radius": 3, "outer_radius": 2 } }),
            "s.shell.inner_radius: is 3,",
        ),
        (
            json!({ "half_space": { "point": [0, 0, 0], "normal": [0, 0, 0] } }),
            "s: half_space.normal must",
        ),
        (json!({ "union": [] }), "s: union needs"),
    ] {
        let found = shape(json).expect_err(message).to_string();
        assert!(found.starts_with(message), "{found}");
    }
}
