//! The neighbour list with its weights: sliced ELL, in chunks that the device can bind.
//!
//! Rows come in slices of [`SLICE_ROWS`], each as long as its longest row; neighbour k of a row is
//! SLICE_ROWS elements after neighbour k - 1, so that rows worked on in step read side by side.

use std::ops::Range;

use super::passes::{CHUNK, Choices, HELD_BIT, MARKED_MASK, SLICE_ROWS, WALL_BIT};
use super::sorted::Sorted;
use super::walls::{Fold, Walls};
use crate::gpu::{Buffer, Device, GpuError};

/// The neighbour list of a scene, on the device.
#[derive(Debug)]
pub(super) struct List {
    /// How many neighbours each row has, with [`HELD_BIT`] in held ones and [`WALL_BIT`] in those with a
    /// slot of a wall, which their list names after the last neighbour.
    row_mark: Buffer,
    /// First element of each slice, in its chunk.
    slice_start: Buffer,
    pub(super) chunks: Vec<Chunk>,
}

/// A range of rows with its part of the list.
#[derive(Debug)]
pub(super) struct Chunk {
    rows: Range<u32>,
    block: Buffer,
    neighbor: Buffer,
    weight: Buffer,
}

impl Chunk {
    pub(super) fn row_count(&self) -> u64 {
        u64::from(self.rows.end - self.rows.start)
    }

    /// The buffers of the sums over its neighbours.
    pub(super) fn of_sums<'a>(&'a self, list: &'a List) -> Vec<&'a Buffer> {
        vec![&self.block, &list.row_mark, &list.slice_start, &self.neighbor, &self.weight]
    }
}

/// Row lengths as slices and chunks: what the list looks like before it exists.
#[derive(Debug, PartialEq)]
struct Plan {
    slice_start: Vec<u32>,
    /// Rows and elements of each chunk.
    chunks: Vec<(Range<u32>, u64)>,
}

impl Plan {
    /// Chunks of at most `most` elements, or the elements of the slice that does not fit.
    fn new(lengths: &[u32], most: u64) -> Result<Self, u64> {
        let mut slice_start = Vec::with_capacity(lengths.len() / SLICE_ROWS as usize + 1);
        let mut chunks = Vec::new();
        let (mut first, mut elements, mut row) = (0, 0_u64, 0);
        for slice in lengths.chunks(SLICE_ROWS as usize) {
            let longest = slice.iter().copied().max().unwrap_or(0);
            let needed = u64::from(longest) * u64::from(SLICE_ROWS);
            if needed > most {
                return Err(needed);
            }
            if elements + needed > most {
                chunks.push((first..row, elements));
                (first, elements) = (row, 0);
            }
            // `most` is below 2^32.
            slice_start.push(elements as u32);
            elements += needed;
            row += slice.len() as u32;
        }
        if row > first {
            chunks.push((first..row, elements));
        }
        Ok(Self { slice_start, chunks })
    }
}

impl List {
    /// Builds the list of `sorted`, whose rows `held_rows` are held, with `walls` folded in;
    /// `coefficient` is the table of volume and diffusivity where the scene needs one. A chunk's
    /// buffers stay within `chunk_bytes` each.
    pub(super) fn new(
        device: &Device,
        choices: &Choices,
        sorted: &Sorted,
        held_rows: &[u32],
        walls: &Walls,
        coefficient: Option<&Buffer>,
        chunk_bytes: u64,
    ) -> Result<Self, GpuError> {
        let count = sorted.order().len() as u64;
        let (row_mark, mut marks) = count_neighbors(device, choices, sorted, count)?;
        let element_bytes = choices.real().size().max(4) as u64;
        let most = (chunk_bytes / element_bytes).min(u64::from(u32::MAX));
        let mut entries = marks.clone();
        walls.slot_rows().iter().for_each(|&row| entries[row as usize] += 1);
        let plan = Plan::new(&entries, most).map_err(|needed| GpuError::TooLarge {
            what: "a slice of the neighbour list".to_owned(),
            needed: needed * element_bytes,
            available: chunk_bytes,
        })?;
        if !(held_rows.is_empty() && walls.slot_rows().is_empty()) {
            held_rows.iter().for_each(|&row| marks[row as usize] |= HELD_BIT);
            walls.slot_rows().iter().for_each(|&row| marks[row as usize] |= WALL_BIT);
            device.write(&row_mark, bytemuck::cast_slice(&marks))?;
        }
        let starts = bytemuck::cast_slice(&plan.slice_start);
        let mut list = Self {
            row_mark,
            slice_start: device.storage_with("slice starts", starts)?,
            chunks: Vec::with_capacity(plan.chunks.len()),
        };
        let fold = walls.fold(device, choices.real())?;
        for (rows, elements) in plan.chunks {
            list.add(device, choices, sorted, coefficient, rows, elements)?;
            if let (Some(fold), Some(chunk)) = (&fold, list.chunks.last()) {
                list.fold(device, choices, chunk, fold)?;
            }
        }
        Ok(list)
    }

