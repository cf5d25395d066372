//! Scenes that are a lattice in part, of every kind.

use diffusph::case;
use diffusph::model::{KernelKind, Problem};
use serde_json::{Value, json};

use super::boxes::sources_and_boundaries;

/// The lattice distance of every scene here, m.
pub(crate) const SPACING: f64 = 0.25;

/// Counts past twice the reach of every stencil here, and other than each other.
pub(crate) const COUNTS: [&[usize]; 3] = [&[61], &[23, 19], &[12, 13, 11]];

/// Lower and upper corner of a part of the box, as fractions of it.
pub(crate) fn part(dimension: usize, from: f64, to: f64) -> Value {
    let counts = COUNTS[dimension - 1];
    // Whole spacings along x, which is what is cut.
    let along = |axis: usize, share: f64, whole: f64| {
        let share = if axis == 0 { share } else { whole };
        (share * counts[axis] as f64).round() * SPACING
    };
    let corner = |share: f64, whole: f64| -> Vec<f64> {
        (0..dimension).map(|axis| along(axis, share, whole)).collect()
    };
    json!({ "box": { "min": corner(from, 0.0), "max": corner(to, 1.0) } })
}

/// A ball whose centre is at this fraction of the box along every axis.
pub(crate) fn ball(dimension: usize, at: f64, radius: f64) -> Value {
    let center = |axis: usize| at * COUNTS[dimension - 1][axis] as f64 * SPACING;
    let center: Vec<f64> = (0..dimension).map(center).collect();
    json!({ "sphere": { "center": center, "radius": radius } })
}

pub(crate) fn cut(of: &Value, minus: &[Value]) -> Value {
    json!({ "difference": { "of": of, "minus": minus } })
}

/// A scene of these shapes, each of its own material.
pub(crate) fn scene(
    kernel: KernelKind,
    support_ratio: f64,
    dimension: usize,
    shapes: &[(Value, f64)],
    boundaries: &[Value],
) -> Problem {
    let wave = ["7.3*x", "7.3*x + 5.1*y", "7.3*x + 5.1*y - 3.7*z"][dimension - 1];
    let name = |k: usize| format!("m{k}");
    let fill =
        |(k, (shape, _)): (usize, &(Value, f64))| json!({ "shape": shape, "material": name(k) });
    let material = |(k, (_, diffusivity)): (usize, &(Value, f64))| {
        // Every other material has a heat capacity of its own: rho c = 0.5.
        (
            name(k),
            match k % 2 {
                0 => json!({ "diffusivity": diffusivity }),
                _ => json!({
                    "conductivity": 0.5 * diffusivity, "density": 2, "heat_capacity": 0.25
                }),
            },
        )
    };
    let (sources, boundaries) = sources_and_boundaries(json!(boundaries));
    let case = json!({
        "title": "mixed",
        "dimension": dimension,
        "particles": {
            "spacing": SPACING,
            "fill": shapes.iter().enumerate().map(fill).collect::<Vec<_>>()
        },
        "kernel": { "name": kernel.name(), "support_ratio": support_ratio },
        "materials": shapes.iter().enumerate().map(material).collect::<serde_json::Map<_, _>>(),
        "initial": [{ "value": format!("300 + 10*sin({wave})") }],
        "boundaries": boundaries,
        "sources": sources,
        "time": { "end": 1 }
    });
    case::from_json("mixed", case, &[]).unwrap_or_else(|error| panic!("{error}")).problem
}

/// Names of the faces of some axes.
pub(crate) fn faces(axes: &[&str]) -> Vec<String> {
    axes.iter().flat_map(|axis| ["min", "max"].map(|end| format!("{axis}_{end}"))).collect()
}

