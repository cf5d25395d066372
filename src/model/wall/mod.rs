//! Walls: what happens where the body ends.
//!
//! A wall on a face of the domain is an affine mirror: behind the face every particle has a ghost
//! at its mirror image, which holds `scale x the particle's value + offset x W`. W is what the wall
//! imposes: its value, its flux, or the ambient value. Static particles need no ghosts while a run
//! goes on: they are folded into the matrix, its diagonal and the source (see
//! [`crate::model::operator::fold`]).
//!
//! Each kind is one file with its [`Definition`]. A new kind is that file, and here a `mod` line, a
//! variant and its line in [`WallKind::definition`].
//!
//! A surface that is no face of the domain (curved, oblique) has no ghosts: the support stays
//! truncated there, and flux and convection enter as a source (see [`Surface`]).

mod condition;
mod convection;
mod flux;
mod free;
mod insulated;
mod surface;
mod value;
mod walled_face;

use glam::DVec3;

pub use condition::Condition;
pub use surface::{Region, Surface};
pub use walled_face::WalledFace;

use super::Domain;

/// Where a wall's relation is evaluated, and with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Conductivity k of the material (with constant diffusivity, D: the heat capacity is 1), as
    /// the operator conducts it: the plain one has a factor Deff / D.
    pub conductivity: f64,
    /// Distance d of the particle from the wall, m; that of its ghost is the same.
    pub distance: f64,
    /// Transfer coefficient U of a convection wall, in the unit of conductivity over length.
    pub coefficient: f64,
}

/// What a ghost holds: `scale x C + offset x W`, C the value of the particle that it mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Factor of the particle's value.
    pub scale: f64,
    /// Factor of what the wall imposes.
    pub offset: f64,
}

/// What enters through a truncated surface: the flux density `gain x W - loss x C`, C the value of
/// a particle near the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflow {
    /// Factor of what the surface imposes.
    pub gain: f64,
    /// Factor of the particle's value.
    pub loss: f64,
}

/// The mathematics of one kind of wall.
pub struct Definition {
    /// The name in case files.
    pub name: &'static str,
    /// What its ghosts hold; `None` where it has no ghosts.
    pub mirror: Option<fn(&Conditions) -> Mirror>,
    /// What enters through a truncated surface of this kind; `None` where there is no such thing.
    pub inflow: Option<fn(&Conditions) -> Inflow>,
}

/// The kinds of walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WallKind {
    /// Truncated support: nothing crosses, and conduction along the wall is weaker next to it.
    Free,
    /// Nothing crosses.
    Insulated,
    /// A given value at the wall.
    Value,
    /// A given flux into the body.
    Flux,
    /// A flux in proportion to the difference from an ambient value.
    Convection,
}

impl WallKind {
    /// Every kind.
    pub const ALL: [Self; 5] =
        [Self::Free, Self::Insulated, Self::Value, Self::Flux, Self::Convection];

    /// The kind's mathematics.
    pub fn definition(self) -> &'static Definition {
        match self {
            Self::Free => &free::DEFINITION,
            Self::Insulated => &insulated::DEFINITION,
            Self::Value => &value::DEFINITION,
            Self::Flux => &flux::DEFINITION,
            Self::Convection => &convection::DEFINITION,
        }
    }

    /// The name in case files.
    pub fn name(self) -> &'static str {
        self.definition().name
    }

    /// Whether something enters by a flux, so that a truncated surface of this kind has a source.
    pub fn has_inflow(self) -> bool {
        self.definition().inflow.is_some()
    }
}

/// A face of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Face {
    /// 0, 1 or 2.
    pub axis: usize,
    /// Whether it is the upper of the axis's two faces.
    pub upper: bool,
}

impl Face {
    /// The faces of a domain of this dimension, axis by axis, the lower before the upper.
    pub fn all(dimension: usize) -> impl Iterator<Item = Self> {
        (0..dimension).flat_map(|axis| [false, true].map(|upper| Self { axis, upper }))
    }

    /// The name in case files.
    pub fn name(self) -> &'static str {
        let names = [["x_min", "x_max"], ["y_min", "y_max"], ["z_min", "z_max"]];
        names[self.axis][usize::from(self.upper)]
    }

    /// The coordinate of the face along its axis, m.
    pub fn coordinate(self, domain: &Domain) -> f64 {
        if self.upper { domain.max[self.axis] } else { domain.min[self.axis] }
    }

    /// The distance of `x` from the face, m; negative outside of the domain.
    pub fn distance(self, domain: &Domain, x: DVec3) -> f64 {
        let above = x[self.axis] - self.coordinate(domain);
        if self.upper { -above } else { above }
    }

    /// The foot of `x` on the face, m.
    pub fn foot(self, domain: &Domain, mut x: DVec3) -> DVec3 {
        x[self.axis] = self.coordinate(domain);
        x
    }

    /// The mirror image of `x` behind the face, m.
    pub fn mirrored(self, domain: &Domain, mut x: DVec3) -> DVec3 {
        x[self.axis] = 2.0 * self.coordinate(domain) - x[self.axis];
        x
    }
}

/// A wall on a face of the domain, or on a part of it.
#[derive(Clone, Debug)]
pub struct Wall {
    /// What messages call it, e.g. its path in the case file.
    pub name: String,
    /// The face.
    pub face: Face,
    /// The part of the face that it covers. A wall without one covers what the others leave; of
    /// two that cover a point, the first counts.
    pub covers: Option<Region>,
    /// What it does.
    pub condition: Condition,
}
