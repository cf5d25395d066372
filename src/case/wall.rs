//! Walls on faces of the domain, and surfaces that are no faces, from the `boundaries` section.

mod error;
mod face;
mod kind;
mod patch;
mod surface;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::CaseError;
use super::fill::TOLERANCE;
use super::number::Evaluator;
use super::schema::BoundarySpec;
use super::shape::ShapeSpec;
use crate::model::{Domain, Face, Kernel, Particles, Region, Surface, Wall, WallKind};

pub use error::WallError;
pub(super) use face::{FaceSpec, check_faces};
pub(super) use kind::{ConvectionSpec, WallKindSpec};

/// A wall on faces of the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct WallSpec {
    /// The faces, none twice.
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    pub(super) faces: Vec<FaceSpec>,
    pub(super) kind: WallKindSpec,
    /// The part of each face that it covers; what other walls on the face leave where absent.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub(super) selection: Option<Box<ShapeSpec>>,
}

/// A surface of the body that is no face of the domain, such as a curved or an oblique one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct SurfaceSpec {
    /// The shape whose surface it is.
    of: Box<ShapeSpec>,
    #[schemars(schema_with = "kind::surface_kinds")]
    kind: WallKindSpec,
    /// The part of the surface that counts; all of it where absent.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    selection: Option<Box<ShapeSpec>>,
}

/// What walls and surfaces stand on.
pub(super) struct Body<'a> {
    pub(super) evaluator: &'a Evaluator,
    pub(super) domain: &'a Domain,
    pub(super) spacing: f64,
    pub(super) kernel: &'a Kernel,
    pub(super) particles: &'a Particles,
}

impl Body<'_> {
    /// How far from a shape counts as in it, m.
    fn tolerance(&self) -> f64 {
        TOLERANCE * self.spacing
    }

    /// The points of a shape.
    fn region(&self, shape: &ShapeSpec, path: &str) -> Result<Region, CaseError> {
        let shape = shape.resolve(self.evaluator, path)?;
        let tolerance = self.tolerance();
        Ok(Region::new(move |x| shape.contains(x, tolerance)))
    }
}

/// The walls and surfaces of a case, in its order; a wall on several faces becomes several.
pub(super) fn resolve(
    boundaries: &[BoundarySpec],
    body: &Body,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Wall>, Vec<Surface>), CaseError> {
    let (mut patches, mut surfaces) = (Vec::new(), Vec::new());
    for (index, boundary) in boundaries.iter().enumerate() {
        match boundary {
            BoundarySpec::Wall(spec) => {
                patches.extend(spec.resolve(body, &format!("boundaries[{index}].wall"))?);
            }
            BoundarySpec::Surface(spec) => {
                surfaces.push(spec.resolve(body, &format!("boundaries[{index}].surface"))?);
            }
            BoundarySpec::Held { .. } | BoundarySpec::Periodic { .. } => {}
        }
    }
    Ok((patch::check(patches, body, warnings)?, surfaces))
}

/// The faces with a wall that is not free.
pub(super) fn walled_faces(boundaries: &[BoundarySpec]) -> Vec<Face> {
    let faces = |boundary: &BoundarySpec| match boundary {
        BoundarySpec::Wall(spec) if spec.kind.kind() != WallKind::Free => spec.faces.clone(),
        _ => Vec::new(),
    };
    boundaries.iter().flat_map(faces).map(Face::from).collect()
}
