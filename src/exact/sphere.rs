//! A solid sphere.

use std::f64::consts::PI;

use glam::DVec3;

use super::half_space::half_space;
use super::modes::{COUNT, End, Mode, SHORT, decay};
use super::side::{Condition, Side};

/// What a [`Sphere`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereSetup {
    /// Centre, m.
    pub center: DVec3,
    /// Radius R, m.
    pub radius: f64,
    /// What is done to the surface.
    pub surface: Side,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

/// A solid sphere from a uniform initial value, with something done to its surface from t = 0.
///
/// With r = |x - center| / R, T = D t / R^2 and c = C - initial, the product u = r c obeys the
/// plane equation on 0 <= r <= 1, is 0 at r = 0, and where dc/dr + B c = s at the surface, there
/// du/dr + (B - 1) u = s. At long times c is a profile that meets the condition and a series of
/// waves (Carslaw and Jaeger 1959, 9.3, 9.4 and 9.7),
/// c = P(r, T) + sum_n A_n sin(b_n r) / r exp(-b_n^2 T);
/// for T < 0.005, where the middle does not feel the surface, u is a half space's.
/// Outside of the sphere it has the value of the surface. Long times lose digits at a small Biot
/// number B: the error is about 1e-16 / B of ambient - initial.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    setup: SphereSetup,
    /// The condition on u, the radius being the unit of length.
    plane: Condition,
    /// P = base + growth (r^2 / 2 + 3 T).
    base: f64,
    growth: f64,
    pub(super) modes: Vec<Mode>,
}

impl Sphere {
    /// Finds the waves.
    pub fn new(setup: SphereSetup) -> Self {
        let condition = setup.surface.condition(setup.initial, setup.diffusivity, setup.radius);
        let (plane, base, growth) = match condition {
            Condition::Held(value) => (condition, value, 0.0),
            Condition::Robin { biot, source } => {
                let plane = Condition::Robin { biot: biot - 1.0, source };
                if is_free(plane) {
                    // -3/10 makes the mean of the growing profile start from 0.
                    (plane, -0.3 * source, source)
                } else {
                    (plane, source / biot, 0.0)
                }
            }
        };
        Self { setup, plane, base, growth, modes: waves(plane, base, growth) }
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let setup = &self.setup;
        let place = (x.distance(setup.center) / setup.radius).min(1.0);
        let time = setup.diffusivity * t / (setup.radius * setup.radius);
        match setup.surface.held() {
            Some(value) if place == 1.0 => value,
            _ if time <= 0.0 => setup.initial,
            _ if time < SHORT => setup.initial + self.half_space(place, time),
            _ => setup.initial + self.waves(place, time),
        }
    }

    /// The change since t = 0 at short times, in units of R and R^2 / D.
    pub(super) fn half_space(&self, place: f64, time: f64) -> f64 {
        // At the centre u is below 1e-22, so that a place beside it does as well.
        let place = place.max(1e-3);
        half_space(self.plane, 1.0 - place, time.sqrt()) / place
    }

    /// The change since t = 0 at long times, in units of R and R^2 / D.
    pub(super) fn waves(&self, place: f64, time: f64) -> f64 {
        let wave = |mode: &Mode| {
            let angle = mode.root * place;
            // sin(b r) / r, which is b at the centre.
            let shape = mode.root * if angle == 0.0 { 1.0 } else { angle.sin() / angle };
            mode.amplitude * shape * decay(mode.root, time)
        };
        let profile = self.base + self.growth * (0.5 * place * place + 3.0 * time);
        profile + self.modes.iter().map(wave).sum::<f64>()
    }
}

/// Whether the surface holds nothing back, so that a profile of a given flux keeps growing.
fn is_free(plane: Condition) -> bool {
    matches!(plane, Condition::Robin { biot: -1.0, .. })
}

/// The waves of u, which start from minus r P.
fn waves(plane: Condition, base: f64, growth: f64) -> Vec<Mode> {
    let center = End { value: 0.0, slope: -base };
    let surface = End { value: -(base + 0.5 * growth), slope: -(base + 1.5 * growth) };
    // With the flux given, u = r is no wave: the profile has it.
    let first = usize::from(is_free(plane));
    let mode = |index: usize| {
        let low = (index as f64 * PI).max(trivial(plane));
        Mode::new(index, low, [Condition::Held(0.0), plane], [center, surface])
    };
    (first..first + COUNT).map(mode).collect()
}

/// Where b - a0(b) - a1(b) has its minimum, between the root b = 0, which is no wave, and the
/// first wave's; 0 if it only rises.
fn trivial(plane: Condition) -> f64 {
    match plane {
        Condition::Robin { biot, .. } if biot < 0.0 => (-biot * (1.0 + biot)).max(0.0).sqrt(),
        _ => 0.0,
    }
}
