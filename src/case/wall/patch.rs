//! Walls on parts of faces, checked where particles have their feet.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::kind::Kind;
use super::{Body, WallError, WallSpec};
use crate::case::error::CaseError;
use crate::case::geometry::WHOLE;
use crate::case::number::{AXES, show};
use crate::model::{Face, Wall, WallKind};

/// A particle nearer to a face than this fraction of the spacing lies on it.
const ON_FACE: f64 = 1e-6;

/// Patches are looked for this fraction of the spacing beside each foot: not where the edges of
/// patches usually are, so that patches that share one do not overlap.
const BESIDE: f64 = 0.237;

/// Below this share of a face that particles lie along, a wall on it is worth a warning. A face
/// that is no whole number of spacings may miss a row.
const TOUCHED: f64 = 0.9;

/// A wall on one face, with where its numbers came from.
pub(super) struct Patch {
    wall: Wall,
    kind: Arc<Kind>,
}

impl Patch {
    /// Whether it has a shape that holds the point.
    fn covers(&self, point: DVec3) -> bool {
        self.wall.covers.as_ref().is_some_and(|part| part.contains(point))
    }
}

impl WallSpec {
    /// One patch for each face.
    pub(super) fn resolve(&self, body: &Body, path: &str) -> Result<Vec<Patch>, CaseError> {
        let kind = Arc::new(self.kind.resolve(body.evaluator, &format!("{path}.kind"))?);
        let covers = self.selection.as_deref();
        let covers = covers.map(|part| body.region(part, &format!("{path}.where"))).transpose()?;
        let on = |&face| Patch {
            wall: Wall {
                name: path.to_owned(),
                face: Face::from(face),
                covers: covers.clone(),
                condition: kind.condition.clone(),
            },
            kind: kind.clone(),
        };
        Ok(self.faces.iter().map(on).collect())
    }
}

/// The walls of the patches, each of which must fit the body and the others.
pub(super) fn check(
    patches: Vec<Patch>,
    body: &Body,
    warnings: &mut Vec<String>,
) -> Result<Vec<Wall>, CaseError> {
    for patch in &patches {
        check_thickness(&patch.wall, body)?;
    }
    for axis in 0..body.evaluator.dimension {
        for upper in [false, true] {
            let face = Face { axis, upper };
            let on_face = patches.iter().filter(|patch| patch.wall.face == face);
            let on_face = OnFace { face, body, patches: on_face.collect() };
            if !on_face.patches.is_empty() {
                on_face.check()?;
                warnings.extend(on_face.touches_in_part());
            }
        }
    }
    Ok(patches.into_iter().map(|patch| patch.wall).collect())
}

/// A support may not reach through the body from one wall past another: ghosts have no ghosts
/// behind the opposite face.
fn check_thickness(wall: &Wall, body: &Body) -> Result<(), CaseError> {
    let extent = body.domain.extent()[wall.face.axis];
    let support_radius = body.kernel.support_radius();
    let fits = support_radius <= extent * (1.0 + WHOLE);
    if fits || wall.condition.kind == WallKind::Free {
        return Ok(());
    }
    let ratio = extent / body.spacing;
    let whole = (ratio - ratio.round()).abs() <= WHOLE * ratio;
    let most = if whole { ratio.round() } else { ratio };
    let (axis, wall) = (AXES[wall.face.axis], wall.name.clone());
    Err(WallError::TooThin { support_radius, extent, axis, wall, most }.into())
}

/// The patches on one face.
struct OnFace<'a> {
    face: Face,
    body: &'a Body<'a>,
    patches: Vec<&'a Patch>,
}

