//! A box whose faces are held at one value.

use glam::DVec3;

use super::side::Side;
use super::slab::{Slab, SlabSetup};

/// A box from a uniform initial value, whose faces are held at another from t = 0: the product of the
/// slabs across its axes (Carslaw and Jaeger 1959, 1.15 and 5.6),
/// C = wall + (initial - wall) prod_axis s(x_axis, t), with s the slab that starts at 1 between faces at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct QuenchedBox {
    wall: f64,
    initial: f64,
    slabs: Vec<Slab>,
}

impl QuenchedBox {
    /// The box between `min` and `max` (m) across these axes, for a diffusivity in m2/s.
    pub fn new(
        axes: &[usize],
        [min, max]: [DVec3; 2],
        [wall, initial]: [f64; 2],
        diffusivity: f64,
    ) -> Self {
        let slab = |&axis: &usize| {
            Slab::new(SlabSetup {
                axis,
                from: min[axis],
                to: max[axis],
                left: Side::Value(0.0),
                right: Side::Value(0.0),
                initial: 1.0,
                diffusivity,
            })
        };
        Self { wall, initial, slabs: axes.iter().map(slab).collect() }
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let left: f64 = self.slabs.iter().map(|slab| slab.at(x, t)).product();
        self.wall + (self.initial - self.wall) * left
    }
}
