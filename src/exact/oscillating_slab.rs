//! A slab one face of which swings.

use std::f64::consts::PI;

use errorfunctions::ComplexErrorFunctions;
use glam::DVec3;
use num_complex::Complex64;

use super::modes::{COUNT, SHORT, decay};
use super::side::Side;
use super::slab::{Slab, SlabSetup};

/// What an [`OscillatingSlab`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct OscillatingSlabSetup {
    /// The axis across the slab: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the left face, m.
    pub from: f64,
    /// Coordinate of the right face, m, above `from`.
    pub to: f64,
    /// Value that the left face swings about.
    pub mean: f64,
    /// Greatest departure from it.
    pub amplitude: f64,
    /// Angular frequency w, rad/s.
    pub angular_frequency: f64,
    /// Held value of the right face.
    pub right: f64,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

/// A slab from a uniform initial value whose left face is held at mean + amplitude sin(w t) from
/// t = 0, and the right face at a value.
///
/// It is the [`Slab`] with the left face held at the mean, plus amplitude times what sin(w t)
/// alone does. With X = (x - from) / L, T = D t / L^2 and W = w L^2 / D, at long times that is
/// Im(exp(i w t) sinh(k (1 - X)) / sinh k), k = sqrt(i W), what remains in the end, and
/// sum_n 2 n pi W / ((n pi)^4 + W^2) sin(n pi X) exp(-(n pi)^2 T)
/// (Carslaw and Jaeger 1959, 3.6); for T < 0.005 a half space's (the same, 2.6).
#[derive(Clone, Debug, PartialEq)]
pub struct OscillatingSlab {
    setup: OscillatingSlabSetup,
    slab: Slab,
}

impl OscillatingSlab {
    /// Finds the waves.
    pub fn new(setup: OscillatingSlabSetup) -> Self {
        let slab = Slab::new(SlabSetup {
            axis: setup.axis,
            from: setup.from,
            to: setup.to,
            left: Side::Value(setup.mean),
            right: Side::Value(setup.right),
            initial: setup.initial,
            diffusivity: setup.diffusivity,
        });
        Self { setup, slab }
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let setup = &self.setup;
        let length = setup.to - setup.from;
        let place = ((x[setup.axis] - setup.from) / length).clamp(0.0, 1.0);
        if place == 0.0 {
            return setup.mean + setup.amplitude * (setup.angular_frequency * t.max(0.0)).sin();
        }
        let unit = length * length / setup.diffusivity;
        self.slab.at(x, t)
            + setup.amplitude * swing(place, t.max(0.0) / unit, setup.angular_frequency * unit)
    }
}

/// The answer at X > 0 to sin(`frequency` x `time`) at X = 0, in units of L and L^2 / D.
fn swing(place: f64, time: f64, frequency: f64) -> f64 {
    if place == 1.0 || time == 0.0 || frequency == 0.0 {
        0.0
    } else if time < SHORT {
        starting(place, time, frequency)
    } else {
        lasting(place, time, frequency) + fading(place, time, frequency)
    }
}

/// A half space's answer, for `place` and `time` above 0: with s = sqrt(T), e = X / (2 s) and
/// z = sqrt(i W T), Im(exp(i W T - k X) erfc(e - z) + exp(i W T + k X) erfc(e + z)) / 2, which is
/// exp(-e^2) Im(erfcx(e - z) + erfcx(e + z)) / 2.
pub(super) fn starting(place: f64, time: f64, frequency: f64) -> f64 {
    let scaled = place / (2.0 * time.sqrt());
    let decay = (-scaled * scaled).exp();
    let turn = Complex64::new(0.0, frequency * time);
    let root = turn.sqrt();
    let term = |x: Complex64| if decay == 0.0 { Complex64::ZERO } else { decay * x.erfcx() };
    let behind = if scaled < root.re {
        // erfcx(x) = 2 exp(x^2) - erfcx(-x).
        2.0 * (turn - 2.0 * scaled * root).exp() - term(root - scaled)
    } else {
        term(scaled - root)
    };
    0.5 * (behind + term(root + scaled)).im
}

/// What remains in the end, for `frequency` other than 0.
pub(super) fn lasting(place: f64, time: f64, frequency: f64) -> f64 {
    let k = Complex64::new(0.0, frequency).sqrt();
    let turn = Complex64::new(0.0, frequency * time);
    // Numerator and denominator over exp(k): neither overflows. For small k sinh keeps its digits.
    let share = if k.re < 1.0 {
        (k * (1.0 - place)).sinh() / k.sinh() * turn.exp()
    } else {
        let mirror = 1.0 - (-2.0 * k * (1.0 - place)).exp();
        (turn - k * place).exp() * mirror / (1.0 - (-2.0 * k).exp())
    };
    share.im
}

/// What fades away.
pub(super) fn fading(place: f64, time: f64, frequency: f64) -> f64 {
    let wave = |index: usize| {
        let root = index as f64 * PI;
        let share = 2.0 * root * frequency / (root.powi(4) + frequency * frequency);
        share * (root * place).sin() * decay(root, time)
    };
    (1..=COUNT).map(wave).sum()
}
