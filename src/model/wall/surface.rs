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

/// A surface of the body that is no face of the domain, where the support stays truncated.
///
/// Flux and convection enter as the consistent source S_a = 2 q n . sum_b V_b grad W_ab over the
/// operator's lattice moment, n the inward normal and the sum over particles and ghosts within the
/// support. On a flat surface of a lattice its total is exactly q x area. On a curved one it is
/// q x area x (1 + m div n) to first order in the curvature, since the normal is taken at the
/// particle and not where its pairs would cross the surface; m is half the first moment of the
/// kernel's slope along the normal ([`crate::model::Kernel::crossing_moment`]). The source is
/// divided by that factor.
#[derive(Clone)]
pub struct Surface {
    /// What messages call it, e.g. its path in the case file.
    pub name: String,
    /// The part of the surface that counts, by the foot of a particle; all of it without one.
    pub covers: Option<Region>,
    /// What happens there: flux or convection.
    pub condition: Condition,
    nearest: Arc<Nearest>,
}

impl Surface {
    /// A surface; `nearest` gives the point of it that is nearest to another (m).
    pub fn new(
        name: impl Into<String>,
        nearest: impl Fn(DVec3) -> DVec3 + Send + Sync + 'static,
        covers: Option<Region>,
        condition: Condition,
    ) -> Self {
        Self { name: name.into(), covers, condition, nearest: Arc::new(nearest) }
    }

    /// The point of the surface nearest to `x` (m), if it is nearer than `reach` (m) and covered.
    pub fn foot(&self, x: DVec3, reach: f64) -> Option<DVec3> {
        let foot = (self.nearest)(x);
        let covered = || self.covers.as_ref().is_none_or(|region| region.contains(foot));
        (x.distance(foot) < reach && covered()).then_some(foot)
    }

    /// The divergence of the normal that points from the surface at `foot` (m) along `inward`,
    /// 1/m: the sum of the curvatures, negative where the body is convex. By differences at `depth`
    /// (m), where neither side of the surface is near.
    pub fn divergence(&self, foot: DVec3, inward: DVec3, depth: f64, dimension: usize) -> f64 {
        let center = foot + depth * inward;
        let step = 0.1 * depth;
        let normal = |x: DVec3| (x - (self.nearest)(x)).normalize_or_zero();
        let along = |axis: usize| {
            let shift = step * DVec3::AXES[axis];
            (normal(center + shift) - normal(center - shift))[axis] / (2.0 * step)
        };
        (0..dimension).map(along).sum()
    }
}

impl fmt::Debug for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Surface({:?}, {:?})", self.name, self.condition)
    }
}
