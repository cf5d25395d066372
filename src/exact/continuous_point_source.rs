//! A point source that goes on.

use std::f64::consts::PI;

use glam::DVec3;
use libm::erfc;

use super::exponential_integral::exponential_integral;
use super::half_space::half_space;
use super::side::Condition;

/// A source of constant power at a point of free space from t = 0 on, into a uniform initial value
/// (Carslaw and Jaeger 1959, 10.4). With r the distance from the source and s = sqrt(D t),
/// - 3-D: C = initial + power erfc(r / (2 s)) / (4 pi D r),
/// - 2-D: C = initial + power E1(r^2 / (4 s^2)) / (4 pi D),
/// - 1-D: C = initial + (power / D) (s / sqrt(pi) exp(-r^2 / (4 s^2)) - (r / 2) erfc(r / (2 s))).
///
/// At the source itself it is infinite for t > 0 in 2-D and 3-D, unless the power is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ContinuousPointSource {
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Power over the capacity of a unit volume, value x m^dim/s: of a plane source a unit area,
    /// of a line source a unit length.
    pub power: f64,
    /// Place of the source, m.
    pub at: DVec3,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

impl ContinuousPointSource {
    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        if t <= 0.0 || self.power == 0.0 {
            return self.initial;
        }
        let radius = x.distance(self.at);
        let reach = (self.diffusivity * t).sqrt();
        let scaled = radius / (2.0 * reach);
        let spread = match self.dimension {
            // Half of the power flows to either side.
            1 => half_space(Condition::Robin { biot: 0.0, source: 0.5 }, radius, reach),
            2 => exponential_integral(scaled * scaled) / (4.0 * PI),
            _ => erfc(scaled) / (4.0 * PI * radius),
        };
        self.initial + self.power / self.diffusivity * spread
    }
}
