//! Point masses in a box that nothing leaves.
//!
//! In a box the solution is a product of one 1-D solution an axis. The 1-D one, for a unit mass at
//! s in [0, L] with zero flux at both ends, has two forms (Carslaw and Jaeger 1959, 14.3; Crank
//! 1975, 2.2): mirror images, which need few terms at short times,
//! u = 1/sqrt(4 pi D t) sum_n exp(-(x - s - 2 n L)^2 / 4Dt) + exp(-(x + s - 2 n L)^2 / 4Dt),
//! and the cosine series, which needs few terms at long times,
//! u = 1/L (1 + 2 sum_k cos(k pi x / L) cos(k pi s / L) exp(-k^2 pi^2 D t / L^2)).

use std::f64::consts::PI;

use glam::DVec3;

use super::point_source::at_start;

/// D t / L^2 at which the two forms need equally many terms, about five.
const SWITCH: f64 = 1.0 / (2.0 * PI);

/// Terms below exp(-this) of the sum are left out: 4e-18.
pub(super) const NEGLIGIBLE_EXPONENT: f64 = 40.0;

/// A box without flux through its faces.
#[derive(Clone, Debug, PartialEq)]
pub struct ZeroFluxBox {
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Lower corner, m.
    pub min: DVec3,
    /// Upper corner, m.
    pub max: DVec3,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

impl ZeroFluxBox {
    /// The 1-D solution at `x` for a unit mass at `mass` (m), 1/m, for t > 0.
    fn along(&self, axis: usize, x: f64, mass: f64, t: f64) -> f64 {
        let (min, length) = (self.min[axis], self.max[axis] - self.min[axis]);
        let time = self.diffusivity * t / (length * length);
        let (x, mass) = ((x - min) / length, (mass - min) / length);
        let value = if time < SWITCH { images(x, mass, time) } else { cosines(x, mass, time) };
        value / length
    }
}

/// Mirror images, for L = D = 1.
pub(super) fn images(x: f64, mass: f64, time: f64) -> f64 {
    // Image n is worst for x = mass = 1, where it is 2 n - 2 away and the mass itself 0.
    let exponent = |order: f64| (order - 1.0).powi(2) / time;
    let mut orders = 1;
    while exponent(f64::from(orders)) < NEGLIGIBLE_EXPONENT {
        orders += 1;
    }
    let image = |dist: f64| (-dist * dist / (4.0 * time)).exp();
    let pair = |n: i32| {
        let shift = 2.0 * f64::from(n);
        image(x - mass - shift) + image(x + mass - shift)
    };
    (1 - orders..orders).map(pair).sum::<f64>() / (4.0 * PI * time).sqrt()
}

/// Cosine series, for L = D = 1.
pub(super) fn cosines(x: f64, mass: f64, time: f64) -> f64 {
    let mut sum = 1.0;
    let mut k = 1.0;
    while (k * PI).powi(2) * time < NEGLIGIBLE_EXPONENT {
        let wave = (k * PI * x).cos() * (k * PI * mass).cos();
        sum += 2.0 * wave * (-(k * PI).powi(2) * time).exp();
        k += 1.0;
    }
    sum
}

/// A point source in a box without flux through its faces.
///
/// At t = 0 it is 0 away from the source and infinite at it.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSourceInBox {
    /// The box.
    pub walls: ZeroFluxBox,
    /// Integral of porosity x C over the box.
    pub amount: f64,
    /// Place of the source, m.
    pub at: DVec3,
    /// Share of the volume that takes up the substance, 0 to 1.
    pub porosity: f64,
}

impl PointSourceInBox {
    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let axes = 0..self.walls.dimension;
        if t <= 0.0 {
            return at_start(axes.clone().all(|axis| x[axis] == self.at[axis]), self.amount);
        }
        let factor = |axis: usize| self.walls.along(axis, x[axis], self.at[axis], t);
        self.amount / self.porosity * axes.map(factor).product::<f64>()
    }
}

/// 2^dim equal point masses, at `at` -+ separation / 2 along each axis, in a box without flux
/// through its faces: what a deposit on the 2^dim particles around a corner of the lattice's
/// cells spreads like.
///
/// At t = 0 it is 0 away from the masses and infinite at them.
#[derive(Clone, Debug, PartialEq)]
pub struct MassesInBox {
    /// The box.
    pub walls: ZeroFluxBox,
    /// All masses together: the integral of C over the box.
    pub amount: f64,
    /// Centre of the masses, m.
    pub at: DVec3,
    /// Distance of neighbouring masses, m.
    pub separation: f64,
}

impl MassesInBox {
    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let axes = 0..self.walls.dimension;
        let masses =
            |axis: usize| [-0.5, 0.5].map(|offset| self.at[axis] + offset * self.separation);
        if t <= 0.0 {
            return at_start(axes.clone().all(|axis| masses(axis).contains(&x[axis])), self.amount);
        }
        let factor = |axis: usize| {
            let parts = masses(axis).map(|mass| self.walls.along(axis, x[axis], mass, t));
            0.5 * (parts[0] + parts[1])
        };
        self.amount * axes.map(factor).product::<f64>()
    }
}
