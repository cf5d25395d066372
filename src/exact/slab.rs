//! A slab between two plane faces.

use std::f64::consts::PI;

use glam::DVec3;

use super::half_space::half_space;
use super::modes::{COUNT, End, Mode, SHORT};
use super::side::{Condition, Side};

/// What a [`Slab`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct SlabSetup {
    /// The axis across the slab: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the left face, m.
    pub from: f64,
    /// Coordinate of the right face, m, above `from`.
    pub to: f64,
    /// What is done to the left face.
    pub left: Side,
    /// What is done to the right face.
    pub right: Side,
    /// Value at t = 0.
    pub initial: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

/// A slab from a uniform initial value, with something done to either face from t = 0.
///
/// With X = (x - from) / L and T = D t / L^2: at long times a profile P that meets both
/// conditions and a series of waves (Carslaw and Jaeger 1959, 3.4, 3.8 to 3.11),
/// C = initial + P(X, T) + sum_n A_n cos(b_n X - a_n) exp(-b_n^2 T);
/// for T < 0.005, where neither face feels the other, the sum of two half spaces' changes.
/// Outside of the slab it has the value of the nearer face.
#[derive(Clone, Debug, PartialEq)]
pub struct Slab {
    setup: SlabSetup,
    /// The faces, the slab's width being the unit of length.
    faces: [Condition; 2],
    profile: Profile,
    pub(super) modes: Vec<Mode>,
}

impl Slab {
    /// Finds the waves.
    pub fn new(setup: SlabSetup) -> Self {
        let length = setup.to - setup.from;
        let condition = |side: Side| side.condition(setup.initial, setup.diffusivity, length);
        let faces = [condition(setup.left), condition(setup.right)];
        let profile = Profile::new(faces);
        let ends = [0.0, 1.0].map(|place| {
            let (value, slope) = (-profile.at(place, 0.0), -profile.slope_at(place));
            End { value, slope }
        });
        // Of all profiles that grow at the given rate it is the one whose mean starts from 0, so
        // that there is no constant wave.
        let first = usize::from(profile.grows);
        let mode = |index: usize| Mode::new(index, index as f64 * PI, faces, ends);
        let modes = (first..first + COUNT).map(mode).collect();
        Self { setup, faces, profile, modes }
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let setup = &self.setup;
        let length = setup.to - setup.from;
        let place = ((x[setup.axis] - setup.from) / length).clamp(0.0, 1.0);
        let time = setup.diffusivity * t / (length * length);
        match (setup.left.held(), setup.right.held()) {
            (Some(value), _) if place == 0.0 => value,
            (_, Some(value)) if place == 1.0 => value,
            _ if time <= 0.0 => setup.initial,
            _ if time < SHORT => setup.initial + self.half_spaces(place, time),
            _ => setup.initial + self.waves(place, time),
        }
    }

    /// The change since t = 0 at short times, in units of L and L^2 / D.
    pub(super) fn half_spaces(&self, place: f64, time: f64) -> f64 {
        let reach = time.sqrt();
        half_space(self.faces[0], place, reach) + half_space(self.faces[1], 1.0 - place, reach)
    }

    /// The change since t = 0 at long times, in units of L and L^2 / D.
    pub(super) fn waves(&self, place: f64, time: f64) -> f64 {
        let waves: f64 = self.modes.iter().map(|mode| mode.at(place, time)).sum();
        self.profile.at(place, time) + waves
    }
}

/// base + slope X + growth (X^2 / 2 + T): what meets both conditions without the waves. It is
/// steady unless both faces have a given flux.
#[derive(Clone, Debug, PartialEq)]
struct Profile {
    base: f64,
    slope: f64,
    growth: f64,
    /// Whether no face holds the value back.
    grows: bool,
}

impl Profile {
    /// The steady line between the faces or, where nothing holds the value back, the parabola
    /// of mean T growth (Carslaw and Jaeger 1959, 3.8).
    fn new(faces: [Condition; 2]) -> Self {
        let [(p, q, s), (p1, q1, s1)] = faces.map(Condition::weights);
        let determinant = p * (p1 + q1) + p1 * q;
        if determinant == 0.0 {
            return Self { base: s / 3.0 - s1 / 6.0, slope: -s, growth: s + s1, grows: true };
        }
        let base = (s * (p1 + q1) + q * s1) / determinant;
        let slope = (p * s1 - p1 * s) / determinant;
        Self { base, slope, growth: 0.0, grows: false }
    }

    fn at(&self, place: f64, time: f64) -> f64 {
        self.base + self.slope * place + self.growth * (0.5 * place * place + time)
    }

    fn slope_at(&self, place: f64) -> f64 {
        self.slope + self.growth * place
    }
}
