//! Two bodies that touch.

use glam::DVec3;
use libm::erf;

/// A half space of a material, from a uniform initial value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfBody {
    /// Value at t = 0.
    pub initial: f64,
    /// Conductivity k.
    pub conductivity: f64,
    /// Capacity rho c of a unit volume.
    pub capacity: f64,
}

impl HalfBody {
    /// Effusivity sqrt(k rho c).
    fn effusivity(&self) -> f64 {
        (self.conductivity * self.capacity).sqrt()
    }
}

/// Two half spaces brought together at t = 0: the plane between them takes and keeps the mean of their
/// values, weighted by effusivity, and each sees a held surface (Carslaw and Jaeger 1959, 2.15):
/// C = contact + (initial - contact) erf(|x - at| / (2 sqrt(D t))).
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// The axis across: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the plane between them, m.
    pub at: f64,
    /// The body below it, and the one above.
    pub bodies: [HalfBody; 2],
}

impl Contact {
    /// The value of the plane between them.
    pub fn contact(&self) -> f64 {
        let [below, above] = self.bodies;
        let (e, f) = (below.effusivity(), above.effusivity());
        (e * below.initial + f * above.initial) / (e + f)
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        let depth = x[self.axis] - self.at;
        let body = self.bodies[usize::from(depth > 0.0)];
        if t <= 0.0 {
            return body.initial;
        }
        let contact = self.contact();
        let reach = 2.0 * (body.conductivity / body.capacity * t).sqrt();
        contact + (body.initial - contact) * erf(depth.abs() / reach)
    }
}
