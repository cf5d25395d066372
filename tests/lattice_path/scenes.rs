//! Box scenes with every boundary that a lattice takes.

use diffusph::case::{self, Scene};
use diffusph::model::KernelKind;
use serde_json::{Value, json};

/// A box of these counts, with these boundaries and, among them, sources.
pub(crate) fn scene(
    kernel: KernelKind,
    support_ratio: f64,
    counts: &[usize],
    boundaries: Value,
) -> Scene {
    let max: Vec<f64> = counts.iter().map(|&count| 0.25 * count as f64).collect();
    let wave = ["7.3*x", "7.3*x + 5.1*y", "7.3*x + 5.1*y - 3.7*z"][counts.len() - 1];
    let (sources, boundaries) = sources_and_boundaries(boundaries);
    let case = json!({
        "title": "box",
        "dimension": counts.len(),
        "particles": {
            "spacing": 0.25,
            "fill": [{
                "shape": { "box": { "min": vec![0; counts.len()], "max": max } },
                "material": "m"
            }]
        },
        "kernel": { "name": kernel.name(), "support_ratio": support_ratio },
        "materials": { "m": { "diffusivity": 0.7 } },
        "initial": [{ "value": format!("300 + 10*sin({wave})") }],
        "boundaries": boundaries,
        "sources": sources,
        "time": { "end": 1 }
    });
    case::from_json("box", case, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// What is a source of a list, and its boundaries.
pub(crate) fn sources_and_boundaries(list: Value) -> (Vec<Value>, Vec<Value>) {
    let list = list.as_array().expect("a list").iter();
    let (sources, boundaries): (Vec<&Value>, Vec<&Value>) =
        list.partition(|entry| entry.get("source").is_some());
    let sources = sources.into_iter().map(|entry| entry["source"].clone());
    (sources.collect(), boundaries.into_iter().cloned().collect())
}

/// Boundaries of every kind that a lattice takes, for a scene of this dimension, some with sources.
pub(crate) fn boundaries(dimension: usize) -> Vec<Value> {
    let axes = &["x", "y", "z"][..dimension];
    let faces: Vec<String> =
        axes.iter().flat_map(|axis| ["min", "max"].map(|end| format!("{axis}_{end}"))).collect();
    let all = |kind: Value| json!([{ "wall": { "faces": faces, "kind": kind } }]);
    let held = json!({ "held": {
        "where": { "sphere": { "center": vec![1.1; dimension], "radius": 0.6 } }, "value": 250
    } });
    let convection = json!({ "convection": { "coefficient": 2, "ambient": "290 + 3*x" } });
    let near = json!({ "sphere": { "center": vec![1.6; dimension], "radius": 0.9 } });
    let mut normal = vec![0; dimension];
    normal[0] = 1;
    let mut list = vec![
        json!([]),
        json!([{ "periodic": { "axes": axes } }]),
        json!([{ "periodic": { "axes": axes } }, held]),
        json!([held]),
        all(json!("insulated")),
        all(json!({ "value": "300 + 20*x" })),
        all(json!({ "flux": "sin(30*t)" })),
        all(convection.clone()),
        // Held particles of several values whose ghosts reach each other.
        json!([
            { "held": {
                "where": { "sphere": { "center": vec![0.3; dimension], "radius": 1 } },
                "value": "250 + 30*x"
            } },
            { "wall": { "faces": faces, "kind": convection } }
        ]),
        // Different kinds on every face, some free.
        json!([
            { "wall": { "faces": ["x_min"], "kind": { "flux": 3 } } },
            { "wall": { "faces": ["x_max"], "kind": { "value": "300 + 5*t" } } }
        ]),
    ];
    if dimension > 1 {
        list.push(json!([
            { "periodic": { "axes": ["x"] } },
            { "wall": { "faces": ["y_min"], "kind": { "value": "300 + 20*sin(40*t)" } } },
            { "wall": { "faces": ["y_max"], "kind": "insulated" } },
            held
        ]));
    }
    list.extend([
        // Everywhere; and in parts, which overlap, beside walls and held particles.
        json!([{ "source": { "rate": "400 - 90*x", "linear": "-2 - x" } }]),
        json!([
            { "wall": { "faces": faces, "kind": { "value": 310 } } },
            held,
            { "source": { "rate": "300*sin(30*t + x)", "where": near } },
            { "source": { "linear": -3, "where": { "half_space": { "point": vec![1.4; dimension], "normal": normal } } } },
            { "source": { "linear": 0.5, "where": near } }
        ]),
    ]);
    list
}

/// The largest difference over the largest value.
pub(crate) fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let scale = a.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale
}

/// Counts past twice the reach of every stencil here, and other than each other.
pub(crate) const COUNTS: [&[usize]; 3] = [&[37], &[13, 11], &[9, 10, 11]];

/// The same without the bodies that no particle of a box of these counts is in.
pub(crate) fn without_far_bodies(boundaries: &Value, counts: [usize; 2]) -> Value {
    let is_near = |boundary: &&Value| {
        if boundary.pointer("/source/where").is_some() {
            return false;
        }
        let Some(sphere) = boundary.pointer("/held/where/sphere") else {
            return true;
        };
        let at = |axis: usize| sphere["center"][axis].as_f64().expect("a number");
        let radius = sphere["radius"].as_f64().expect("a number");
        let places = |axis: usize| (0..counts[axis]).map(|k| 0.25 * (k as f64 + 0.5));
        let off =
            |axis: usize| places(axis).map(|x| (x - at(axis)).abs()).fold(f64::INFINITY, f64::min);
        off(0).hypot(off(1)) < radius
    };
    boundaries.as_array().expect("a list").iter().filter(is_near).cloned().collect()
}
