//! Quintic spline (Morris, Fox and Zhu 1997, J. Comput. Phys. 136, 214), support H = 3 h.

use std::f64::consts::PI;

use super::Definition;

pub(super) static DEFINITION: Definition = Definition {
    name: "quintic_spline",
    shape,
    shape_dw_over_r,
    sigma: [Some(1.0 / 40.0), Some(63.0 / (478.0 * PI)), Some(9.0 / (40.0 * PI))],
    finite_at_zero: true,
};

fn shape(q: f64) -> f64 {
    let s = 3.0 * q;
    let outer = (3.0 - s).powi(5);
    if s < 1.0 {
        outer - 6.0 * (2.0 - s).powi(5) + 15.0 * (1.0 - s).powi(5)
    } else if s < 2.0 {
        outer - 6.0 * (2.0 - s).powi(5)
    } else {
        outer
    }
}

/// The innermost piece is expanded, so that its division by s leaves no 0/0 at the origin.
fn shape_dw_over_r(q: f64) -> f64 {
    let s = 3.0 * q;
    if s < 1.0 {
        9.0 * (-120.0 + s * s * (120.0 - 50.0 * s))
    } else if s < 2.0 {
        -45.0 * ((3.0 - s).powi(4) - 6.0 * (2.0 - s).powi(4)) / s
    } else {
        -45.0 * (3.0 - s).powi(4) / s
    }
}
