//! Walls and surfaces that must be read, and what they must become.

use glam::DVec3;
use serde_json::{Value, json};

use super::base;
use crate::case::{Scene, from_json, schema};
use crate::model::{Face, Problem, WallKind};

/// The base case with these boundaries.
fn bounded(boundaries: Value) -> Scene {
    let mut case = base();
    case["boundaries"] = boundaries.clone();
    from_json("bounded", case, &[]).unwrap_or_else(|error| panic!("{boundaries}: {error}"))
}

/// A kind as a case file says it.
fn written(kind: WallKind) -> Value {
    match kind {
        WallKind::Free | WallKind::Insulated => json!(kind.name()),
        WallKind::Value | WallKind::Flux => json!({ kind.name(): "3*y+t" }),
        WallKind::Convection => {
            json!({ kind.name(): { "coefficient": "2+x", "ambient": 7 } })
        }
    }
}

#[test]
fn every_kind_of_wall_is_read() {
    for kind in WallKind::ALL {
        let scene = bounded(json!([
            { "periodic": { "axes": ["x"] } },
            { "wall": { "faces": ["y_max", "y_min"], "kind": written(kind) } }
        ]));
        let walls = &scene.problem.walls;
        let faces: Vec<Face> = walls.iter().map(|wall| wall.face).collect();
        assert_eq!(faces, [true, false].map(|upper| Face { axis: 1, upper }));
        for wall in walls {
            assert_eq!(wall.name, "boundaries[1].wall");
            assert!(wall.covers.is_none());
            let (condition, at) = (&wall.condition, DVec3::new(1.0, 2.0, 0.0));
            assert_eq!(condition.kind, kind);
            let imposed = &condition.imposed;
            let depends = (imposed.depends_on_position(), imposed.depends_on_time());
            let (value, coefficient, expected) = match kind {
                WallKind::Free | WallKind::Insulated => (0.0, 0.0, (false, false)),
                WallKind::Value | WallKind::Flux => (11.0, 0.0, (true, true)),
                WallKind::Convection => (7.0, 3.0, (false, false)),
            };
            assert_eq!(
                (imposed.at(at, 5.0), condition.coefficient.at(at, 0.0)),
                (value, coefficient)
            );
            assert_eq!(depends, expected, "{kind:?}");
            assert!(!condition.coefficient.depends_on_time());
        }
    }
}

#[test]
fn fields_know_what_they_depend_on() {
    for (text, position, time) in
        [("2*pi", false, false), ("x", true, false), ("sin(t)", false, true), ("x*t", true, true)]
    {
        let wall = json!([{ "wall": { "faces": ["x_max"], "kind": { "flux": text } } }]);
        let imposed = &bounded(wall).problem.walls[0].condition.imposed;
        assert_eq!(imposed.depends_on_position(), position, "{text}");
        assert_eq!(imposed.depends_on_time(), time, "{text}");
        assert_eq!(imposed.text(), text);
    }
}

/// The kind of the first wall with a shape that covers a point of a face, else of the rest.
fn kind_at(problem: &Problem, face: Face, x: DVec3) -> Option<WallKind> {
    let on_face = || problem.walls.iter().filter(|wall| wall.face == face);
    let covers = |x| move |wall: &&_| covered(wall, x);
    let patch = on_face().find(covers(x));
    patch.or_else(|| on_face().find(|wall| wall.covers.is_none())).map(|wall| wall.condition.kind)
}

fn covered(wall: &crate::model::Wall, x: DVec3) -> bool {
    wall.covers.as_ref().is_some_and(|part| part.contains(x))
}

#[test]
fn patches_cover_their_part_of_the_face() {
    let patch = |kind: Value, min: [f64; 2], max: [f64; 2]| {
        json!({ "wall": { "faces": ["x_min"], "kind": kind,
            "where": { "box": { "min": min, "max": max } } } })
    };
    // Without thickness, thick, and sharing the edge y = 0.75, where particles have their feet.
    let problem = bounded(json!([
        patch(json!({ "value": 1 }), [0.0, 0.0], [0.0, 0.75]),
        { "wall": { "faces": ["x_min", "x_max"], "kind": "insulated" } },
        patch(json!("free"), [-0.1, 0.75], [0.2, 1.5])
    ]))
    .problem;
    assert_eq!(problem.walls.len(), 4);
    let (lower, upper) = (Face { axis: 0, upper: false }, Face { axis: 0, upper: true });
    for (y, kind) in [
        (0.0, WallKind::Value),
        (0.75, WallKind::Value),
        (1.0, WallKind::Free),
        (1.6, WallKind::Insulated),
    ] {
        assert_eq!(kind_at(&problem, lower, DVec3::new(0.0, y, 0.0)), Some(kind), "{y}");
    }
    assert_eq!(kind_at(&problem, upper, DVec3::new(4.0, 0.1, 0.0)), Some(WallKind::Insulated));
    assert_eq!(kind_at(&problem, Face { axis: 1, upper: true }, DVec3::ONE), None);
}

