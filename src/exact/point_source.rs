//! A point source in free space.

use glam::DVec3;

/// The fundamental solution, the report's (122):
/// C = amount / (porosity (4 pi D t)^(dim/2)) exp(-r^2 / (4 D t))
/// (Carslaw and Jaeger 1959, 10.2; Crank 1975, 3.2).
///
/// At t = 0 it is 0 away from the source and infinite at it.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSource {
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Integral of porosity x C over space.
    pub amount: f64,
    /// Place of the source, m.
    pub at: DVec3,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
    /// Share of the volume that takes up the substance, 0 to 1.
    pub porosity: f64,
}

impl PointSource {
    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let square = x.distance_squared(self.at);
        if t <= 0.0 {
            return at_start(square == 0.0, self.amount);
        }
        let spread = 4.0 * self.diffusivity * t;
        let norm = (std::f64::consts::PI * spread).sqrt().powi(self.dimension as i32);
        self.amount / (self.porosity * norm) * (-square / spread).exp()
    }
}

/// The value of a point mass at t = 0: 0 away from it, infinite at it unless the amount is 0.
pub(super) fn at_start(at_the_mass: bool, amount: f64) -> f64 {
    if at_the_mass && amount != 0.0 { amount * f64::INFINITY } else { 0.0 }
}
