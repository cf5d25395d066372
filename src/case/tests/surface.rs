//! The surface of a shape.

use glam::DVec3;
use serde_json::{Value, json};

use crate::case::number::Evaluator;
use crate::case::shape::{Shape, ShapeSpec};

const TOLERANCE: f64 = 1e-9;

fn shape(dimension: usize, json: &Value) -> Shape {
    let spec: ShapeSpec = serde_json::from_value(json.clone()).expect("shape");
    spec.resolve(&Evaluator { dimension, spacing: Some(0.1) }, "s").expect("good")
}

/// Points in a cube of edge 2 `reach` around the origin, the same in every run.
fn points(dimension: usize, reach: f64, count: usize) -> Vec<DVec3> {
    let fraction = |k: usize, root: f64| ((k + 1) as f64 * root).fract();
    let coordinate = |k, root| reach * (2.0 * fraction(k, root) - 1.0);
    let point = |k| {
        let roots = [2.0_f64.sqrt(), 3.0_f64.sqrt(), 5.0_f64.sqrt()];
        let mut x = DVec3::from_array(roots.map(|root| coordinate(k, root)));
        for axis in dimension..3 {
            x[axis] = 0.0;
        }
        x
    };
    (0..count).map(point).collect()
}

/// Around each point there is a ball without surface that reaches to its foot, and around the foot
/// there are both points of the shape and others.
fn check(dimension: usize, json: &Value) {
    check_up_to(dimension, json, 0.999);
}

/// The same with a ball that reaches to this share of the way.
fn check_up_to(dimension: usize, json: &Value, share: f64) {
    let shape = shape(dimension, json);
    let around = points(dimension, 1.0, 400);
    // Outside of a difference, the edges of its cuts are near only.
    let is_whole = !json.to_string().contains("difference");
    let counts = |x: &DVec3| is_whole || shape.contains(*x, 0.0);
    for x in points(dimension, 2.0, 600).into_iter().filter(counts) {
        let foot = shape.nearest_on_surface(x, TOLERANCE).expect("a surface");
        let dist = x.distance(foot);
        let is_in = shape.contains(x, 0.0);
        for offset in around.iter().filter(|offset| offset.length() < 1.0) {
            let y = x + share * dist * *offset;
            assert_eq!(shape.contains(y, 0.0), is_in, "{json}: {x} has its foot at {foot}, {y}");
        }
        let near = |offset: &DVec3| shape.contains(foot + 1e-3 * *offset, 0.0);
        let count = around.iter().filter(|offset| near(offset)).count();
        assert!(count > 0 && count < around.len(), "{json}: {x} has its foot at {foot}: {count}");
    }
}

#[test]
fn feet_are_the_nearest_points_of_surfaces() {
    let unit = json!({ "box": { "min": [-1, -1], "max": [1, 1] } });
    let right = json!({ "box": { "min": [1, -1], "max": [1.5, 1] } });
    let tall = json!({ "box": { "min": [-0.5, -1], "max": [0.5, 1.5] } });
    let disk = json!({ "sphere": { "center": [0.2, 0.1], "radius": 0.6 } });
    let far = json!({ "sphere": { "center": [1.5, 1.5], "radius": 0.3 } });
    let ring = json!({ "annulus": { "center": [0.1, 0], "inner_radius": 0.5, "outer_radius": 1 } });
    let half = json!({ "half_space": { "point": [0.2, 0.1], "normal": [1, 2] } });
    for json in [
        unit.clone(),
        disk.clone(),
        ring.clone(),
        half.clone(),
        json!({ "union": [unit, right] }),
        json!({ "union": [unit, tall] }),
        json!({ "union": [disk, far] }),
        json!({ "difference": { "of": unit, "minus": [disk] } }),
        json!({ "difference": { "of": unit, "minus": [tall] } }),
        json!({ "difference": { "of": unit, "minus": [half] } }),
        json!({ "difference": { "of": unit, "minus": [ring, disk] } }),
        json!({ "union": [right, { "difference": { "of": unit, "minus": [disk] } }] }),
    ] {
        check(2, &json);
    }
    // The ring bulges from the box: its hollow edges are round.
    check_up_to(2, &json!({ "union": [unit, disk, ring] }), 0.9);
    let block = json!({ "box": { "min": [-1, -0.5, -1], "max": [1, 1, 0.5] } });
    let tube =
        json!({ "cylinder": { "from": [-0.5, -0.5, 0], "to": [0.5, 0.7, 1], "radius": 0.6 } });
    let shell = json!({ "shell": { "center": [0, 0, 0.1], "inner_radius": 0.4,
        "outer_radius": 0.9 } });
    for json in [
        block.clone(),
        tube.clone(),
        shell.clone(),
        json!({ "difference": { "of": block, "minus": [tube] } }),
        json!({ "union": [block, { "box": { "min": [-0.5, 1, -1], "max": [1, 1.5, 1] } }] }),
    ] {
        check(3, &json);
    }
    check(1, &json!({ "box": { "min": [-1], "max": [0.5] } }));
    check(1, &json!({ "sphere": { "center": [0.1], "radius": 0.7 } }));
}

