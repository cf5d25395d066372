//! A grid of cells at least one cutoff wide, and the place of a particle in it.

use glam::DVec3;

use super::{Domain, Kernel};

/// Cells a particle at most: a sparse scene gets larger cells rather than empty ones.
const CELLS_PER_PARTICLE: u64 = 2;

/// L / H may fall short of a whole number by rounding; the support margin covers this much.
const ROUNDING: f64 = 1e-9;

/// A grid of cells over a domain: neighbours of a particle are in its own cell or in an adjacent
/// one.
#[derive(Clone, Debug, PartialEq)]
pub struct CellGrid {
    /// Cells along each axis; 1 past the scene's dimension.
    pub cells: [u32; 3],
    /// Edge lengths of a cell, m; never below the cutoff.
    pub size: DVec3,
    /// Lower corner of the first cell, m.
    pub origin: DVec3,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
}

/// Where a particle is in a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellPlace {
    /// The cell's number, x fastest.
    pub cell: u32,
    /// Offset from the cell's lower corner, in cells: within [0, 1] but for particles beyond the
    /// edge of an open axis. Its accuracy does not depend on the distance from the origin.
    pub offset: DVec3,
}

impl CellGrid {
    /// A grid for `particles` particles in `domain` with the kernel's cutoff.
    pub fn new(domain: &Domain, kernel: &Kernel, particles: usize) -> Self {
        let extent = domain.extent();
        let mut cells = [1; 3];
        for axis in 0..kernel.dimension() {
            let fitting = extent[axis] / kernel.support_radius() * (1.0 + ROUNDING);
            // The cast saturates, and takes a NaN to 0.
            cells[axis] = (fitting as u32).max(1);
        }
        let most = (CELLS_PER_PARTICLE * particles as u64).clamp(1, u64::from(u32::MAX) / 2);
        while cells.iter().map(|&n| u128::from(n)).product::<u128>() > u128::from(most) {
            // The loop runs only while one is above 1, so there is a largest.
            let largest = if cells[0] >= cells[1].max(cells[2]) {
                0
            } else if cells[1] >= cells[2] {
                1
            } else {
                2
            };
            cells[largest] = cells[largest].div_ceil(2);
        }
        let mut size = DVec3::splat(kernel.support_radius());
        for axis in 0..kernel.dimension() {
            // An open axis of one cell may be shorter than the support radius.
            if domain.periodic[axis] || extent[axis] > size[axis] {
                size[axis] = extent[axis] / f64::from(cells[axis]);
            }
        }
        Self {
            cells,
            size,
            origin: domain.min,
            periodic: domain.periodic,
        }
    }

    /// How many cells there are.
    pub fn count(&self) -> u32 {
        self.cells.iter().product()
    }

    /// The place of `position` (m): wrapped round periodic axes; beyond the edge of an open one it
    /// belongs to the last cell.
    pub fn place(&self, position: DVec3) -> CellPlace {
        let mut at = [0_u32; 3];
        let mut offset = (position - self.origin) / self.size;
        for axis in 0..3 {
            if self.cells[axis] == 1 && !self.periodic[axis] {
                continue;
            }
            let cells = f64::from(self.cells[axis]);
            let number = if self.periodic[axis] {
                offset[axis] -= cells * (offset[axis] / cells).floor();
                offset[axis].floor().min(cells - 1.0)
            } else {
                offset[axis].floor().clamp(0.0, cells - 1.0)
            };
            offset[axis] -= number;
            at[axis] = number as u32;
        }
        CellPlace {
            cell: (at[2] * self.cells[1] + at[1]) * self.cells[0] + at[0],
            offset,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::CellGrid;
    use crate::model::{Domain, Kernel, KernelKind};

    fn grid(max: DVec3, periodic: [bool; 3], particles: usize) -> CellGrid {
        let kernel = Kernel::new(KernelKind::CubicSpline, 3, 1.0).expect("defined in 3-D");
        let min = DVec3::ZERO;
        CellGrid::new(&Domain { min, max, periodic }, &kernel, particles)
    }

    #[test]
    fn cells_are_never_narrower_than_the_cutoff_and_never_too_many() {
        let dense = grid(DVec3::new(3.7, 2.0, 0.2), [false, true, false], 1000);
        assert_eq!(dense.cells, [3, 2, 1]);
        assert!(dense.size.min_element() >= 1.0);
        let sparse = grid(DVec3::splat(1e7), [false; 3], 10);
        assert!(sparse.count() <= 20 && sparse.size.min_element() >= 1.0);
        assert_eq!(grid(DVec3::splat(9.0), [false; 3], 0).count(), 1);
    }

    #[test]
    fn a_place_gives_the_position_back() {
        let grid = grid(DVec3::splat(4.0), [true, false, false], 1000);
        let place = grid.place(DVec3::new(-0.25, 5.5, 3.75));
        assert_eq!(place.cell, (3 * 4 + 3) * 4 + 3);
        assert_eq!(place.offset, DVec3::new(0.75, 2.5, 0.75));
        assert_ne!(place, grid.place(DVec3::new(0.25, 5.5, 3.75)));
    }
}