/// A body of 4 spacings along each axis, with patches on its lower x face.
fn cube(dimension: usize, patches: &[(Value, Value)]) -> Value {
    let patch = |(min, max): &(Value, Value)| {
        json!({ "wall": { "faces": ["x_min"], "kind": "insulated",
            "where": { "box": { "min": min, "max": max } } } })
    };
    json!({
        "title": "cube", "dimension": dimension,
        "particles": { "spacing": 1, "fill": [
            { "shape": { "box": { "min": vec![0; dimension], "max": vec![4; dimension] } },
                "material": "rock" }
        ] },
        "kernel": { "name": "wendland_c2", "support_ratio": 2 },
        "materials": { "rock": { "diffusivity": 1 } },
        "boundaries": patches.iter().map(patch).collect::<Vec<_>>(),
        "time": { "end": 1 }
    })
}

#[test]
fn patches_may_touch_but_not_overlap_in_every_dimension() {
    let found = |dimension: usize, patches: &[(Value, Value)]| {
        let scene = from_json("cube", cube(dimension, patches), &[]);
        scene.map(|scene| scene.problem.walls.len()).map_err(|error| error.to_string())
    };
    let low = (json!([0, 0, 0]), json!([0, 4, 1.5]));
    let high = (json!([0, 0, 1.5]), json!([0, 2, 4]));
    let side = (json!([-1, 2, 1.5]), json!([1, 4, 4]));
    assert_eq!(found(3, &[low.clone(), high.clone(), side]), Ok(3));
    let over = (json!([0, 1, 0]), json!([0, 1.5, 4]));
    let error = found(3, &[low, high, over]).expect_err("overlap");
    let expected = "boundaries[2].wall: two kinds on one patch: boundaries[0].wall covers the \
                    point [0, 1.263, 0.263] of x_min too";
    assert_eq!(error, expected);
    let end = (json!([0]), json!([0]));
    assert_eq!(found(1, std::slice::from_ref(&end)), Ok(1));
    let error = found(1, &[end.clone(), end]).expect_err("overlap");
    assert!(error.ends_with("boundaries[0].wall covers the point [0] of x_min too"), "{error}");
}

/// The base case with a hole of radius 0.6 around [2, 1].
fn holed(boundaries: Value) -> Value {
    let mut case = base();
    case["particles"]["fill"][0]["shape"] = json!({ "difference": { "of": { "box": { "min": [0, 0], "max": [4, 2] } },
            "minus": [hole()] } });
    case["boundaries"] = boundaries;
    case
}

fn hole() -> Value {
    json!({ "sphere": { "center": [2, 1], "radius": 0.6 } })
}

#[test]
fn surfaces_have_feet() {
    let case = holed(json!([
        { "surface": { "of": hole(), "kind": { "flux": 2 } } },
        { "surface": { "of": hole(), "kind": written(WallKind::Convection),
            "where": { "half_space": { "point": [2, 1], "normal": [1, 0] } } } }
    ]));
    let surfaces = from_json("holed", case, &[]).expect("good").problem.surfaces;
    assert_eq!(surfaces[0].name, "boundaries[0].surface");
    assert_eq!(surfaces[1].name, "boundaries[1].surface");
    assert_eq!(surfaces[0].condition.kind, WallKind::Flux);
    assert_eq!(surfaces[1].condition.kind, WallKind::Convection);
    let [left, right] = [1.25, 2.75].map(|x| DVec3::new(x, 1.0, 0.0));
    let foot = surfaces[0].foot(right);
    assert!(foot.distance(DVec3::new(2.6, 1.0, 0.0)) < 1e-12, "{foot}");
    assert!((surfaces[0].distance(right) - 0.15).abs() < 1e-12);
    assert!(surfaces[0].contains(DVec3::new(2.0, 1.0, 0.0)) && !surfaces[0].contains(right));
    assert!(!surfaces[1].covers(foot) && surfaces[1].covers(surfaces[1].foot(left)));
}

