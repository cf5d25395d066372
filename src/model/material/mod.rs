//! What the particles are made of.

mod conductivity;
mod curve;

use std::sync::Arc;

pub use conductivity::{Conductivity, straightened};
pub use curve::{HeatCurve, Melting, Segment};

/// The density that a material has where the case names none, kg/m3 (the report's).
pub const DEFAULT_DENSITY: f64 = 1000.0;

/// A material.
///
/// The value of a particle changes by what flows into it over `capacity` x volume. Heat flows by
/// the conductivity k, W/(m K), into rho c, J/(m3 K); where only a diffusivity D is known, it is the
/// conductivity and the capacity is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the case file.
    pub name: String,
    /// Conductivity k, positive: pairs are formed from it, never from the diffusivity. Where it depends on
    /// temperature, the reference of `curve`.
    pub conductivity: f64,
    /// Capacity rho c of a unit volume, positive; that of the solid where it melts.
    pub capacity: f64,
    /// What temperature and heat flow depend on where properties are not constant. Without it, enthalpy,
    /// temperature and potential are one.
    pub curve: Option<Arc<HeatCurve>>,
    /// Density rho, kg/m3, positive: the particle mass is rho V, which with constant properties only
    /// enters the summation density (18).
    pub density: f64,
}

impl Material {
    /// One of which only the diffusivity D (m2/s) is known.
    pub fn diffusive(name: impl Into<String>, diffusivity: f64, density: f64) -> Self {
        Self { name: name.into(), conductivity: diffusivity, capacity: 1.0, curve: None, density }
    }

    /// Of `solid` conductivity, that melts as `melting` says, if at all.
    pub fn thermal(
        name: impl Into<String>,
        solid: &Conductivity,
        capacity: f64,
        melting: Option<&Melting>,
        density: f64,
    ) -> Self {
        let is_plain = solid.is_constant() && melting.is_none();
        let curve = HeatCurve::new(solid, capacity, melting);
        let conductivity = curve.reference();
        let curve = (!is_plain).then(|| Arc::new(curve));
        Self { name: name.into(), conductivity, capacity, curve, density }
    }

    /// Whether its enthalpy follows the curve of another, or neither has one.
    pub fn shares_curve(&self, other: &Self) -> bool {
        match (&self.curve, &other.curve) {
            (None, None) => true,
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            _ => false,
        }
    }

    /// Whether its properties depend on temperature only by melting.
    pub fn is_constant_in_phases(&self) -> bool {
        self.curve.as_ref().is_none_or(|curve| curve.is_constant_in_phases())
    }

    /// Diffusivity k / (rho c), m2/s.
    pub fn diffusivity(&self) -> f64 {
        self.conductivity / self.capacity
    }
}
