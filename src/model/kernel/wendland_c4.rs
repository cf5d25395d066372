//! Wendland's C4 function of 2-D and 3-D (Wendland 1995, Adv. Comput. Math. 4, 389), also in 1-D
//! with the same polynomial, renormalised.

use std::f64::consts::PI;

use super::Definition;

pub(super) static DEFINITION: Definition = Definition {
    name: "wendland_c4",
    shape,
    shape_dw_over_r,
    sigma: [Some(27.0 / 16.0), Some(9.0 / PI), Some(495.0 / (32.0 * PI))],
    finite_at_zero: true,
};

fn shape(q: f64) -> f64 {
    (1.0 - q).powi(6) * (1.0 + q * (6.0 + q * (35.0 / 3.0)))
}

fn shape_dw_over_r(q: f64) -> f64 {
    (-56.0 / 3.0) * (1.0 - q).powi(5) * (1.0 + 5.0 * q)
}
