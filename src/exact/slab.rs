//! A slab between two held faces, and a half space behind one.

use std::f64::consts::PI;

use glam::DVec3;
use libm::erfc;

use super::zero_flux_box::{NEGLIGIBLE_EXPONENT, SWITCH};

/// A slab from a uniform initial value, with a face held on either side from t = 0.
///
/// With X = (x - from) / L, T = D t / L^2 (Carslaw and Jaeger 1959, 3.4 and 12.5; Crank 1975, 4.3):
/// at long times the steady profile plus a sine series,
/// C = left + (right - left) X + sum_n B_n sin(n pi X) exp(-n^2 pi^2 T),
/// B_n = 2/(n pi) ((initial - left) - (-1)^n (initial - right));
/// at short times reflected error functions,
/// C = initial + (left - initial) F(X) + (right - initial) F(1 - X),
/// F(X) = sum_n erfc((2n + X) / 2 sqrt T) - erfc((2n + 2 - X) / 2 sqrt T).
/// Outside of the slab it has the value of the nearer face.
#[derive(Clone, Debug, PartialEq)]
pub struct Slab {
    /// The axis across the slab: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the left face, m.
    pub from: f64,
    /// Coordinate of the right face, m, above `from`.
    pub to: f64,
    /// Held value of the left face.
    pub left: f64,
    /// Held value of the right face.
    pub right: f64,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

impl Slab {
    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let length = self.to - self.from;
        let place = ((x[self.axis] - self.from) / length).clamp(0.0, 1.0);
        let time = self.diffusivity * t / (length * length);
        if place == 0.0 {
            self.left
        } else if place == 1.0 {
            self.right
        } else if time <= 0.0 {
            self.initial
        } else if time < SWITCH {
            self.reflections(place, time)
        } else {
            self.sines(place, time)
        }
    }

    /// The short-time form, for 0 < `place` < 1 and `time` > 0 in units of L and L^2 / D.
    pub(super) fn reflections(&self, place: f64, time: f64) -> f64 {
        let width = 2.0 * time.sqrt();
        let from_face = |depth: f64| {
            let mut sum = 0.0;
            let mut shift = 0.0;
            while (shift / width).powi(2) < NEGLIGIBLE_EXPONENT {
                sum += erfc((shift + depth) / width) - erfc((shift + 2.0 - depth) / width);
                shift += 2.0;
            }
            sum
        };
        self.initial
            + (self.left - self.initial) * from_face(place)
            + (self.right - self.initial) * from_face(1.0 - place)
    }

    /// The long-time form, for 0 < `place` < 1 and `time` > 0 in units of L and L^2 / D.
    pub(super) fn sines(&self, place: f64, time: f64) -> f64 {
        let mut sum = self.left + (self.right - self.left) * place;
        let (mut n, mut sign) = (1.0, -1.0);
        while (n * PI).powi(2) * time < NEGLIGIBLE_EXPONENT {
            let jump = (self.initial - self.left) - sign * (self.initial - self.right);
            let decay = (-(n * PI).powi(2) * time).exp();
            sum += 2.0 / (n * PI) * jump * (n * PI * place).sin() * decay;
            n += 1.0;
            sign = -sign;
        }
        sum
    }
}

/// The half space x >= `from` along an axis, from a uniform initial value, with its surface held
/// from t = 0: C = initial + (surface - initial) erfc(depth / sqrt(4 D t))
/// (Carslaw and Jaeger 1959, 2.4). Outside of the body it has the surface's value.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpace {
    /// The axis into the body: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the surface, m.
    pub from: f64,
    /// Held value of the surface.
    pub surface: f64,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

impl HalfSpace {
    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let depth = x[self.axis] - self.from;
        if depth <= 0.0 {
            return self.surface;
        }
        if t <= 0.0 {
            return self.initial;
        }
        let scaled = depth / (4.0 * self.diffusivity * t).sqrt();
        self.initial + (self.surface - self.initial) * erfc(scaled)
    }
}
