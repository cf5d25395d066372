//! A kind of wall with its numbers.

use glam::DVec3;

use super::{Conditions, Inflow, Mirror, WallKind};
use crate::model::ScalarField;

/// A kind of wall with what it imposes.
#[derive(Clone, Debug)]
pub struct Condition {
    /// The kind.
    pub kind: WallKind,
    /// W: the wall's value, its flux into the body (value x m/s), or the ambient value; not used by
    /// free and insulated walls.
    pub imposed: ScalarField,
    /// Transfer coefficient U of a convection wall, m/s, which depends on position alone.
    pub coefficient: ScalarField,
}

impl Condition {
    /// A condition of a kind that imposes nothing.
    fn bare(kind: WallKind) -> Self {
        let none = ScalarField::constant(0.0);
        Self { kind, imposed: none.clone(), coefficient: none }
    }

    /// Truncated support.
    pub fn free() -> Self {
        Self::bare(WallKind::Free)
    }

    /// Nothing crosses.
    pub fn insulated() -> Self {
        Self::bare(WallKind::Insulated)
    }

    /// The value at the wall is `value`.
    pub fn value(value: ScalarField) -> Self {
        Self { imposed: value, ..Self::bare(WallKind::Value) }
    }

    /// `flux` (value x m/s, positive into the body) crosses the wall.
    pub fn flux(flux: ScalarField) -> Self {
        Self { imposed: flux, ..Self::bare(WallKind::Flux) }
    }

    /// `coefficient` (m/s) x (`ambient` - value at the wall) crosses the wall.
    pub fn convection(coefficient: ScalarField, ambient: ScalarField) -> Self {
        Self { kind: WallKind::Convection, imposed: ambient, coefficient }
    }

    /// What a ghost at `distance` (m) holds, where the pair crosses the wall at `crossing`; `None`
    /// if there are no ghosts.
    pub fn mirror(&self, conductivity: f64, distance: f64, crossing: DVec3) -> Option<Mirror> {
        let mirror = self.kind.definition().mirror?;
        Some(mirror(&self.conditions(conductivity, distance, crossing)))
    }

    /// What enters through a truncated surface near a particle at `distance` (m), whose foot on
    /// the surface is `foot`; `None` if nothing can.
    pub fn inflow(&self, conductivity: f64, distance: f64, foot: DVec3) -> Option<Inflow> {
        let inflow = self.kind.definition().inflow?;
        Some(inflow(&self.conditions(conductivity, distance, foot)))
    }

    fn conditions(&self, conductivity: f64, distance: f64, at: DVec3) -> Conditions {
        let coefficient = match self.kind {
            WallKind::Convection => self.coefficient.at(at, 0.0),
            _ => 0.0,
        };
        Conditions { conductivity, distance, coefficient }
    }
}
