//! Particles sorted by cell, on the device.

use glam::DVec3;

use super::passes::{Choices, GRID};
use crate::gpu::{Buffer, Device, GpuError, Scan};
use crate::model::neighbors::CellLayout;

/// Particles sorted by cell, and inside a cell by index.
///
/// Only the search for neighbours needs it: a scene at rest drops it once a list is built.
#[derive(Debug)]
pub struct Sorted {
    pub(super) grid: Buffer,
    pub(super) offset: Buffer,
    pub(super) cell: Buffer,
    pub(super) cell_start: Buffer,
    order: Vec<u32>,
}

/// The buffers in the problem's order, and what sorting needs besides.
struct Scratch {
    offset: Buffer,
    cell: Buffer,
    taken: Buffer,
    scattered: Buffer,
    order: Buffer,
}

impl Sorted {
    /// Sorts particles at `positions` (m). `weight_scale` is what the pair weights will be scaled
    /// by, and `support_radius` (m) what distances are divided by.
    pub fn new(
        device: &Device,
        choices: &Choices,
        cells: &CellLayout,
        positions: &[DVec3],
        support_radius: f64,
        weight_scale: f64,
    ) -> Result<Self, GpuError> {
        let count = positions.len() as u64;
        let scratch = Scratch::new(device, choices, cells, positions)?;
        let ratio = cells.size / support_radius;
        let [x, y, z] = cells.cells;
        let contents = GRID.contents(
            choices.real(),
            [x, y, z, positions.len() as u32],
            [ratio.x, ratio.y, ratio.z, weight_scale],
        );
        let reals = count * (choices.dimension * choices.real().size()) as u64;
        let mut sorted = Self {
            grid: device.block("cell grid", &contents)?,
            offset: device.storage("offsets", reals)?,
            cell: device.storage("cells of particles", 4 * count)?,
            cell_start: device.storage("cell starts", 4 * (cells.count() as u64 + 1))?,
            order: Vec::new(),
        };
        sorted.sort(device, choices, &scratch, count)?;
        sorted.order = bytemuck::pod_collect_to_vec(&device.read(&scratch.order)?);
        Ok(sorted)
    }

    fn sort(
        &self,
        device: &Device,
        choices: &Choices,
        scratch: &Scratch,
        count: u64,
    ) -> Result<(), GpuError> {
        let (grid, start) = (&self.grid, &self.cell_start);
        let Scratch { offset, cell, taken, scattered, order } = scratch;
        let bin = device.pass(&choices.bin(), &[grid, offset, cell], count)?;
        let cell_count = device.pass(&choices.cell_count(), &[grid, cell, start], count)?;
        // The counts have one element more than there are cells, so that their exclusive sums end
        // with the total: cell c holds the places cell_start[c]..cell_start[c + 1].
        let scan = Scan::new(device, start)?;
        let buffers = [grid, cell, start, taken, scattered];
        let scatter = device.pass(&choices.scatter(), &buffers, count)?;
        let buffers = [grid, cell, start, scattered, order];
        let by_index = device.pass(&choices.rank(), &buffers, count)?;
        let buffers = [grid, order, offset, cell, &self.offset, &self.cell];
        let gather = device.pass(&choices.gather(), &buffers, count)?;
        let passes = [&bin, &cell_count].into_iter().chain(scan.passes());
        device.submit(passes.chain([&scatter, &by_index, &gather]))?;
        Ok(())
    }

    /// Which particle is in each row.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The first row of each cell, and the number of rows: a diagnostic.
    pub fn cell_starts(&self, device: &Device) -> Result<Vec<u32>, GpuError> {
        Ok(bytemuck::pod_collect_to_vec(&device.read(&self.cell_start)?))
    }
}

impl Scratch {
    fn new(
        device: &Device,
        choices: &Choices,
        cells: &CellLayout,
        positions: &[DVec3],
    ) -> Result<Self, GpuError> {
        let mut offset = Vec::with_capacity(positions.len() * choices.dimension);
        let mut cell = Vec::with_capacity(positions.len());
        for &position in positions {
            let place = cells.place(position);
            offset.extend_from_slice(&place.offset.to_array()[..choices.dimension]);
            cell.push(place.cell);
        }
        let bytes = 4 * positions.len() as u64;
        Ok(Self {
            offset: device.storage_with("offsets", &choices.real().to_bytes(&offset))?,
            cell: device.storage_with("cells of particles", bytemuck::cast_slice(&cell))?,
            taken: device.storage("places taken", 4 * cells.count() as u64)?,
            scattered: device.storage("scattered particles", bytes)?,
            order: device.storage("order", bytes)?,
        })
    }
}
