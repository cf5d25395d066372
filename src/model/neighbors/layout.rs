//! How space is cut into cells.

use glam::DVec3;

use crate::model::{Domain, Problem};

/// A box of cells, each at least one cutoff wide, so that all neighbours of a particle are in its
/// own cell or in one that touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellLayout {
    /// The region that the cells cover.
    pub domain: Domain,
    /// How many cells lie along each axis; 1 along axes past the scene's dimension.
    pub cells: [u32; 3],
    /// Edge lengths of a cell, m; 1 along axes past the scene's dimension.
    pub size: DVec3,
}

/// Where a particle is among the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellPlace {
    /// The cell's index.
    pub cell: u32,
    /// Offset from the cell's lower corner, in cells: within [0, 1] but for particles beyond the
    /// edge of an open axis. Its accuracy does not depend on the distance from the origin.
    pub offset: DVec3,
}

/// Cells allowed for each particle: a sparse scene gets larger cells instead of a grid that no
/// memory holds.
const CELLS_PER_PARTICLE: u64 = 2;
/// Cells allowed in any scene.
const CELLS_FLOOR: u64 = 64;
/// Cells in any scene at most, so that a cell's index fits into 32 bits.
const CELLS_CEILING: u64 = 1 << 31;

impl CellLayout {
    /// Cells for `particles` particles in `domain`, none narrower than `cutoff` (m, positive).
    pub fn new(domain: &Domain, dimension: usize, cutoff: f64, particles: usize) -> Self {
        let extent = domain.extent();
        let limit =
            (particles as u64).saturating_mul(CELLS_PER_PARTICLE).clamp(CELLS_FLOOR, CELLS_CEILING);
        let mut width = cutoff;
        loop {
            let mut cells = [1_u32; 3];
            for axis in 0..dimension {
                cells[axis] = (extent[axis] / width).floor().clamp(1.0, 1e9) as u32;
            }
            let total = cells.iter().fold(1_u64, |n, &c| n.saturating_mul(u64::from(c)));
            if total <= limit {
                return Self { domain: *domain, cells, size: Self::cell_size(extent, cells) };
            }
            width *= 1.26;
        }
    }

    fn cell_size(extent: DVec3, cells: [u32; 3]) -> DVec3 {
        let mut size = DVec3::ONE;
        for axis in 0..3 {
            if extent[axis] > 0.0 {
                size[axis] = extent[axis] / f64::from(cells[axis]);
            }
        }
        size
    }

    /// The cells of a scene: none narrower than its kernel's cutoff.
    pub fn of(problem: &Problem) -> Self {
        let particles = problem.particles.len();
        Self::new(&problem.domain, problem.dimension, problem.kernel.cutoff(), particles)
    }

    /// How many cells there are.
    pub fn count(&self) -> usize {
        self.cells.iter().map(|&c| c as usize).product()
    }

    /// The cell of position `x`, as coordinates; positions outside count to the outermost cells.
    pub fn coordinates(&self, x: DVec3) -> [u32; 3] {
        let scaled = (x - self.domain.min) / self.size;
        std::array::from_fn(|axis| {
            scaled[axis].floor().clamp(0.0, f64::from(self.cells[axis] - 1)) as u32
        })
    }

    /// The place of `position` (m), wrapped round periodic axes.
    pub fn place(&self, position: DVec3) -> CellPlace {
        let extent = self.domain.extent();
        let mut inside = position - self.domain.min;
        for axis in 0..3 {
            if self.domain.periodic[axis] && extent[axis] > 0.0 {
                inside[axis] -= extent[axis] * (inside[axis] / extent[axis]).floor();
            }
        }
        let coordinates = self.coordinates(self.domain.min + inside);
        let corner = DVec3::from_array(coordinates.map(f64::from));
        CellPlace { cell: self.index(coordinates) as u32, offset: inside / self.size - corner }
    }

    /// The index of the cell at `coordinates`: x runs fastest.
    pub fn index(&self, coordinates: [u32; 3]) -> usize {
        let [x, y, z] = coordinates.map(|c| c as usize);
        let [nx, ny, _] = self.cells.map(|c| c as usize);
        (z * ny + y) * nx + x
    }

    /// The coordinates of the cell with this index.
    pub fn coordinates_of_index(&self, index: usize) -> [u32; 3] {
        let [nx, ny, _] = self.cells.map(|c| c as usize);
        [(index % nx) as u32, (index / nx % ny) as u32, (index / (nx * ny)) as u32]
    }

    /// The cells that may hold neighbours of the particles in cell `index`, itself among them,
    /// each once: z, then y, then x, from below to above.
    pub fn for_each_near(&self, index: usize, mut visit: impl FnMut(usize)) {
        let here = self.coordinates_of_index(index);
        let [near_x, near_y, near_z] =
            std::array::from_fn(|axis| self.near_along(axis, here[axis]));
        for z in near_z.iter().flatten() {
            for y in near_y.iter().flatten() {
                for x in near_x.iter().flatten() {
                    visit(self.index([*x, *y, *z]));
                }
            }
        }
    }

    /// Coordinates within one of `c` along `axis`. A periodic axis of one or two cells meets
    /// itself around the end: each cell still counts once.
    fn near_along(&self, axis: usize, c: u32) -> [Option<u32>; 3] {
        let n = self.cells[axis];
        match (self.domain.periodic[axis], n) {
            (_, 1) => [None, Some(0), None],
            (true, 2) => [None, Some(c), Some(1 - c)],
            (true, _) => [Some((c + n - 1) % n), Some(c), Some((c + 1) % n)],
            (false, _) => [c.checked_sub(1), Some(c), (c + 1 < n).then_some(c + 1)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(max: DVec3, periodic: [bool; 3]) -> CellLayout {
        let min = DVec3::ZERO;
        CellLayout::new(&Domain { min, max, periodic }, 3, 0.999_999, 1000)
    }

    #[test]
    fn cells_are_never_narrower_than_the_cutoff() {
        let dense = layout(DVec3::new(3.7, 2.0, 0.2), [false, true, false]);
        assert_eq!(dense.cells, [3, 2, 1]);
        assert_eq!(dense.size, DVec3::new(3.7 / 3.0, 1.0, 0.2));
    }

    #[test]
    fn a_place_gives_the_position_back() {
        let layout = layout(DVec3::splat(4.0), [true, false, false]);
        let place = layout.place(DVec3::new(-0.25, 5.5, 3.75));
        assert_eq!(place.cell, (3 * 4 + 3) * 4 + 3);
        assert_eq!(place.offset, DVec3::new(0.75, 2.5, 0.75));
        assert_ne!(place, layout.place(DVec3::new(0.25, 5.5, 3.75)));
    }
}
