//! Sums over neighbours that are searched for in every sum, instead of a list: the sorted particles stay on
//! the device, and nothing more.

use super::passes::{CHUNK, Choices, HELD_BIT, MARKED_MASK, NO_SLOT, WALL_BIT};
use super::sorted::Sorted;
use super::walls::{Fold, Walls};
use crate::gpu::{Buffer, Device, GpuError};

/// What sums over neighbours search in.
#[derive(Debug)]
pub(super) struct Search {
    sorted: Sorted,
    /// All rows.
    block: Buffer,
    /// Volume and properties of each row; only where they differ.
    coefficient: Option<Buffer>,
    /// The element of the fold of each row, or [`MARKED_MASK`], with [`HELD_BIT`] in held rows and
    /// [`WALL_BIT`] in those with a slot of a wall; only where there are such rows.
    row_mark: Option<Buffer>,
    fold: Option<Fold>,
}

impl Search {
    /// The search among `sorted`, whose rows `held_rows` are held, with what `walls` add.
    pub(super) fn new(
        device: &Device,
        choices: &Choices,
        sorted: Sorted,
        held_rows: &[u32],
        walls: &Walls,
        coefficient: Option<Buffer>,
    ) -> Result<Self, GpuError> {
        let count = sorted.order().len();
        let block = CHUNK.contents(choices.real(), [0, count as u32], []);
        let row_mark = if held_rows.is_empty() && !walls.is_folded() {
            None
        } else {
            let marks = marks(count, held_rows, walls.folded());
            Some(device.storage_with("row marks", bytemuck::cast_slice(&marks))?)
        };
        Ok(Self {
            sorted,
            block: device.block("rows", &block)?,
            coefficient,
            row_mark,
            fold: walls.fold(device, choices.real())?,
        })
    }

    pub(super) fn row_count(&self) -> u64 {
        self.sorted.order().len() as u64
    }

    /// The buffers of the sums over neighbours.
    pub(super) fn of_sums(&self) -> Vec<&Buffer> {
        let Sorted { grid, offset, cell, cell_start, .. } = &self.sorted;
        let mut buffers = vec![&self.block, grid, offset, cell, cell_start];
        buffers.extend(&self.coefficient);
        buffers.extend(&self.row_mark);
        buffers.extend(self.fold.iter().flat_map(|fold| &fold.buffers));
        buffers
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.of_sums().into_iter().map(Buffer::bytes).sum()
    }
}

/// The mark of each of `count` rows; `folded` has the row, two entries and the slot of each that walls
/// add to.
fn marks(count: usize, held_rows: &[u32], folded: &[[u32; 4]]) -> Vec<u32> {
    let mut marks = vec![MARKED_MASK; count];
    for (index, &[row, _, _, slot]) in (0..).zip(folded) {
        marks[row as usize] = if slot == NO_SLOT { index } else { index | WALL_BIT };
    }
    held_rows.iter().for_each(|&row| marks[row as usize] |= HELD_BIT);
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_name_what_walls_add_to_them() {
        let folded = [[2, 0, 3, NO_SLOT], [0, 3, 3, 0]];
        let expected = [1 | WALL_BIT, MARKED_MASK, HELD_BIT, MARKED_MASK | HELD_BIT];
        assert_eq!(marks(4, &[2, 3], &folded), expected);
    }
}
