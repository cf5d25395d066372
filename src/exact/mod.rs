//! Analytic solutions.

use glam::DVec3;

use crate::model::ScalarField;

/// An analytic solution, evaluated at a position (m) and a time (s).
#[derive(Clone, Debug)]
pub enum Solution {
    /// The same value everywhere.
    Uniform {
        /// The value.
        value: f64,
    },
    /// offset + gradient . x, e.g. the report's (120).
    Affine {
        /// Value at the origin.
        offset: f64,
        /// Gradient, 1/m.
        gradient: DVec3,
    },
    /// An expression of the case file.
    Expression(ScalarField),
}
