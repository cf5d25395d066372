//! Shapes: what is filled, what selects particles, and where surfaces lie.

mod surface;

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::CaseError;
use super::number::{Evaluator, Number, Point, in_range};

/// A region of space; its surface belongs to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case", expecting = "an object of one key")]
pub(super) enum ShapeSpec {
    /// A box along the axes.
    Box { min: Point, max: Point },
    /// A ball; in 2-D a disk.
    Sphere { center: Point, radius: Number },
    /// A round cylinder with flat ends, in 3-D.
    Cylinder { from: Point, to: Point, radius: Number },
    /// What lies between two concentric spheres.
    Shell(ShellSpec),
    /// What lies between two concentric circles, in 2-D; in 3-D the same as a shell.
    Annulus(ShellSpec),
    /// Everything on one side of a plane: the normal points out of the half space.
    HalfSpace { point: Point, normal: Point },
    /// What is in any of the shapes.
    Union(Vec<ShapeSpec>),
    /// `of` without the shapes of `minus` and their surfaces.
    Difference { of: Box<ShapeSpec>, minus: Vec<ShapeSpec> },
}

/// Centre and radii of a shell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct ShellSpec {
    center: Point,
    inner_radius: Number,
    outer_radius: Number,
}

/// A shape in numbers, m.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    Box {
        min: DVec3,
        max: DVec3,
        dimension: usize,
    },
    Cylinder {
        from: DVec3,
        to: DVec3,
        radius: f64,
    },
    /// A sphere has an inner radius below zero, so that nothing is cut out of it.
    Shell {
        center: DVec3,
        inner_radius: f64,
        outer_radius: f64,
        dimension: usize,
    },
    HalfSpace {
        point: DVec3,
        normal: DVec3,
    },
    Union(Vec<Shape>),
    Difference {
        of: Box<Shape>,
        minus: Vec<Shape>,
    },
}

impl ShapeSpec {
    /// Evaluates and checks the shape.
    pub(super) fn resolve(&self, evaluator: &Evaluator, path: &str) -> Result<Shape, CaseError> {
        let point = |key: &str, value| evaluator.point(&format!("{path}.{key}"), value);
        let positive = |key: &str, value| evaluator.positive(&format!("{path}.{key}"), value);
        match self {
            Self::Box { min, max } => {
                let (min, max) = (point("box.min", min)?, point("box.max", max)?);
                let ordered = min.cmple(max).all();
                demand(ordered, path, "box.min must not exceed box.max on any axis")?;
                Ok(Shape::Box { min, max, dimension: evaluator.dimension })
            }
            Self::Sphere { center, radius } => {
                let center = point("sphere.center", center)?;
                let outer_radius = positive("sphere.radius", radius)?;
                let dimension = evaluator.dimension;
                Ok(Shape::Shell { center, inner_radius: -1.0, outer_radius, dimension })
            }
            Self::Cylinder { from, to, radius } => {
                let needs = "a cylinder needs dimension 3; use sphere, which is a disk in 2-D";
                demand(evaluator.dimension == 3, path, needs)?;
                let (from, to) = (point("cylinder.from", from)?, point("cylinder.to", to)?);
                demand(from != to, path, "cylinder.from and cylinder.to must differ")?;
                Ok(Shape::Cylinder { from, to, radius: positive("cylinder.radius", radius)? })
            }
            Self::Shell(shell) => shell.resolve(evaluator, &format!("{path}.shell")),
            Self::Annulus(shell) => shell.resolve(evaluator, &format!("{path}.annulus")),
            Self::HalfSpace { point: foot, normal } => {
                let normal = point("half_space.normal", normal)?.normalize_or_zero();
                demand(normal != DVec3::ZERO, path, "half_space.normal must not be zero")?;
                Ok(Shape::HalfSpace { point: point("half_space.point", foot)?, normal })
            }
            Self::Union(shapes) => {
                demand(!shapes.is_empty(), path, "union needs at least one shape")?;
                Ok(Shape::Union(resolve_all(shapes, evaluator, &format!("{path}.union"))?))
            }
            Self::Difference { of, minus } => {
                let of = Box::new(of.resolve(evaluator, &format!("{path}.difference.of"))?);
                let minus_path = format!("{path}.difference.minus");
                Ok(Shape::Difference { of, minus: resolve_all(minus, evaluator, &minus_path)? })
            }
        }
    }
}

