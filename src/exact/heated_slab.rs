//! A slab with a source inside.

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

use glam::DVec3;
use libm::erfc;

use super::modes::{COUNT, SHORT, decay};
use super::side::Side;
use super::slab::{Slab, SlabSetup};

/// What a [`HeatedSlab`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatedSlabSetup {
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
    /// Source over the capacity of a unit volume, value/s.
    pub rate: f64,
    /// Diffusivity D, m2/s.
    pub diffusivity: f64,
}

/// A slab from a uniform initial value, between faces held from t = 0, with a uniform source g
/// from t = 0: the slab without a source, and what the source adds between faces at 0. With
/// X = (x - from) / L and T = D t / L^2 (Carslaw and Jaeger 1959, 3.14)
/// C = slab + (g L^2 / D) (X (1 - X) / 2 - sum_n 4 / (n pi)^3 sin(n pi X) exp(-n^2 pi^2 T)), n odd;
/// for T < 0.005, where neither face feels the other, with e and f the distances from the faces
/// over 2 sqrt(D t), C = slab + g t (1 - 4 i2erfc(e) - 4 i2erfc(f)),
/// 4 i2erfc(e) = (1 + 2 e^2) erfc(e) - 2 e exp(-e^2) / sqrt(pi).
///
/// Outside of the slab it has the value of the nearer face.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatedSlab {
    setup: HeatedSlabSetup,
    slab: Slab,
}

impl HeatedSlab {
    /// Finds the waves of the slab without a source.
    pub fn new(setup: HeatedSlabSetup) -> Self {
        let slab = Slab::new(SlabSetup {
            axis: setup.axis,
            from: setup.from,
            to: setup.to,
            left: Side::Value(setup.left),
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
        let unit = length * length / setup.diffusivity;
        let (place, time) = ((x[setup.axis] - setup.from) / length, t / unit);
        let without = self.slab.at(x, t);
        if time <= 0.0 || place <= 0.0 || place >= 1.0 {
            return without;
        }
        let added = if time < SHORT { brief(place, time) } else { lasting(place, time) };
        without + setup.rate * unit * added
    }
}

/// What a unit source adds at short times, in units of L and L^2 / D.
pub(super) fn brief(place: f64, time: f64) -> f64 {
    let taken = |distance: f64| face_takes(distance / (2.0 * time.sqrt()));
    time * (1.0 - taken(place) - taken(1.0 - place))
}

/// 4 i2erfc(e): the share of what came in at a depth, e over 2 sqrt(D t), that a face has taken.
fn face_takes(scaled: f64) -> f64 {
    let share = erfc(scaled);
    if share == 0.0 {
        return 0.0;
    }
    let square = scaled * scaled;
    (1.0 + 2.0 * square) * share - FRAC_2_SQRT_PI * scaled * (-square).exp()
}

/// What a unit source adds at long times, in units of L and L^2 / D.
pub(super) fn lasting(place: f64, time: f64) -> f64 {
    let wave = |index: usize| {
        let root = index as f64 * PI;
        4.0 / root.powi(3) * (root * place).sin() * decay(root, time)
    };
    0.5 * place * (1.0 - place) - (1..=COUNT).step_by(2).map(wave).sum::<f64>()
}
