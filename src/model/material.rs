//! What the particles are made of.

/// The density that a material has where the case names none, kg/m3 (the report's).
pub const DEFAULT_DENSITY: f64 = 1000.0;

/// A material of constant properties.
///
/// The value of a particle changes by what flows into it over `capacity` x volume. Heat flows by
/// the conductivity k, W/(m K), into rho c, J/(m3 K); where only a diffusivity D is known, it is the
/// conductivity and the capacity is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the case file.
    pub name: String,
    /// Conductivity k, positive: pairs are formed from it, never from the diffusivity.
    pub conductivity: f64,
    /// Capacity rho c of a unit volume, positive.
    pub capacity: f64,
    /// Density rho, kg/m3, positive: the particle mass is rho V, which with constant properties only
    /// enters the summation density (18).
    pub density: f64,
}

impl Material {
    /// One of which only the diffusivity D (m2/s) is known.
    pub fn diffusive(name: impl Into<String>, diffusivity: f64, density: f64) -> Self {
        Self { name: name.into(), conductivity: diffusivity, capacity: 1.0, density }
    }

    /// Diffusivity k / (rho c), m2/s.
    pub fn diffusivity(&self) -> f64 {
        self.conductivity / self.capacity
    }
}
