//! Parts of space, and surfaces that are no faces of the domain.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use super::Condition;

type Contains = dyn Fn(DVec3) -> bool + Send + Sync;
type Nearest = dyn Fn(DVec3) -> DVec3 + Send + Sync;

/// A part of space, cheap to clone and shared between threads.
#[derive(Clone)]
pub struct Region(Arc<Contains>);

impl Region {
    /// The points for which `contains` holds.
    pub fn new(contains: impl Fn(DVec3) -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(contains))
    }

    /// Whether `x` (m) belongs to it.
    pub fn contains(&self, x: DVec3) -> bool {
        (self.0)(x)
    }
}

impl fmt::Debug for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Region")
    }
}

/// A surface of the body that is no face of the domain, where the support stays truncated: flux and
/// convection enter as a source (see [`crate::model::operator::fold`]).
#[derive(Clone)]
pub struct Surface {
    /// What messages call it, e.g. its path in the case file.
    pub name: String,
    /// What happens there: flux or convection.
    pub condition: Condition,
    /// The shape whose surface it is; the body may be inside or outside of it.
    shape: Region,
    nearest: Arc<Nearest>,
    /// The part of the surface that counts; all of it without one.
    part: Option<Region>,
}

impl Surface {
    /// The surface of `shape`, all of it or the part in `part`; `nearest` gives the point of it that
    /// is nearest to another (m).
    pub fn new(
        name: impl Into<String>,
        shape: Region,
        nearest: impl Fn(DVec3) -> DVec3 + Send + Sync + 'static,
        part: Option<Region>,
        condition: Condition,
    ) -> Self {
        Self { name: name.into(), condition, shape, nearest: Arc::new(nearest), part }
    }

    /// The point of the surface nearest to `x` (m).
    pub fn foot(&self, x: DVec3) -> DVec3 {
        (self.nearest)(x)
    }

    /// The distance of `x` (m) from the surface, m.
    pub fn distance(&self, x: DVec3) -> f64 {
        x.distance(self.foot(x))
    }

    /// The direction from the surface to `x` (m), which is not on it.
    pub fn normal(&self, x: DVec3) -> DVec3 {
        (x - self.foot(x)).normalize_or_zero()
    }

    /// Whether `x` (m) is in the shape.
    pub fn contains(&self, x: DVec3) -> bool {
        self.shape.contains(x)
    }

    /// Whether the point of the surface at `foot` (m) counts.
    pub fn covers(&self, foot: DVec3) -> bool {
        self.part.as_ref().is_none_or(|part| part.contains(foot))
    }
}

impl fmt::Debug for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Surface({:?}, {:?})", self.name, self.condition)
    }
}
