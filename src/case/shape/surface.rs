//! The surface of a shape: the point of it that is nearest to another.
//!
//! Each smooth piece of a surface gives its nearest point as a candidate. Of a union those count
//! that no other part covers; of a difference those of `of` that no cut takes away, and those of
//! the cuts that lie in what is left.

use glam::DVec3;

use super::Shape;

/// How far beside a candidate, in tolerances, it is looked whether something covers it.
const BESIDE: f64 = 4.0;

/// A candidate: a point of the surface and the unit normal there, which points out of the shape.
#[derive(Clone, Copy)]
struct Candidate {
    at: DVec3,
    normal: DVec3,
}

impl Candidate {
    /// The point at this distance outside of the surface (m).
    fn beside(&self, distance: f64) -> DVec3 {
        self.at + distance * self.normal
    }

    /// Whether `shape` covers the surface here from without.
    fn is_covered(&self, shape: &Shape, tolerance: f64) -> bool {
        shape.contains(self.beside(BESIDE * tolerance), -tolerance)
    }

    /// Whether `shape` covers the surface here from within.
    fn is_undercut(&self, shape: &Shape, tolerance: f64) -> bool {
        shape.contains(self.beside(-BESIDE * tolerance), -tolerance)
    }
}

impl Shape {
    /// The point of the shape's surface that is nearest to `x`; `None` if there is none.
    /// `tolerance` (m) is how far apart two surfaces may be that are meant to touch.
    ///
    /// Near an edge where parts of a union meet it may be a point a little further, if one of them
    /// is round and `x` is inside; the same where a cut meets `of`, if `x` is outside.
    pub(in crate::case) fn nearest_on_surface(&self, x: DVec3, tolerance: f64) -> Option<DVec3> {
        let mut nearest: Option<(f64, DVec3)> = None;
        self.candidates(x, tolerance, &mut |candidate| {
            let dist = x.distance(candidate.at);
            if nearest.is_none_or(|(least, _)| dist < least) {
                nearest = Some((dist, candidate.at));
            }
        });
        nearest.map(|(_, at)| at)
    }

    fn candidates(&self, x: DVec3, tolerance: f64, visit: &mut dyn FnMut(Candidate)) {
        match self {
            Self::Box { min, max, dimension } => of_box(x, [*min, *max], *dimension, visit),
            Self::Cylinder { from, to, radius } => of_cylinder(x, [*from, *to], *radius, visit),
            Self::Shell { center, inner_radius, outer_radius, .. } => {
                // At the centre every direction is as good.
                let outward = (x - *center).try_normalize().unwrap_or(DVec3::X);
                visit(Candidate { at: *center + *outer_radius * outward, normal: outward });
                if *inner_radius > 0.0 {
                    visit(Candidate { at: *center + *inner_radius * outward, normal: -outward });
                }
            }
            Self::HalfSpace { point, normal } => {
                let at = x - (x - *point).dot(*normal) * *normal;
                visit(Candidate { at, normal: *normal });
            }
            Self::Union(shapes) => of_union(x, shapes, tolerance, visit),
            Self::Difference { of, minus } => {
                of_difference(x, of, minus, tolerance, visit);
            }
        }
    }
}

/// One candidate a face; axes past the dimension have none.
fn of_box(x: DVec3, corners: [DVec3; 2], dimension: usize, visit: &mut dyn FnMut(Candidate)) {
    let inside = x.clamp(corners[0], corners[1]);
    for axis in 0..dimension {
        for (corner, sign) in corners.iter().zip([-1.0, 1.0]) {
            let (mut at, mut normal) = (inside, DVec3::ZERO);
            at[axis] = corner[axis];
            normal[axis] = sign;
            visit(Candidate { at, normal });
        }
    }
}

/// The round side and both ends.
fn of_cylinder(x: DVec3, ends: [DVec3; 2], radius: f64, visit: &mut dyn FnMut(Candidate)) {
    let length = ends[0].distance(ends[1]);
    let direction = (ends[1] - ends[0]) / length;
    let along = (x - ends[0]).dot(direction);
    let across = x - ends[0] - along * direction;
    // On the axis every direction is as good.
    let outward = across.try_normalize().unwrap_or_else(|| direction.any_orthonormal_vector());
    let side = ends[0] + along.clamp(0.0, length) * direction;
    visit(Candidate { at: side + radius * outward, normal: outward });
    for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
        let at = end + across.clamp_length_max(radius);
        visit(Candidate { at, normal: sign * direction });
    }
}

fn of_union(x: DVec3, shapes: &[Shape], tolerance: f64, visit: &mut dyn FnMut(Candidate)) {
    let covering =
        |candidate: &Candidate| shapes.iter().find(|shape| candidate.is_covered(shape, tolerance));
    for shape in shapes {
        shape.candidates(x, tolerance, &mut |candidate| {
            let Some(other) = covering(&candidate) else {
                return visit(candidate);
            };
            // The edge along which the two meet may be the nearest of what is not covered.
            other.candidates(candidate.at, tolerance, &mut |next| {
                if covering(&next).is_none() {
                    visit(next);
                }
            });
        });
    }
}

fn of_difference(
    x: DVec3,
    of: &Shape,
    minus: &[Shape],
    tolerance: f64,
    visit: &mut dyn FnMut(Candidate),
) {
    of.candidates(x, tolerance, &mut |candidate| {
        if !minus.iter().any(|cut| candidate.is_undercut(cut, tolerance)) {
            visit(candidate);
        }
    });
    for cut in minus {
        cut.candidates(x, tolerance, &mut |candidate| {
            let is_in = of.contains(candidate.beside(BESIDE * tolerance), tolerance);
            if is_in && !minus.iter().any(|other| candidate.is_covered(other, tolerance)) {
                visit(Candidate { normal: -candidate.normal, ..candidate });
            }
        });
    }
}
