//! What the particles are made of.

/// The density that a material has where the case names none, kg/m3 (the report's).
pub const DEFAULT_DENSITY: f64 = 1000.0;

/// A material of constant properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the case file.
    pub name: String,
    /// Diffusivity D, m2/s, positive.
    pub diffusivity: f64,
    /// Density rho, kg/m3, positive. With constant diffusivity it only enters the summation
    /// density (18): the particle mass is rho V.
    pub density: f64,
}