/// Every form of a wall and a surface.
fn forms() -> Vec<Value> {
    let patch = json!({ "box": { "min": [4, 0.5], "max": [4, 1.5] } });
    let mut forms = Vec::new();
    for kind in WallKind::ALL {
        forms.push(json!({ "wall": { "faces": ["x_max"], "kind": written(kind) } }));
        forms
            .push(json!({ "wall": { "faces": ["x_max"], "kind": written(kind), "where": patch } }));
        if kind.has_inflow() {
            forms.push(json!({ "surface": { "of": hole(), "kind": written(kind) } }));
            let part = json!({ "box": { "min": [0, 0], "max": [2, 2] } });
            forms
                .push(json!({ "surface": { "of": hole(), "kind": written(kind), "where": part } }));
        }
    }
    forms
}

#[test]
fn every_form_satisfies_the_schema_and_repeats_from_its_resolved_form() {
    let validator = jsonschema::validator_for(&schema()).expect("a valid schema");
    for form in forms() {
        let case = holed(json!([form]));
        assert!(validator.is_valid(&case), "{form}: {:?}", validator.validate(&case));
        let first = from_json("first", case, &[]).unwrap_or_else(|error| panic!("{form}: {error}"));
        assert_eq!(first.resolved["boundaries"], json!([form]));
        let second = from_json("second", first.resolved.clone(), &[]).expect("good");
        assert_eq!(first.resolved, second.resolved, "{form}");
        let text = |problem: &Problem| format!("{:?} {:?}", problem.walls, problem.surfaces);
        assert_eq!(text(&first.problem), text(&second.problem), "{form}");
    }
}

#[test]
fn the_schema_refuses_what_is_refused() {
    let validator = jsonschema::validator_for(&schema()).expect("a valid schema");
    for form in [
        json!({ "wall": { "faces": [], "kind": "free" } }),
        json!({ "wall": { "faces": ["x_max", "x_max"], "kind": "free" } }),
        json!({ "wall": { "face": "x_max", "kind": "free" } }),
        json!({ "wall": { "faces": ["x_max"], "kind": "value" } }),
        json!({ "wall": { "faces": ["x_max"], "kind": { "value": 1, "flux": 1 } } }),
        json!({ "wall": { "faces": ["x_max"], "kind": { "convection": { "ambient": 1 } } } }),
        json!({ "surface": { "of": hole(), "kind": { "value": 1 } } }),
        json!({ "surface": { "of": hole(), "kind": "insulated" } }),
        json!({ "surface": { "kind": { "flux": 1 } } }),
    ] {
        assert!(!validator.is_valid(&holed(json!([form]))), "{form}");
        assert!(from_json("bad", holed(json!([form])), &[]).is_err(), "{form}");
    }
}

#[test]
fn walls_between_cells_are_warned_of() {
    let warnings = |shape: Value, kind: Value| {
        let mut case = base();
        case["particles"]["fill"][0]["shape"] = shape;
        case["boundaries"] = json!([{ "wall": { "faces": ["x_min", "x_max"], "kind": kind } }]);
        from_json("odd", case, &[]).expect("good").warnings
    };
    let long = json!({ "box": { "min": [0, 0], "max": [4.1, 2] } });
    let odd = "its 4.1 m along x are no whole number of spacings of 0.5 m";
    let next = "; next to the wall on x_max the accuracy drops to first order";
    let found = warnings(long.clone(), json!("insulated"));
    assert_eq!(found, [format!("particles.fill[0].shape.box: {odd}{next}")]);
    let found = warnings(long.clone(), json!("free"));
    assert_eq!(found, [format!("particles.fill[0].shape.box: {odd}")]);
    let cut = json!({ "difference": { "of": long, "minus": [hole()] } });
    let found = warnings(cut, json!("insulated"));
    assert_eq!(found, [format!("particles.fill: {odd}{next}")]);
    let whole = json!({ "box": { "min": [0, 0], "max": [4, 2] } });
    assert!(warnings(whole, json!("insulated")).is_empty());
}
