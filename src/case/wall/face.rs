//! Faces of the domain by name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{WallError, WallSpec};
use crate::case::error::CaseError;
use crate::case::number::AXES;
use crate::case::schema::BoundarySpec;
use crate::model::Face;

/// A face of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Face")]
pub(in crate::case) enum FaceSpec {
    XMin,
    XMax,
    YMin,
    YMax,
    ZMin,
    ZMax,
}

impl From<FaceSpec> for Face {
    fn from(face: FaceSpec) -> Self {
        let (axis, upper) = match face {
            FaceSpec::XMin => (0, false),
            FaceSpec::XMax => (0, true),
            FaceSpec::YMin => (1, false),
            FaceSpec::YMax => (1, true),
            FaceSpec::ZMin => (2, false),
            FaceSpec::ZMax => (2, true),
        };
        Self { axis, upper }
    }
}

/// Refuses walls on faces that the case has not, and two that each cover all of a face.
pub(in crate::case) fn check_faces(
    boundaries: &[BoundarySpec],
    dimension: usize,
    periodic: [bool; 3],
) -> Result<(), CaseError> {
    let mut whole: Vec<(Face, usize)> = Vec::new();
    for (index, boundary) in boundaries.iter().enumerate() {
        let BoundarySpec::Wall(wall) = boundary else {
            continue;
        };
        let path = format!("boundaries[{index}].wall.faces");
        let faces = checked(wall, &path, dimension, periodic)?;
        if wall.selection.is_some() {
            continue;
        }
        for (entry, face) in faces.into_iter().enumerate() {
            if let Some((_, first)) = whole.iter().find(|(other, _)| *other == face) {
                let (path, first) =
                    (format!("{path}[{entry}]"), format!("boundaries[{first}].wall"));
                return Err(
                    WallError::TwoWalls { path, first, face: face.name().to_owned() }.into()
                );
            }
            whole.push((face, index));
        }
    }
    Ok(())
}

/// The faces of one wall.
fn checked(
    wall: &WallSpec,
    path: &str,
    dimension: usize,
    periodic: [bool; 3],
) -> Result<Vec<Face>, CaseError> {
    if wall.faces.is_empty() {
        return Err(WallError::NoFace { path: path.to_owned() }.into());
    }
    let mut faces = Vec::new();
    for (entry, &face) in wall.faces.iter().enumerate() {
        let (path, face) = (format!("{path}[{entry}]"), Face::from(face));
        if face.axis >= dimension {
            let both = |axis| [false, true].map(|upper| Face { axis, upper }.name().to_owned());
            let (text, known) = (face.name().to_owned(), (0..dimension).flat_map(both).collect());
            return Err(CaseError::UnknownName { path, text, nearest: Vec::new(), known });
        }
        if periodic[face.axis] {
            let reason = format!("the axis {} is periodic", AXES[face.axis]);
            return Err(CaseError::UnusedKey { path, reason });
        }
        if faces.contains(&face) {
            return Err(CaseError::Duplicate { path, text: face.name().to_owned() });
        }
        faces.push(face);
    }
    Ok(faces)
}
