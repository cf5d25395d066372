//! The walls of one face together.

use glam::DVec3;

use super::{Face, Wall, WallKind};

/// A face with the walls on it, of which at least one has ghosts.
#[derive(Clone, Debug)]
pub struct WalledFace<'a> {
    face: Face,
    /// Index and wall: patches in their order, then what covers the rest.
    walls: Vec<(usize, &'a Wall)>,
}

impl<'a> WalledFace<'a> {
    /// The faces of a scene of this dimension that have walls with ghosts.
    pub fn all(walls: &'a [Wall], dimension: usize) -> Vec<Self> {
        let has_ghosts = |wall: &Wall| wall.condition.kind != WallKind::Free;
        let of_face = |face: Face| {
            let mut walls: Vec<_> =
                walls.iter().enumerate().filter(|(_, wall)| wall.face == face).collect();
            walls.sort_by_key(|(_, wall)| wall.covers.is_none());
            walls.iter().any(|(_, wall)| has_ghosts(wall)).then_some(Self { face, walls })
        };
        Face::all(dimension).filter_map(of_face).collect()
    }

    /// The face.
    pub fn face(&self) -> Face {
        self.face
    }

    /// The wall, if it is one that covers all of the face.
    pub fn only(&self) -> Option<&'a Wall> {
        match self.walls[..] {
            [(_, wall)] if wall.covers.is_none() => Some(wall),
            _ => None,
        }
    }

    /// Whether some wall covers only a part of it.
    pub fn has_patches(&self) -> bool {
        self.walls.iter().any(|(_, wall)| wall.covers.is_some())
    }

    /// The wall at a point of the face and its index, if one covers the point.
    pub fn at(&self, point: DVec3) -> Option<(usize, &'a Wall)> {
        let covers = |wall: &Wall| wall.covers.as_ref().is_none_or(|part| part.contains(point));
        self.walls.iter().find(|(_, wall)| covers(wall)).copied()
    }
}