    /// Adds the walls to a chunk.
    fn fold(
        &self,
        device: &Device,
        choices: &Choices,
        chunk: &Chunk,
        fold: &Fold,
    ) -> Result<(), GpuError> {
        let mut buffers = chunk.of_sums(self);
        buffers.extend(&fold.buffers);
        let pass = device.pass(&choices.wall_fold(), &buffers, fold.rows)?;
        device.submit([&pass])?;
        Ok(())
    }

    fn add(
        &mut self,
        device: &Device,
        choices: &Choices,
        sorted: &Sorted,
        coefficient: Option<&Buffer>,
        rows: Range<u32>,
        elements: u64,
    ) -> Result<(), GpuError> {
        let real = choices.real();
        let block = CHUNK.contents(real, [rows.start, rows.end], []);
        let chunk = Chunk {
            rows,
            block: device.block("chunk", &block)?,
            neighbor: device.storage("neighbours", 4 * elements)?,
            weight: device.storage("weights", elements * real.size() as u64)?,
        };
        let mut buffers = vec![
            &sorted.grid,
            &chunk.block,
            &sorted.offset,
            &sorted.cell,
            &sorted.cell_start,
            &self.slice_start,
            &chunk.neighbor,
            &chunk.weight,
        ];
        buffers.extend(coefficient);
        let pass = device.pass(&choices.list(), &buffers, chunk.row_count())?;
        device.submit([&pass])?;
        self.chunks.push(chunk);
        Ok(())
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let chunks = self.chunks.iter();
        let of_chunk = |c: &Chunk| c.block.bytes() + c.neighbor.bytes() + c.weight.bytes();
        self.row_mark.bytes() + self.slice_start.bytes() + chunks.map(of_chunk).sum::<u64>()
    }

    /// Rows of (neighbouring row, weight), in stored order.
    pub(super) fn read(
        &self,
        device: &Device,
        choices: &Choices,
    ) -> Result<Vec<Vec<(u32, f64)>>, GpuError> {
        let counts = |buffer| device.read(buffer);
        let marks: Vec<u32> = bytemuck::pod_collect_to_vec(&counts(&self.row_mark)?);
        let starts: Vec<u32> = bytemuck::pod_collect_to_vec(&counts(&self.slice_start)?);
        let mut rows = Vec::with_capacity(marks.len());
        for chunk in &self.chunks {
            let neighbor: Vec<u32> = bytemuck::pod_collect_to_vec(&counts(&chunk.neighbor)?);
            let weight = choices.real().from_bytes(&device.read(&chunk.weight)?);
            for row in chunk.rows.clone() {
                let first = starts[(row / SLICE_ROWS) as usize] + row % SLICE_ROWS;
                let places = (0..marks[row as usize] & MARKED_MASK)
                    .map(|k| (first + k * SLICE_ROWS) as usize);
                rows.push(places.map(|i| (neighbor[i], weight[i])).collect());
            }
        }
        Ok(rows)
    }
}

/// The neighbours of each row: the buffer, and its contents.
fn count_neighbors(
    device: &Device,
    choices: &Choices,
    sorted: &Sorted,
    count: u64,
) -> Result<(Buffer, Vec<u32>), GpuError> {
    let row_length = device.storage("row lengths", 4 * count)?;
    let buffers = [&sorted.grid, &sorted.offset, &sorted.cell, &sorted.cell_start, &row_length];
    let pass = device.pass(&choices.neighbor_count(), &buffers, count)?;
    device.submit([&pass])?;
    let lengths = bytemuck::pod_collect_to_vec(&device.read(&row_length)?);
    Ok((row_length, lengths))
}

#[cfg(test)]
mod tests {
    use super::Plan;

    #[test]
    fn chunks_hold_whole_slices_within_the_limit() {
        let mut lengths = vec![2; 100];
        lengths[40] = 5;
        // Slices of 64, 160, 64 and 64 elements.
        let plan = Plan::new(&lengths, 224).expect("every slice fits");
        assert_eq!(plan.chunks, [(0..64, 224), (64..100, 128)]);
        assert_eq!(plan.slice_start, [0, 64, 0, 64]);
        assert_eq!(Plan::new(&lengths, 159), Err(160));
        assert_eq!(Plan::new(&[], 0).expect("nothing fits").chunks, []);
        let alone = Plan::new(&[0, 0], 0).expect("rows without neighbours fit");
        assert_eq!(alone.chunks, [(0..2, 0)]);
    }
}
