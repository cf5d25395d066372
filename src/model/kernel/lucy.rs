//! Lucy's kernel (Lucy 1977, Astron. J. 82, 1013), the report's (183) and, as F, (184).

use std::f64::consts::PI;

use super::Definition;

pub(super) static DEFINITION: Definition = Definition {
    name: "lucy",
    shape,
    shape_dw_over_r,
    sigma: [Some(5.0 / 4.0), Some(5.0 / PI), Some(105.0 / (16.0 * PI))],
    finite_at_zero: true,
};

fn shape(q: f64) -> f64 {
    (1.0 - q).powi(3) * (1.0 + 3.0 * q)
}

fn shape_dw_over_r(q: f64) -> f64 {
    -12.0 * (1.0 - q).powi(2)
}