impl OnFace<'_> {
    fn check(&self) -> Result<(), CaseError> {
        let Body { domain, kernel, particles, .. } = self.body;
        let cutoff = kernel.cutoff();
        let near = |x: &&DVec3| self.face.distance(domain, **x) < cutoff;
        let near: Vec<DVec3> = particles.position.par_iter().filter(near).copied().collect();
        // A wall without a shape may be left nothing to cover.
        let mut touched: Vec<bool> =
            self.patches.iter().map(|patch| patch.wall.covers.is_none()).collect();
        for &x in &near {
            let foot = self.face.foot(domain, x);
            if let Some(patch) = self.at(foot) {
                self.check_apart(x, patch)?;
                patch.kind.check(foot)?;
            }
            self.touch(foot, &mut touched);
            for point in self.beside(foot) {
                self.check_overlap(point)?;
                self.touch(point, &mut touched);
            }
        }
        match touched.iter().position(|touched| !touched) {
            Some(k) => Err(self.outside(self.patches[k])),
            None => Ok(()),
        }
    }

    /// What to say where the body touches only a part of the face and a wall acts there.
    fn touches_in_part(&self) -> Option<String> {
        let Body { domain, particles, spacing, evaluator, .. } = self.body;
        let is_free = |patch: &&Patch| patch.wall.condition.kind == WallKind::Free;
        if self.patches.iter().all(is_free) {
            return None;
        }
        let first_layer = |x: &&DVec3| self.face.distance(domain, **x) < *spacing;
        let layer = particles.position.par_iter().filter(first_layer).count() as f64;
        let along = (0..evaluator.dimension).filter(|&axis| axis != self.face.axis);
        let sites: f64 = along.map(|axis| domain.extent()[axis] / spacing).product();
        let share = layer / sites;
        (share < TOUCHED).then(|| {
            format!(
                "{}: the body touches only {:.0} % of the face {}, and its walls act on the rest \
                 of the particles within a support radius as well",
                self.patches[0].wall.name,
                100.0 * share,
                self.face.name()
            )
        })
    }

    /// The patch that counts at a point.
    fn at(&self, point: DVec3) -> Option<&Patch> {
        let whole = || self.patches.iter().find(|patch| patch.wall.covers.is_none());
        self.covering(point).next().or_else(|| whole().copied())
    }

    /// The patches with a shape that holds the point, in their order.
    fn covering(&self, point: DVec3) -> impl Iterator<Item = &Patch> {
        self.patches.iter().copied().filter(move |patch| patch.covers(point))
    }

    /// Notes which patches hold the point.
    fn touch(&self, point: DVec3, touched: &mut [bool]) {
        for (patch, touched) in self.patches.iter().zip(touched) {
            *touched |= patch.covers(point);
        }
    }

    /// Points of the face around a foot.
    fn beside(&self, foot: DVec3) -> impl Iterator<Item = DVec3> {
        let along: Vec<usize> =
            (0..self.body.evaluator.dimension).filter(|&axis| axis != self.face.axis).collect();
        let domain = *self.body.domain;
        let offset = BESIDE * self.body.spacing;
        let point = move |signs: usize| {
            let mut point = foot;
            for (bit, &axis) in along.iter().enumerate() {
                point[axis] += if signs & (1 << bit) == 0 { -offset } else { offset };
            }
            point
        };
        let count = 1 << (self.body.evaluator.dimension - 1);
        let inside = move |x: &DVec3| x.cmpge(domain.min).all() && x.cmple(domain.max).all();
        (0..count).map(point).filter(inside)
    }

    fn check_apart(&self, x: DVec3, patch: &Patch) -> Result<(), CaseError> {
        let distance = self.face.distance(self.body.domain, x);
        let is_free = patch.wall.condition.kind == WallKind::Free;
        if is_free || distance >= ON_FACE * self.body.spacing {
            return Ok(());
        }
        let (path, point) = (patch.wall.name.clone(), self.show(x));
        Err(WallError::OnWall { path, face: self.face.name().to_owned(), point }.into())
    }

    fn check_overlap(&self, point: DVec3) -> Result<(), CaseError> {
        let mut covering = self.covering(point);
        let (Some(first), Some(second)) = (covering.next(), covering.next()) else {
            return Ok(());
        };
        let (first, second) = (first.wall.name.clone(), second.wall.name.clone());
        let (face, point) = (self.face.name().to_owned(), self.show(point));
        Err(WallError::TwoKinds { first, second, face, point }.into())
    }

    fn outside(&self, patch: &Patch) -> CaseError {
        let path = format!("{}.where", patch.wall.name);
        let (face, axis) = (self.face.name().to_owned(), AXES[self.face.axis]);
        let coordinate = self.face.coordinate(self.body.domain);
        WallError::OutsideFace { path, face, axis, coordinate }.into()
    }

    fn show(&self, x: DVec3) -> String {
        show(x, self.body.evaluator.dimension)
    }
}
