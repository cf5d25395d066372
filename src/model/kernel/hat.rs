//! The hat (21), in 1-D. Its W'(r)/r diverges at r = 0, so two particles must not coincide.

use super::Definition;

pub(super) static DEFINITION: Definition = Definition {
    name: "hat",
    shape,
    shape_dw_over_r,
    sigma: [Some(1.0), None, None],
    finite_at_zero: false,
};

fn shape(q: f64) -> f64 {
    1.0 - q
}

fn shape_dw_over_r(q: f64) -> f64 {
    -1.0 / q
}
