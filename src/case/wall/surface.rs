//! Surfaces of the body that are no faces of the domain.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::{Body, SurfaceSpec, WallError};
use crate::case::error::CaseError;
use crate::model::{Region, Surface, WallKind};

impl SurfaceSpec {
    /// The surface in numbers; some particle must be near it, and its numbers good there.
    pub(super) fn resolve(&self, body: &Body, path: &str) -> Result<Surface, CaseError> {
        let kind_path = format!("{path}.kind");
        self.check_kind(&kind_path)?;
        let kind = self.kind.resolve(body.evaluator, &kind_path)?;
        let shape = Arc::new(self.of.resolve(body.evaluator, &format!("{path}.of"))?);
        let covers = self.selection.as_deref();
        let covers = covers.map(|part| body.region(part, &format!("{path}.where"))).transpose()?;
        let tolerance = body.tolerance();
        let region = shape.clone();
        let region = Region::new(move |x| region.contains(x, 0.0));
        // What has no surface is infinitely far away.
        let nearest = move |x| shape.nearest_on_surface(x, tolerance).unwrap_or(DVec3::INFINITY);
        let surface = Surface::new(path, region, nearest, covers, kind.condition.clone());
        let foot = |&x: &DVec3| {
            let foot = surface.foot(x);
            let is_near = x.distance(foot) < body.kernel.cutoff();
            (is_near && surface.covers(foot)).then_some(foot)
        };
        let feet: Vec<DVec3> = body.particles.position.par_iter().filter_map(foot).collect();
        if feet.is_empty() {
            let part = if self.selection.is_some() { "its part in \"where\"" } else { "it" };
            let support_radius = body.kernel.support_radius();
            let path = path.to_owned();
            return Err(WallError::NothingNear { path, support_radius, part }.into());
        }
        feet.into_iter().try_for_each(|foot| kind.check(foot))?;
        Ok(surface)
    }

    /// Only what enters through a truncated surface can be given there.
    fn check_kind(&self, path: &str) -> Result<(), CaseError> {
        let kind = self.kind.kind();
        if kind.has_inflow() {
            return Ok(());
        }
        let advice = match kind {
            WallKind::Value => "hold the particles next to it instead (\"held\")",
            _ => "leave the surface out: nothing crosses it then",
        };
        Err(WallError::NotOnSurface { path: path.to_owned(), kind: kind.name(), advice }.into())
    }
}