#[test]
fn feet_of_single_points() {
    let ball = json!({ "sphere": { "center": [1, 1], "radius": 0.5 } });
    let shell = json!({ "shell": { "center": [0, 0, 0], "inner_radius": 1, "outer_radius": 2 } });
    let solid = json!({ "shell": { "center": [0, 0, 0], "inner_radius": 0, "outer_radius": 2 } });
    let tube = json!({ "cylinder": { "from": [0, 0, 0], "to": [0, 0, 4], "radius": 1 } });
    let sheet = json!({ "box": { "min": [0, 0, 0], "max": [2, 2, 0] } });
    for (dimension, json, x, foot) in [
        // Axes past the dimension are no faces.
        (2, json!({ "box": { "min": [0, 0], "max": [4, 2] } }), [2.0, 1.2, 0.0], [2.0, 2.0, 0.0]),
        (2, json!({ "box": { "min": [0, 0], "max": [4, 2] } }), [5.0, 3.0, 0.0], [4.0, 2.0, 0.0]),
        // A sheet is its own surface.
        (3, sheet.clone(), [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]),
        (3, sheet, [1.0, 1.0, 0.7], [1.0, 1.0, 0.0]),
        // Centre and axis.
        (2, ball.clone(), [1.0, 1.0, 0.0], [1.5, 1.0, 0.0]),
        (2, ball, [1.0, 1.1, 0.0], [1.0, 1.5, 0.0]),
        (3, shell.clone(), [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        (3, shell.clone(), [0.0, 1.4, 0.0], [0.0, 1.0, 0.0]),
        (3, shell, [0.0, 1.6, 0.0], [0.0, 2.0, 0.0]),
        (3, solid, [0.0, 0.1, 0.0], [0.0, 2.0, 0.0]),
        (3, tube.clone(), [0.0, 0.0, 0.2], [0.0, 0.0, 0.0]),
        (3, tube.clone(), [0.0, 0.9, 3.0], [0.0, 1.0, 3.0]),
        (3, tube.clone(), [0.0, 2.0, 5.0], [0.0, 1.0, 4.0]),
        (3, tube, [0.5, 0.0, 5.0], [0.5, 0.0, 4.0]),
        (
            2,
            json!({ "half_space": { "point": [1, 0], "normal": [2, 0] } }),
            [3.0, 7.0, 0.0],
            [1.0, 7.0, 0.0],
        ),
    ] {
        let found = shape(dimension, &json).nearest_on_surface(x.into(), TOLERANCE);
        let found = found.expect("a surface");
        assert!(found.distance(foot.into()) < 1e-12, "{json}: {found}");
    }
    let on_axis = json!({ "cylinder": { "from": [0, 0, 0], "to": [0, 0, 4], "radius": 1 } });
    let foot = shape(3, &on_axis).nearest_on_surface([0.0, 0.0, 2.0].into(), TOLERANCE);
    let foot = foot.expect("a surface");
    assert!((foot.truncate().length() - 1.0).abs() < 1e-12 && foot.z == 2.0, "{foot}");
}

#[test]
fn what_is_covered_is_no_surface() {
    let all = json!({ "half_space": { "point": [0, 0], "normal": [1, 0] } });
    let rest = json!({ "half_space": { "point": [0, 0], "normal": [-1, 0] } });
    let whole = shape(2, &json!({ "union": [all, rest] }));
    assert_eq!(whole.nearest_on_surface([0.3, 0.1, 0.0].into(), TOLERANCE), None);
}
