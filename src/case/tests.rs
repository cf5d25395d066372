//! Tests of whole cases.

mod bad;
mod exact;
mod expression;
mod good;
mod limits;
mod shape;
mod shipped;
mod surface;
mod wall;
mod wall_errors;

use serde_json::{Value, json};

use super::{CaseError, Override, Scene, from_json};

/// A small 2-D case to change.
fn base() -> Value {
    json!({
        "title": "base", "dimension": 2,
        "particles": { "spacing": 0.5, "fill": [
            { "shape": { "box": { "min": [0, 0], "max": [4, 2] } }, "material": "rock" }
        ] },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "materials": { "rock": { "diffusivity": "15/year" } },
        "initial": [{ "value": 1 }],
        "boundaries": [
            { "held": { "where": { "box": { "min": [0, 0], "max": [0.5, 2] } }, "value": 3 } }
        ],
        "time": { "end": "2*day" },
        "exact": { "name": "uniform", "value": 2 },
        "probes": [{ "name": "p", "at": [1, 1] }]
    })
}

/// The base case with overrides `path=value`.
fn with(overrides: &[&str]) -> Result<Scene, CaseError> {
    let mut json = base();
    for text in overrides {
        Override::parse(text)?.apply(&mut json)?;
    }
    from_json("base", json, &[])
}
