//! The space between two circles.

use std::f64::consts::{FRAC_2_PI, PI};

use glam::DVec3;
use libm::{j0, j1, y0, y1};

use super::modes::{bisect, decay};

/// What an [`Annulus`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct AnnulusSetup {
    /// Centre of both circles, m; z does not matter.
    pub center: DVec3,
    /// Radius a of the inner circle, m, above 0.
    pub inner_radius: f64,
    /// Radius b of the outer circle, m, above a.
    pub outer_radius: f64,
    /// Held value of the inner circle.
    pub inner: f64,
    /// Held value of the outer circle.
    pub outer: f64,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

/// The space between two circles about an axis along z (a hollow cylinder), from a uniform
/// initial value, with both circles held from t = 0. With r the distance from the axis (Carslaw
/// and Jaeger 1959, 7.2 and 13.4)
/// C = inner + (outer - inner) ln(r/a) / ln(b/a) + sum_n A_n U(q_n r) exp(-D q_n^2 t),
/// U(q r) = J0(q r) Y0(q b) - J0(q b) Y0(q r), with q_n the roots of U(q a) = 0.
///
/// Two hundred terms: good to 1e-12 of the jumps for D t >= 1e-4 (b - a)^2. At shorter times, but
/// for t <= 0, it swings about the true value. Between the circles and the axis, and outside of
/// the circles, it has the value of the nearer circle.
#[derive(Clone, Debug, PartialEq)]
pub struct Annulus {
    setup: AnnulusSetup,
    pub(super) modes: Vec<Ring>,
}

impl Annulus {
    /// Finds the terms.
    pub fn new(setup: AnnulusSetup) -> Self {
        let modes = (1..=COUNT).map(|index| Ring::new(index, &setup)).collect();
        Self { setup, modes }
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let setup = &self.setup;
        let radius = (x - setup.center).truncate().length();
        if radius <= setup.inner_radius {
            setup.inner
        } else if radius >= setup.outer_radius {
            setup.outer
        } else if t <= 0.0 {
            setup.initial
        } else {
            self.between(radius, setup.diffusivity * t)
        }
    }

    /// The value at `radius` (m) with `spread` = D t (m2).
    fn between(&self, radius: f64, spread: f64) -> f64 {
        let setup = &self.setup;
        let share =
            (radius / setup.inner_radius).ln() / (setup.outer_radius / setup.inner_radius).ln();
        let steady = setup.inner + (setup.outer - setup.inner) * share;
        let fading = self.modes.iter().map(|ring| (ring, decay(ring.root, spread)));
        let counts = fading.take_while(|&(_, decay)| decay > 0.0);
        steady + counts.map(|(ring, decay)| ring.shape(radius) * decay).sum::<f64>()
    }
}

/// How many terms are kept.
const COUNT: usize = 200;

/// One term of the series.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ring {
    /// q, 1/m.
    pub(super) root: f64,
    /// A J0(q b) and A Y0(q b).
    outer: (f64, f64),
}

impl Ring {
    /// The term of the root number `index`, from 1.
    ///
    /// The angle of J0 + i Y0 grows between q a and q b by at least q (b - a), and by at most
    /// pi / 4 more; it grows by index pi at the root, so that (b - a) q is between
    /// (index - 1/4) pi and index pi.
    /// By Green's identity, with f = initial - steady, both integrals over a <= r <= b,
    /// int r U f = -[r f U'] / q^2 and int r U^2 = [(r U')^2] / (2 q^2); b U'(b) = -2 / pi.
    fn new(index: usize, setup: &AnnulusSetup) -> Self {
        let (a, b) = (setup.inner_radius, setup.outer_radius);
        let (turns, sign) = (index as f64 * PI, if index.is_multiple_of(2) { 1.0 } else { -1.0 });
        let cross = |q: f64| j0(q * a) * y0(q * b) - j0(q * b) * y0(q * a);
        let (low, high) = ((turns - 0.25 * PI) / (b - a), turns / (b - a));
        let q = bisect(low, high, |q| sign * cross(q));
        let (outer_j, outer_y) = (j0(q * b), y0(q * b));
        let inner_slope = -q * a * (j1(q * a) * outer_y - outer_j * y1(q * a));
        let outer_slope = -FRAC_2_PI;
        let overlap = (setup.initial - setup.outer) * outer_slope
            - (setup.initial - setup.inner) * inner_slope;
        let norm = outer_slope * outer_slope - inner_slope * inner_slope;
        let amplitude = -2.0 * overlap / norm;
        Self { root: q, outer: (amplitude * outer_j, amplitude * outer_y) }
    }

    /// A U(q r).
    fn shape(&self, radius: f64) -> f64 {
        let scaled = self.root * radius;
        j0(scaled) * self.outer.1 - self.outer.0 * y0(scaled)
    }
}