fn demand(holds: bool, path: &str, reason: &str) -> Result<(), CaseError> {
    if holds {
        return Ok(());
    }
    Err(CaseError::Shape { path: path.to_owned(), reason: reason.to_owned() })
}

impl ShellSpec {
    fn resolve(&self, evaluator: &Evaluator, path: &str) -> Result<Shape, CaseError> {
        let inner_path = format!("{path}.inner_radius");
        let inner_radius = evaluator.not_negative(&inner_path, &self.inner_radius)?;
        let outer_path = format!("{path}.outer_radius");
        let outer_radius = evaluator.positive(&outer_path, &self.outer_radius)?;
        let narrower = inner_radius < outer_radius;
        in_range(&inner_path, inner_radius, narrower, "below the outer radius")?;
        let center = evaluator.point(&format!("{path}.center"), &self.center)?;
        let dimension = evaluator.dimension;
        Ok(Shape::Shell { center, inner_radius, outer_radius, dimension })
    }
}

fn resolve_all(
    shapes: &[ShapeSpec],
    evaluator: &Evaluator,
    path: &str,
) -> Result<Vec<Shape>, CaseError> {
    let resolve =
        |(index, shape): (usize, &ShapeSpec)| shape.resolve(evaluator, &format!("{path}[{index}]"));
    shapes.iter().enumerate().map(resolve).collect()
}

impl Shape {
    /// Whether `x` lies in the shape or within `tolerance` (m) of it; with a negative one, whether
    /// it lies that deep in the shape. The cuts of a difference have the same tolerance.
    pub(super) fn contains(&self, x: DVec3, tolerance: f64) -> bool {
        match self {
            Self::Box { min, max, dimension } => {
                let tolerance = uniform(tolerance, *dimension);
                x.cmpge(*min - tolerance).all() && x.cmple(*max + tolerance).all()
            }
            Self::Cylinder { from, to, radius } => {
                let length = from.distance(*to);
                let direction = (*to - *from) / length;
                let along = (x - *from).dot(direction);
                let across = (x - *from - along * direction).length();
                across <= radius + tolerance && along >= -tolerance && along <= length + tolerance
            }
            Self::Shell { center, inner_radius, outer_radius, .. } => {
                let dist = x.distance(*center);
                dist >= inner_radius - tolerance && dist <= outer_radius + tolerance
            }
            Self::HalfSpace { point, normal } => (x - *point).dot(*normal) <= tolerance,
            Self::Union(shapes) => shapes.iter().any(|shape| shape.contains(x, tolerance)),
            Self::Difference { of, minus } => {
                of.contains(x, tolerance) && !minus.iter().any(|cut| cut.contains(x, tolerance))
            }
        }
    }

    /// Lower and upper corner of a box around the shape; `None` where it has no bounds.
    pub(super) fn bounds(&self) -> Option<(DVec3, DVec3)> {
        match self {
            Self::Box { min, max, .. } => Some((*min, *max)),
            Self::Cylinder { from, to, radius } => {
                let direction = (*to - *from).normalize();
                // The rim of an end reaches radius sin(angle) along an axis.
                let sine = (DVec3::ONE - direction * direction).max(DVec3::ZERO).map(f64::sqrt);
                let reach = *radius * sine;
                Some((from.min(*to) - reach, from.max(*to) + reach))
            }
            Self::Shell { center, outer_radius, dimension, .. } => {
                let reach = uniform(*outer_radius, *dimension);
                Some((*center - reach, *center + reach))
            }
            Self::HalfSpace { .. } => None,
            Self::Union(shapes) => {
                let mut bounds = shapes.iter().map(Self::bounds);
                let first = bounds.next()??;
                bounds.try_fold(first, |all, next| {
                    next.map(|next| (all.0.min(next.0), all.1.max(next.1)))
                })
            }
            Self::Difference { of, .. } => of.bounds(),
        }
    }
}

/// The vector of the same number on each axis up to the dimension, and 0 past it.
fn uniform(value: f64, dimension: usize) -> DVec3 {
    let component = |axis| if axis < dimension { value } else { 0.0 };
    DVec3::from_array([0, 1, 2].map(component))
}
