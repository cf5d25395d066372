//! A half space behind a plane surface.

use std::f64::consts::FRAC_2_SQRT_PI;

use errorfunctions::RealErrorFunctions;
use glam::DVec3;
use libm::erfc;

use super::side::{Condition, Side};

/// The half space x >= `from` along an axis, from a uniform initial value, with something done to
/// its surface from t = 0. With z the depth (m), s = sqrt(D t) and e = z / (2 s) (Carslaw and
/// Jaeger 1959, 2.4, 2.9 and 2.7):
/// - held: C = initial + (surface - initial) erfc(e),
/// - flux q: C = initial + (2 q / D) (s / sqrt(pi) exp(-e^2) - (z / 2) erfc(e)),
/// - convection, h = U / D: C = initial
///   + (ambient - initial) (erfc(e) - exp(h z + h^2 s^2) erfc(e + h s)).
///
/// Outside of the body it has the surface's value.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpace {
    /// The axis into the body: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the surface, m.
    pub from: f64,
    /// What is done to the surface.
    pub surface: Side,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

impl HalfSpace {
    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let depth = (x[self.axis] - self.from).max(0.0);
        match self.surface.held() {
            Some(value) if depth == 0.0 => value,
            _ if t <= 0.0 => self.initial,
            _ => {
                let condition = self.surface.condition(self.initial, self.diffusivity, 1.0);
                self.initial + half_space(condition, depth, (self.diffusivity * t).sqrt())
            }
        }
    }
}

/// The change since t = 0 at `depth` behind a plane surface, with `reach` = sqrt(D t) > 0.
pub(super) fn half_space(condition: Condition, depth: f64, reach: f64) -> f64 {
    let scaled = depth / (2.0 * reach);
    match condition {
        Condition::Held(value) => value * erfc(scaled),
        Condition::Robin { biot, source } => source * exchange(biot, scaled, reach),
    }
}

/// The change c behind a surface where dc/dn + h c = 1, for any sign of h: with e the depth over
/// 2 s, s = sqrt(D t) and erfcx(x) = exp(x^2) erfc(x),
/// c = exp(-e^2) (erfcx(e) - erfcx(e + h s)) / h,
/// which is the convection of Carslaw and Jaeger (1959), 2.7, over h, without its overflow.
fn exchange(h: f64, scaled: f64, reach: f64) -> f64 {
    let decay = (-scaled * scaled).exp();
    if decay == 0.0 {
        return 0.0;
    }
    let step = h * reach;
    if step.abs() < SMALL_STEP {
        return decay * reach * mean_descent(scaled, step);
    }
    decay * (scaled.erfcx() - (scaled + step).erfcx()) / h
}

/// Below this the difference of two values of erfcx is taken as the integral of its derivative:
/// the difference would lose digits, and at h = 0, a given flux, all of them.
pub(super) const SMALL_STEP: f64 = 0.1;

/// Nodes and weights of Gauss and Legendre's rule on [-1, 1] (Abramowitz and Stegun 1964, table
/// 25.4). Up to `SMALL_STEP` its error here is below 1e-17.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// The mean of -erfcx'(x) = 2 / sqrt(pi) - 2 x erfcx(x) from `start` to `start + step`.
pub(super) fn mean_descent(start: f64, step: f64) -> f64 {
    let descent = |x: f64| FRAC_2_SQRT_PI - 2.0 * x * x.erfcx();
    let part =
        |(node, weight): (f64, f64)| 0.5 * weight * descent(start + 0.5 * (1.0 + node) * step);
    GAUSS.into_iter().map(part).sum()
}
