//! Walls and surfaces that must be refused, with a message that starts with the path.

use serde_json::{Value, json};

use super::base;
use crate::case::from_json;

/// The message of a case that must be refused.
fn message(case: Value) -> String {
    let error = from_json("bad", case.clone(), &[]).expect_err(&case.to_string()).to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

/// The base case with these boundaries.
fn bounded(boundaries: Value) -> Value {
    let mut case = base();
    case["boundaries"] = boundaries;
    case
}

fn refused(boundaries: Value, expected: &str) {
    let error = message(bounded(boundaries.clone()));
    assert!(error.starts_with(expected), "{boundaries}\n  {error}\n  {expected}");
}

fn wall(faces: &[&str], kind: Value) -> Value {
    json!({ "wall": { "faces": faces, "kind": kind } })
}

fn patch(face: &str, kind: Value, min: [f64; 2], max: [f64; 2]) -> Value {
    json!({ "wall": { "faces": [face], "kind": kind, "where": { "box": { "min": min, "max": max } } } })
}

#[test]
fn faces_are_those_of_the_case_and_once() {
    let free = || json!("free");
    refused(
        json!([wall(&["x_min", "z_min"], free())]),
        "boundaries[0].wall.faces[1]: unknown name \"z_min\" (known: x_min, x_max, y_min, y_max)",
    );
    refused(
        json!([wall(&["x_mn"], free())]),
        "boundaries[0].wall.faces[0]: unknown name \"x_mn\"; did you mean \"x_min\"?",
    );
    refused(
        json!([{ "wall": { "face": "x_min", "kind": "free" } }]),
        "boundaries[0].wall.face: unknown key; did you mean \"faces\"?",
    );
    refused(json!([wall(&[], free())]), "boundaries[0].wall.faces: names no face");
    refused(
        json!([wall(&["x_min", "y_min", "x_min"], free())]),
        "boundaries[0].wall.faces[2]: \"x_min\" is given twice",
    );
    refused(
        json!([wall(&["y_max", "x_min"], free()), { "periodic": { "axes": ["x"] } }]),
        "boundaries[0].wall.faces[1]: not used: the axis x is periodic",
    );
    refused(
        json!([wall(&["x_min"], free()), wall(&["y_max", "x_min"], json!("insulated"))]),
        "boundaries[1].wall.faces[1]: boundaries[0].wall covers all of x_min already; give one of \
         the two a \"where\"",
    );
}

#[test]
fn kinds_are_named_and_complete() {
    let known = "(known: free, insulated, value, flux, convection)";
    for (kind, expected) in [
        (json!("fre"), format!(": unknown name \"fre\"; did you mean \"free\"? {known}")),
        (json!("hot"), format!(": unknown name \"hot\" {known}")),
        (json!({ "fluks": 1 }), format!(".fluks: unknown key; did you mean \"flux\"? {known}")),
        (json!("value"), ": \"value\" cannot stand alone: write {\"value\": ...}".to_owned()),
        (json!({ "free": {} }), ": \"free\" takes nothing: write \"free\"".to_owned()),
        (json!({ "value": 1, "flux": 1 }), ": expected one key, found several or none".to_owned()),
        (json!({ "value": true }), ".value: expected a number or an expression".to_owned()),
        (json!({ "flux": "1/0" }), ".flux: \"1/0\": gives inf (allowed: ".to_owned()),
        (json!({ "flux": "z" }), ".flux: \"z\": \"z\" has no meaning here".to_owned()),
        (
            json!({ "convection": { "ambient": 1 } }),
            ".convection.coefficient: missing key".to_owned(),
        ),
        (
            json!({ "convection": { "coefficient": 1 } }),
            ".convection.ambient: missing key".to_owned(),
        ),
        (
            json!({ "convection": { "coefficient": 1, "ambient": 1, "ambiant": 2 } }),
            ".convection.ambiant: unknown key; did you mean \"ambient\"?".to_owned(),
        ),
        (
            json!({ "convection": { "coefficient": "t", "ambient": 1 } }),
            ".convection.coefficient: \"t\": \"t\" has no meaning here".to_owned(),
        ),
    ] {
        refused(json!([wall(&["x_min"], kind)]), &format!("boundaries[0].wall.kind{expected}"));
    }
}

#[test]
fn patches_lie_on_their_face_and_apart() {
    refused(
        json!([
            patch("x_max", json!("insulated"), [4.0, 0.0], [4.0, 1.2]),
            wall(&["x_max"], json!("free")),
            patch("x_max", json!({ "value": 1 }), [3.0, 1.0], [5.0, 2.0])
        ]),
        // The foot at 1.25 less 0.237 of the spacing.
        "boundaries[2].wall: two kinds on one patch: boundaries[0].wall covers the point \
         [4, 1.131",
    );
    refused(
        json!([patch("x_max", json!("insulated"), [0.0, 0.0], [3.9, 2.0])]),
        "boundaries[0].wall.where: lies outside its face x_max, x = 4 m: no particle has its foot \
         in it",
    );
    refused(
        json!([patch("y_min", json!("free"), [5.0, 0.0], [6.0, 0.0])]),
        "boundaries[0].wall.where: lies outside its face y_min, y = 0 m",
    );
    // One of the two faces is enough.
    refused(
        json!([{ "wall": { "faces": ["x_min", "x_max"], "kind": "free",
            "where": { "box": { "min": [0, 0], "max": [0, 1] } } } }]),
        "boundaries[0].wall.where: lies outside its face x_max",
    );
}

#[test]
fn numbers_are_good_at_the_feet() {
    let convection = |coefficient: Value, ambient: Value| json!({ "convection": { "coefficient": coefficient, "ambient": ambient } });
    let key = "boundaries[0].wall.kind.convection";
    refused(
        json!([wall(&["x_max"], convection(json!(-1), json!(0)))]),
        &format!("{key}.coefficient: is -1, must be zero or positive"),
    );
    refused(
        json!([wall(&["x_max"], convection(json!("1-2"), json!(0)))]),
        &format!("{key}.coefficient: is -1, must be zero or positive"),
    );
    refused(
        json!([wall(&["x_max"], convection(json!("1-y"), json!(0)))]),
        &format!("{key}.coefficient: is -0.25 at [4, 1.25], must be zero or positive"),
    );
    refused(
        json!([wall(&["x_max"], convection(json!(1), json!("ln(y-0.25)")))]),
        &format!("{key}.ambient: \"ln(y-0.25)\": gives -inf at [4, 0.25], t = 0 s"),
    );
    for name in ["value", "flux"] {
        refused(
            json!([wall(&["y_min"], json!({ name: "1/t" }))]),
            &format!("boundaries[0].wall.kind.{name}: \"1/t\": gives inf at [0.25, 0], t = 0 s"),
        );
    }
    // Elsewhere they may be what they are.
    let bad = json!({ "value": "sqrt(y-1)" });
    let good = bounded(json!([patch("x_max", bad, [4.0, 1.0], [4.0, 2.0])]));
    assert!(from_json("good", good, &[]).is_ok());
}

#[test]
fn bodies_are_thick_enough_for_their_walls() {
    let thin = |kind: Value, ratio: f64| {
        let mut case = bounded(json!([wall(&["y_max"], kind)]));
        case["kernel"]["support_ratio"] = json!(ratio);
        case
    };
    assert_eq!(
        message(thin(json!("insulated"), 5.0)),
        "kernel.support_ratio: the support radius of 2.5 m is more than the 2 m along y, where \
         boundaries[0].wall is; the largest support_ratio allowed is 4"
    );
    for good in [thin(json!("insulated"), 4.0), thin(json!("free"), 5.0)] {
        assert!(from_json("good", good, &[]).is_ok());
    }
    let mut layer = thin(json!("insulated"), 2.0);
    layer["particles"]["fill"][0]["shape"]["box"]["max"] = json!([4, 0.5]);
    layer["probes"] = json!([]);
    assert_eq!(
        message(layer),
        "kernel.support_ratio: the support radius of 1 m is more than the 0.5 m along y, where \
         boundaries[0].wall is; no support_ratio fits an axis of at most one spacing"
    );
}

#[test]
fn no_particle_lies_on_a_walled_face() {
    // The second fill's face lies on the lattice of the first.
    let on_face = |kind: Value| {
        let mut case = bounded(json!([wall(&["x_min"], kind)]));
        case["particles"]["fill"] = json!([
            { "shape": { "box": { "min": [0.25, 0], "max": [4, 2] } }, "material": "rock" },
            { "shape": { "box": { "min": [0, 0], "max": [0.25, 2] } }, "material": "rock" }
        ]);
        case
    };
    assert_eq!(
        message(on_face(json!("insulated"))),
        "boundaries[0].wall: the particle at [0, 0.25] lies on x_min, where its mirror image would \
         coincide with it; a wall needs particles half a spacing away"
    );
    assert!(from_json("good", on_face(json!("free")), &[]).is_ok());
}

#[test]
fn surfaces_are_near_and_of_the_right_kind() {
    let hole = json!({ "sphere": { "center": [2, 1], "radius": 0.6 } });
    let surface = |of: &Value, kind: Value| json!([{ "surface": { "of": of, "kind": kind } }]);
    refused(
        surface(&hole, json!({ "value": 1 })),
        "boundaries[0].surface.kind: a surface has flux or convection, not value; hold the \
         particles next to it instead (\"held\")",
    );
    for kind in ["insulated", "free"] {
        refused(
            surface(&hole, json!(kind)),
            &format!(
                "boundaries[0].surface.kind: a surface has flux or convection, not {kind}; leave \
                 the surface out: nothing crosses it then"
            ),
        );
    }
    let far = json!({ "sphere": { "center": [9, 9], "radius": 1 } });
    refused(
        surface(&far, json!({ "flux": 1 })),
        "boundaries[0].surface: no particle lies within the support radius of 1 m of it",
    );
    refused(
        json!([{ "surface": { "of": hole, "kind": { "flux": 1 }, "where": far } }]),
        "boundaries[0].surface: no particle lies within the support radius of 1 m of its part in \
         \"where\"",
    );
    refused(
        surface(&hole, json!({ "flux": "1/t" })),
        "boundaries[0].surface.kind.flux: \"1/t\": gives inf at [",
    );
    refused(
        surface(&hole, json!({ "convection": { "coefficient": "-x", "ambient": 1 } })),
        "boundaries[0].surface.kind.convection.coefficient: is -",
    );
    refused(
        surface(&json!({ "bx": {} }), json!({ "flux": 1 })),
        "boundaries[0].surface.of.bx: unknown key; did you mean \"box\"?",
    );
    refused(
        surface(&json!({ "union": [] }), json!({ "flux": 1 })),
        "boundaries[0].surface.of: union needs at least one shape",
    );
    refused(json!([{ "surface": { "kind": "free" } }]), "boundaries[0].surface.of: missing key");
}

#[test]
fn held_values_do_not_change() {
    let place = json!({ "box": { "min": [0, 0], "max": [0.5, 2] } });
    refused(
        json!([{ "held": { "where": place, "value": "t" } }]),
        "boundaries[0].held.value: \"t\": \"t\" has no meaning here",
    );
}
