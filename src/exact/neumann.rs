//! Melting and freezing of a half space.

use std::f64::consts::PI;

use errorfunctions::RealErrorFunctions;
use glam::DVec3;
use libm::erf;

use super::modes::bisect;

/// What conducts heat in one phase of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Conductivity k, W/(m K).
    pub conductivity: f64,
    /// Capacity rho c of a unit volume, J/(m3 K).
    pub capacity: f64,
}

impl Phase {
    /// Diffusivity k / (rho c), m2/s.
    pub fn diffusivity(&self) -> f64 {
        self.conductivity / self.capacity
    }

    /// Effusivity sqrt(k rho c).
    fn effusivity(&self) -> f64 {
        (self.conductivity * self.capacity).sqrt()
    }
}

/// What a [`Neumann`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct NeumannSetup {
    /// The axis into the body: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the wall, m.
    pub at: f64,
    /// Whether the body lies above the wall, else below it.
    pub above: bool,
    /// Temperature at t = 0, K: at the melting temperature, or across it from the wall's.
    pub initial: f64,
    /// Held temperature of the wall, K, which is not the melting temperature.
    pub wall: f64,
    /// Melting temperature, K.
    pub melting: f64,
    /// Latent heat L of a unit volume, J/m3, above 0.
    pub latent_heat: f64,
    /// Below the melting temperature.
    pub solid: Phase,
    /// Above the melting temperature.
    pub liquid: Phase,
}

/// Neumann's solution of the two-phase Stefan problem: a half space from a uniform temperature T0
/// whose surface is held at Tw from t = 0, with the melting temperature Tm between them, so that
/// it melts (Tw > Tm) or freezes (Tw < Tm) from the wall on (Carslaw and Jaeger 1959, 11.2 III).
/// With n the phase next to the wall, f the one far from it, and z the depth (m), the front is at
/// X = 2 lambda sqrt(D_n t), and with m = lambda sqrt(D_n / D_f)
/// - up to it T = Tw + (Tm - Tw) erf(z / (2 sqrt(D_n t))) / erf(lambda),
/// - beyond it T = T0 + (Tm - T0) erfc(z / (2 sqrt(D_f t))) / erfc(m);
///
/// and the balance of energy at the front, with e the effusivity sqrt(k rho c), gives lambda:
/// sqrt(pi) L lambda sqrt(D_n) + e_f |Tm - T0| exp(-m^2) / erfc(m)
/// = e_n |Tw - Tm| exp(-lambda^2) / erf(lambda).
///
/// A body that starts at the melting temperature stays there beyond the front: Stefan's one-phase
/// solution. Nothing moves, so that a unit volume melts to a unit volume, whatever the densities.
/// Outside of the body it has the wall's temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Neumann {
    setup: NeumannSetup,
    lambda: f64,
}

impl Neumann {
    /// Finds lambda.
    pub fn new(setup: NeumannSetup) -> Self {
        let (near, far) = phases(&setup);
        let slowness = (near.diffusivity() / far.diffusivity()).sqrt();
        let arrives = near.effusivity() * (setup.wall - setup.melting).abs();
        let leaves = far.effusivity() * (setup.melting - setup.initial).abs();
        let melts = PI.sqrt() * setup.latent_heat * near.diffusivity().sqrt();
        // exp(-m^2) / erfc(m) is 1 / erfcx(m), which does not underflow.
        let missing = |lambda: f64| {
            melts * lambda + leaves / (lambda * slowness).erfcx()
                - arrives * (-lambda * lambda).exp() / erf(lambda)
        };
        let lambda = bisect(0.0, FASTEST, missing);
        Self { setup, lambda }
    }

    /// Whether the body starts at the melting temperature: Stefan's one-phase solution.
    pub fn is_one_phase(&self) -> bool {
        self.setup.initial == self.setup.melting
    }

    /// Half the depth of the front in units of sqrt(D t), with D of the phase next to the wall.
    pub fn lambda(&self) -> f64 {
        self.lambda
    }

    /// The depth of the front behind the wall (m) at time `t` (s).
    pub fn front(&self, t: f64) -> f64 {
        let (near, _) = phases(&self.setup);
        2.0 * self.lambda * (near.diffusivity() * t.max(0.0)).sqrt()
    }

    /// How much of a body of this extent (m) along x is liquid at time `t` (s), m; `None` where x is not the
    /// axis into the body.
    pub fn liquid_depth(&self, t: f64, extent: DVec3) -> Option<f64> {
        let melts = self.setup.wall > self.setup.melting;
        let front = self.front(t).min(extent.x);
        (self.setup.axis == 0).then_some(if melts { front } else { extent.x - front })
    }

    /// How far behind the wall `x` is, m.
    fn depth(&self, x: DVec3) -> f64 {
        let height = x[self.setup.axis] - self.setup.at;
        if self.setup.above { height } else { -height }
    }

    /// Whether it is liquid at position `x` (m) and time `t` (s): what is ahead of the front has not
    /// melted or frozen yet, also where it starts at the melting temperature.
    pub fn is_liquid(&self, x: DVec3, t: f64) -> bool {
        let depth = self.depth(x);
        let is_behind = depth <= 0.0 || depth < self.front(t);
        is_behind == (self.setup.wall > self.setup.melting)
    }

    /// The temperature at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let setup = &self.setup;
        let depth = self.depth(x);
        if depth <= 0.0 {
            return setup.wall;
        }
        if t <= 0.0 {
            return setup.initial;
        }
        let (near, far) = phases(setup);
        let scaled = |phase: &Phase| depth / (2.0 * (phase.diffusivity() * t).sqrt());
        if scaled(near) < self.lambda {
            return setup.wall
                + (setup.melting - setup.wall) * erf(scaled(near)) / erf(self.lambda);
        }
        let front = self.lambda * (near.diffusivity() / far.diffusivity()).sqrt();
        setup.initial + (setup.melting - setup.initial) * erfc_ratio(scaled(far), front)
    }
}

/// exp(-lambda^2) is 0 here: no front is as fast.
const FASTEST: f64 = 28.0;

/// The phase next to the wall and the other one.
fn phases(setup: &NeumannSetup) -> (&Phase, &Phase) {
    match setup.wall > setup.melting {
        true => (&setup.liquid, &setup.solid),
        false => (&setup.solid, &setup.liquid),
    }
}

/// erfc(x) / erfc(y) for x >= y >= 0, also where both underflow.
fn erfc_ratio(x: f64, y: f64) -> f64 {
    let decay = ((y - x) * (y + x)).exp();
    if decay == 0.0 { 0.0 } else { decay * x.erfcx() / y.erfcx() }
}
