//! Particles and the region that they live in.

use glam::DVec3;

/// The region of space that holds the particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Lower corner, m. Axes past the scene's dimension are 0.
    pub min: DVec3,
    /// Upper corner, m. Axes past the scene's dimension are 0.
    pub max: DVec3,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
}

impl Domain {
    /// Edge lengths, m.
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }

    /// The shortest vector between two positions whose plain difference is `difference`:
    /// on a periodic axis the nearest image counts.
    pub fn nearest_image(&self, mut difference: DVec3) -> DVec3 {
        let extent = self.extent();
        for axis in 0..3 {
            if self.periodic[axis] {
                difference[axis] -= extent[axis] * (difference[axis] / extent[axis]).round();
            }
        }
        difference
    }
}

/// The particles of a scene, one entry an index in every field (structure of arrays).
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// Positions, m. Coordinates past the scene's dimension are 0.
    pub position: Vec<DVec3>,
    /// Volume V of each particle: m, m2 or m3 by dimension.
    pub volume: Vec<f64>,
    /// Index into [`crate::model::Problem::materials`].
    pub material: Vec<u16>,
}

impl Particles {
    /// How many particles there are.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}