/// Problems of every kind that the mixed path takes, by name.
pub(crate) fn problems(
    kernel: KernelKind,
    support_ratio: f64,
    dimension: usize,
) -> Vec<(&'static str, Problem)> {
    let axes = &["x", "y", "z"][..dimension];
    let make = |shapes: &[(Value, f64)], boundaries: &[Value]| {
        scene(kernel, support_ratio, dimension, shapes, boundaries)
    };
    let whole = part(dimension, 0.0, 1.0);
    let hole = ball(dimension, 0.45, 0.6);
    let holed = vec![(cut(&whole, std::slice::from_ref(&hole)), 0.7)];
    let layers = vec![
        (part(dimension, 0.0, 0.3), 1.0),
        (part(dimension, 0.3, 0.6), 1e-6),
        (part(dimension, 0.6, 1.0), 0.3),
    ];
    let two = vec![(part(dimension, 0.0, 0.4), 1e-3), (part(dimension, 0.4, 1.0), 0.9)];
    let inclusion = ball(dimension, 0.7, 0.5);
    let included = vec![(cut(&whole, std::slice::from_ref(&inclusion)), 0.7), (inclusion, 5.0)];
    let all = |kind: Value| json!({ "wall": { "faces": faces(axes), "kind": kind } });
    let periodic = json!({ "periodic": { "axes": axes } });
    let held = json!({ "held": { "where": ball(dimension, 0.75, 0.7), "value": "250 + 3*x" } });
    let convection = json!({ "convection": { "coefficient": 2, "ambient": "290 + 3*x" } });
    let varying = json!({ "convection": { "coefficient": "2 + x", "ambient": 290 } });
    let patch = |kind: Value, from: f64| {
        let mut lower: Vec<f64> = vec![0.0; dimension];
        let mut upper: Vec<f64> =
            COUNTS[dimension - 1].iter().map(|&count| count as f64 * SPACING).collect();
        upper[0] = 0.0;
        if let Some(y) = lower.get_mut(1) {
            *y = from;
        }
        let region = json!({ "box": { "min": lower, "max": upper } });
        json!({ "wall": { "faces": ["x_min"], "where": region, "kind": kind } })
    };
    let surface = |kind: Value| json!({ "surface": { "of": hole, "kind": kind } });
    let mut list = vec![
        ("hole", make(&holed, &[])),
        ("hole, periodic", make(&holed, std::slice::from_ref(&periodic))),
        ("hole beside a held ball", make(&holed, std::slice::from_ref(&held))),
        ("hole at a corner, insulated", {
            let corner = ball(dimension, 0.0, 0.9);
            make(&[(cut(&whole, &[corner]), 0.7)], &[all(json!("insulated"))])
        }),
        ("hole, values", make(&holed, &[all(json!({ "value": "300 + 20*x" }))])),
        (
            "hole, fluxes and held",
            make(&holed, &[all(json!({ "flux": "sin(30*t)" })), held.clone()]),
        ),
        (
            "hole, sources",
            make(
                &holed,
                &[
                    all(json!({ "value": 310 })),
                    held.clone(),
                    json!({ "source": { "rate": "200*cos(30*t) + x", "linear": "-3 - x" } }),
                    json!({ "source": { "linear": 0.7, "where": ball(dimension, 0.7, 1.0) } }),
                ],
            ),
        ),
        (
            "layers, sources",
            make(&layers, &[all(json!({ "flux": 1 })), json!({ "source": { "rate": 90 } })]),
        ),
        ("hole, convection", make(&holed, &[all(convection.clone())])),
        ("layers", make(&layers, &[])),
        ("layers, periodic", make(&layers, std::slice::from_ref(&periodic))),
        ("layers, values", make(&layers, &[all(json!({ "value": "300 + 5*t" }))])),
        ("two layers, fluxes", make(&two, &[all(json!({ "flux": 3 }))])),
        ("two layers, convection", make(&two, &[all(convection.clone())])),
        ("two layers, convection and held", make(&two, &[all(convection.clone()), held.clone()])),
        ("varying coefficient", make(&[(whole.clone(), 0.7)], &[all(varying)])),
        ("convection beside free faces", {
            let wall = json!({ "wall": { "faces": ["x_max"], "kind": convection } });
            make(&holed, &[wall])
        }),
    ];
    if dimension > 1 {
        list.extend([
            ("ball", make(&[(ball(dimension, 0.5, 1.2), 0.7)], &[])),
            ("inclusion", make(&included, &[])),
            ("inclusion, insulated", make(&included, &[all(json!("insulated"))])),
            (
                "patch over free",
                make(&[(whole.clone(), 0.7)], &[patch(json!({ "value": 280 }), 1.0)]),
            ),
            (
                "patches",
                make(
                    &[(whole.clone(), 0.7)],
                    &[
                        patch(json!({ "flux": "2 + sin(9*t)" }), 1.0),
                        json!({ "wall": { "faces": faces(axes), "kind": { "value": 310 } } }),
                    ],
                ),
            ),
            ("surface, flux", make(&holed, &[surface(json!({ "flux": "1 + t" }))])),
            (
                "surface, convection",
                make(&holed, &[surface(convection.clone()), held, all(json!({ "value": 300 }))]),
            ),
            ("surface of a ball", {
                let body = ball(dimension, 0.5, 1.2);
                let around = json!({ "surface": { "of": body, "kind": convection } });
                make(&[(body, 0.7)], &[around])
            }),
            ("between the sites", {
                let counts = COUNTS[dimension - 1];
                let max: Vec<f64> = counts.iter().map(|&n| (n as f64 + 0.3) * SPACING).collect();
                let odd = json!({ "box": { "min": vec![0; dimension], "max": max } });
                make(&[(odd, 0.7)], &[all(json!({ "value": "300 + x" }))])
            }),
        ]);
    }
    list
}
