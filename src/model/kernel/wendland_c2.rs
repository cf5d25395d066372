//! Wendland's C2 function of 2-D and 3-D (Wendland 1995, Adv. Comput. Math. 4, 389), also in 1-D
//! with the same polynomial, renormalised.

use std::f64::consts::PI;

use super::Definition;

pub(super) static DEFINITION: Definition = Definition {
    name: "wendland_c2",
    shape,
    shape_dw_over_r,
    sigma: [Some(3.0 / 2.0), Some(7.0 / PI), Some(21.0 / (2.0 * PI))],
    finite_at_zero: true,
};

fn shape(q: f64) -> f64 {
    (1.0 - q).powi(4) * (1.0 + 4.0 * q)
}

fn shape_dw_over_r(q: f64) -> f64 {
    -20.0 * (1.0 - q).powi(3)
}
