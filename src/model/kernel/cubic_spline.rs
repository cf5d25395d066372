//! Cubic spline (Monaghan and Lattanzio 1985, Astron. Astrophys. 149, 135), support H = 2 h.

use std::f64::consts::PI;

use super::Definition;

pub(super) static DEFINITION: Definition = Definition {
    name: "cubic_spline",
    shape,
    shape_dw_over_r,
    sigma: [Some(4.0 / 3.0), Some(40.0 / (7.0 * PI)), Some(8.0 / PI)],
    finite_at_zero: true,
};

fn shape(q: f64) -> f64 {
    let s = 2.0 * q;
    if s < 1.0 { 1.0 - s * s * (1.5 - 0.75 * s) } else { 0.25 * (2.0 - s).powi(3) }
}

fn shape_dw_over_r(q: f64) -> f64 {
    let s = 2.0 * q;
    if s < 1.0 { 9.0 * s - 12.0 } else { -3.0 * (2.0 - s).powi(2) / s }
}
