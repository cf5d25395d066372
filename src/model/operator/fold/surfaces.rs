//! Surfaces that are no faces of the domain: flux and convection as a source.
//!
//! Beyond such a surface the lattice is cut off. A pair of particle a with a site j that is missing
//! there would have carried the flux q through the surface where the two cross it, so the source is
//! S_a = 2 sum_j V q(x) n(x) . grad W_aj over the operator's lattice moment, with the inward normal
//! n and everything that is imposed taken at the crossing x. This is the consistent source
//! 2 q n . sum_b V grad W_ab of a flat surface, since the whole lattice's sum is 0; with the
//! crossing's own normal its total is q x area on curved surfaces and at edges as well.

use glam::DVec3;

use super::mirrors::Mirrors;
use super::{Fault, PairWeight, RowFold};
use crate::model::neighbors::Neighbor;
use crate::model::{Problem, Surface, lattice};

/// A particle nearer than this fraction of the spacing to a surface lies on it.
const ON_SURFACE: f64 = 1e-9;

/// The surfaces of a scene.
pub(super) struct Surfaces<'a> {
    problem: &'a Problem,
    weight: &'a PairWeight<'a>,
    /// To each neighbour on the lattice (m), and -2 W'(r)/r over the lattice's moment.
    sites: Vec<(DVec3, f64)>,
}

/// One row near one surface.
struct NearSurface<'a> {
    surface: &'a Surface,
    /// Index among what is imposed.
    imposed: usize,
    a: usize,
    /// Whether the body is inside the shape whose surface it is.
    body_inside: bool,
}

impl<'a> Surfaces<'a> {
    pub(super) fn new(problem: &'a Problem, weight: &'a PairWeight<'a>) -> Self {
        let mut sites = Vec::new();
        if !problem.surfaces.is_empty() {
            let Problem { kernel, spacing, .. } = problem;
            lattice::for_each_neighbor(kernel, *spacing, |site| {
                let slope = kernel.dw_over_r(site.length()) / weight.lattice_ratio();
                sites.push((site, -2.0 * slope));
            });
        }
        Self { problem, weight, sites }
    }

    /// Whether a surface may be within the support of a particle at `x` (m).
    pub(super) fn reach(&self, x: DVec3) -> bool {
        let cutoff = self.problem.kernel.cutoff();
        self.problem.surfaces.iter().any(|surface| surface.distance(x) < cutoff)
    }

    /// Adds what enters at particle `a` to its row. `mirrors` fold sites back into the body.
    pub(super) fn fold(
        &self,
        a: usize,
        neighbors: &[Neighbor],
        order: &[u32],
        mirrors: &Mirrors<'_>,
        row: &mut RowFold,
    ) {
        let Problem { particles, kernel, walls, surfaces, .. } = self.problem;
        let x = particles.position[a];
        let neighbor = |n: &Neighbor| particles.position[order[n.rank as usize] as usize];
        for (k, surface) in surfaces.iter().enumerate() {
            if surface.distance(x) >= kernel.cutoff() {
                continue;
            }
            let imposed = walls.len() + k;
            let on_surface = |x: DVec3| surface.distance(x) <= ON_SURFACE * self.problem.spacing;
            let off = || neighbors.iter().map(neighbor).filter(|x| !on_surface(*x));
            let inside = off().filter(|x| surface.contains(*x)).count();
            let body_inside = match on_surface(x) {
                true => 2 * inside > off().count(),
                false => surface.contains(x),
            };
            let near = NearSurface { surface, imposed, a, body_inside };
            let beyond = off().find(|x| surface.contains(*x) != body_inside);
            if let Some(at) = beyond.filter(|x| self.crossing(&near, *x, mirrors).is_some()) {
                row.fault = Some(Fault::Inside { imposed, at });
            }
            self.add(&near, mirrors, row);
        }
    }

    /// Adds what enters through one surface.
    fn add(&self, near: &NearSurface<'_>, mirrors: &Mirrors<'_>, row: &mut RowFold) {
        let Problem { particles, .. } = self.problem;
        let x = particles.position[near.a];
        let conductivity = self.weight.conductivity(near.a, near.a);
        let capacity = self.problem.unit_capacity(near.a);
        for &(to_site, slope) in &self.sites {
            let Some((crossing, inward)) = self.crossing(near, x + to_site, mirrors) else {
                continue;
            };
            // In the frame of the particle; the crossing itself is folded into the body.
            let spread = particles.volume[near.a] * slope * -to_site.dot(inward.normal) / capacity;
            let depth = (x - inward.at).dot(inward.normal).max(0.0);
            let condition = &near.surface.condition;
            let Some(inflow) = condition.inflow(conductivity, depth, crossing) else {
                continue;
            };
            row.acts = true;
            row.diagonal -= spread * inflow.loss;
            row.add_source(condition, near.imposed, crossing, spread * inflow.gain);
        }
    }

    /// Where the segment from the particle to `site` crosses the surface: the crossing folded into
    /// the body, and itself with the inward normal. `None` where it does not, or where the crossing
    /// is not covered.
    fn crossing(
        &self,
        near: &NearSurface<'_>,
        site: DVec3,
        mirrors: &Mirrors<'_>,
    ) -> Option<(DVec3, Inward)> {
        let x = self.problem.particles.position[near.a];
        let fold = |point: DVec3| mirrors.folded(point, |face| mirrors.is_walled(face));
        let is_body = |point: DVec3| near.surface.contains(fold(point).0) == near.body_inside;
        if is_body(site) {
            return None;
        }
        let (mut within, mut beyond) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (within + beyond);
            if is_body(x + middle * (site - x)) { within = middle } else { beyond = middle }
        }
        let at = x + within * (site - x);
        let (folded, _) = fold(at);
        if !near.surface.covers(folded) {
            return None;
        }
        // The normal a little inside, where the nearest point of the surface is not the point.
        let (inside, sign) = fold(at - NORMAL_DEPTH * (site - x));
        Some((folded, Inward { at, normal: sign * near.surface.normal(inside) }))
    }
}

/// A crossing (m) with the inward normal there.
struct Inward {
    at: DVec3,
    normal: DVec3,
}

/// Halvings of a segment in search of a crossing: to 1e-9 of its length.
const BISECTIONS: u32 = 30;

/// How far inside the crossing the normal is taken, as a part of the segment.
const NORMAL_DEPTH: f64 = 1e-4;
