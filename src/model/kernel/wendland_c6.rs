//! Wendland's C6 function of 2-D and 3-D (Wendland 1995, Adv. Comput. Math. 4, 389), also in 1-D
//! with the same polynomial, renormalised.

use std::f64::consts::PI;

use super::Definition;

pub(super) static DEFINITION: Definition = Definition {
    name: "wendland_c6",
    shape,
    shape_dw_over_r,
    sigma: [Some(15.0 / 8.0), Some(78.0 / (7.0 * PI)), Some(1365.0 / (64.0 * PI))],
    finite_at_zero: true,
};

fn shape(q: f64) -> f64 {
    (1.0 - q).powi(8) * (1.0 + q * (8.0 + q * (25.0 + q * 32.0)))
}

fn shape_dw_over_r(q: f64) -> f64 {
    -22.0 * (1.0 - q).powi(7) * (1.0 + q * (7.0 + q * 16.0))
}
