//! What walls add, on the device.

use super::passes::{NO_SLOT, SOURCE_STEPS, WallTerms};
use crate::gpu::{Buffer, Device, GpuError, Real};
use crate::model::Problem;
use crate::model::operator::SourceRows;
use crate::model::operator::rows::{WallFold, cell_grid, wall_fold};

/// The walls of a scene, by rows of the device.
#[derive(Debug)]
pub(super) struct Walls {
    /// Row, first and end entry of `weight`, and slot, of each row that walls add to.
    fold: Vec<[u32; 4]>,
    /// Neighbour and what its weight gets a reference step.
    weight: Vec<(u32, f64)>,
    /// Row of each slot.
    slot_row: Vec<u32>,
    /// Everything that goes with a slot, in their order.
    rows: SourceRows,
    reference_step: f64,
}

impl Walls {
    /// The walls of `problem` for rows in `order`, scaled by the reference step (s).
    pub(super) fn new(problem: &Problem, order: &[u32], reference_step: f64) -> Self {
        let grid = cell_grid(problem);
        let WallFold { mut weight, rows, .. } = wall_fold(problem, &grid);
        // Between two held particles nothing is exchanged; their weights need not be symmetric.
        let is_held = |rank: u32| problem.is_held(grid.order()[rank as usize] as usize);
        weight.retain(|&(a, b, _)| !(is_held(a) && is_held(b)));
        let mut row_of_particle = vec![0_u32; order.len()];
        for (row, &particle) in (0..).zip(order) {
            row_of_particle[particle as usize] = row;
        }
        let row_of = |rank: u32| row_of_particle[grid.order()[rank as usize] as usize];
        let slot_row: Vec<u32> = rows.rank().iter().map(|&rank| row_of(rank)).collect();
        let mut walls =
            Self { fold: Vec::new(), weight: Vec::new(), slot_row, rows, reference_step };
        walls.add_weights(&weight, row_of);
        walls
    }

    /// Groups the weights, which come row by row in the order of ranks, and merges them with the
    /// slots, which come in the same order but only for some rows, and for some rows alone.
    fn add_weights(&mut self, weight: &[(u32, u32, f64)], row_of: impl Fn(u32) -> u32) {
        let ranks = self.rows.rank().to_vec();
        let mut slots = (0..).zip(&ranks).peekable();
        let mut groups = weight.chunk_by(|a, b| a.0 == b.0).peekable();
        loop {
            let next_group = groups.peek().map(|group| group[0].0);
            let next_slot = slots.peek().map(|&(_, &rank)| rank);
            let Some(rank) = next_group.into_iter().chain(next_slot).min() else {
                return;
            };
            let first = self.weight.len() as u32;
            if let Some(group) = groups.next_if(|group| group[0].0 == rank) {
                let scaled = |&(_, b, w): &(u32, u32, f64)| (row_of(b), w * self.reference_step);
                self.weight.extend(group.iter().map(scaled));
            }
            let slot = slots.next_if(|&(_, &r)| r == rank).map_or(NO_SLOT, |(slot, _)| slot);
            self.fold.push([row_of(rank), first, self.weight.len() as u32, slot]);
        }
    }

    /// What they add to a step.
    pub(super) fn terms(&self) -> WallTerms {
        WallTerms::of(&self.rows)
    }

    /// The rows that have a slot, in the order of the slots, with everything that goes with them.
    pub(super) fn into_rows(self) -> SourceRows {
        self.rows
    }

    /// The rows that have a slot, in the order of the slots.
    pub(super) fn slot_rows(&self) -> &[u32] {
        &self.slot_row
    }

    /// Whether they add anything to any row.
    pub(super) fn is_folded(&self) -> bool {
        !self.fold.is_empty()
    }

    /// Row, first and end entry, and slot, of each row that they add to.
    pub(super) fn folded(&self) -> &[[u32; 4]] {
        &self.fold
    }

    /// The buffers `fold`, `fold_neighbor` and `fold_weight` with the number of rows; `None` where
    /// walls add nothing.
    pub(super) fn fold(&self, device: &Device, real: Real) -> Result<Option<Fold>, GpuError> {
        if self.fold.is_empty() {
            return Ok(None);
        }
        let (neighbor, weight): (Vec<u32>, Vec<f64>) = self.weight.iter().copied().unzip();
        let buffers = [
            device.storage_with("wall fold", bytemuck::cast_slice(&self.fold))?,
            device.storage_with("wall fold neighbours", bytemuck::cast_slice(&neighbor))?,
            device.storage_with("wall fold weights", &real.to_bytes(&weight))?,
        ];
        Ok(Some(Fold { buffers, rows: self.fold.len() as u64 }))
    }
}

/// What walls add, for those who fold it into weights or sums.
#[derive(Debug)]
pub(super) struct Fold {
    pub(super) buffers: [Buffer; 3],
    pub(super) rows: u64,
}

/// The slots on the device while a run goes on.
#[derive(Debug)]
pub(super) struct WallSlots {
    real: Real,
    rows: SourceRows,
    reference_step: f64,
    /// Of each slot two vectors: diagonal, flow and tick; what entered, in two words.
    pub(super) wall: Buffer,
    pub(super) source: Buffer,
    /// The step of the ring that comes next, where sources change.
    tick: u32,
}

impl WallSlots {
    /// A slot for each of `rows`, scaled by the reference step (s); `None` if there are none.
    pub(super) fn new(
        device: &Device,
        real: Real,
        rows: SourceRows,
        reference_step: f64,
    ) -> Result<Option<Self>, GpuError> {
        if rows.is_empty() {
            return Ok(None);
        }
        let slot = |(d, f)| [[reference_step * d, reference_step * f, 0.0, 0.0], [0.0; 4]].concat();
        let contents: Vec<f64> = rows.diagonal().iter().zip(rows.flow()).flat_map(slot).collect();
        let steps = if rows.is_changing() { u64::from(SOURCE_STEPS) } else { 1 };
        let wall = device.storage_with("wall rows", &real.to_bytes(&contents))?;
        let source_bytes = steps * (rows.len() * real.size()) as u64;
        let source = device.storage("wall sources", source_bytes)?;
        let slots = Self { real, rows, reference_step, wall, source, tick: 0 };
        slots.write_sources(device, 0.0, 0.0, 1)?;
        Ok(Some(slots))
    }

    /// The rows and their sources, in the order of their bindings.
    pub(super) fn buffers(&self) -> [&Buffer; 2] {
        [&self.wall, &self.source]
    }

    /// Whether a source changes in time.
    pub(super) fn is_changing(&self) -> bool {
        self.rows.is_changing()
    }

    /// Row and diagonal of each slot that has one, a reference step.
    pub(super) fn diagonals(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let rows = self.rows.rank().iter().zip(self.rows.diagonal());
        let scaled = |(&row, &by_slot): (&u32, &f64)| (row as usize, self.reference_step * by_slot);
        rows.map(scaled).filter(|(_, by_slot)| *by_slot != 0.0)
    }

    /// What the source of each slot gains between two times (s), 1/s x value.
    pub(super) fn source_change(&self, from: f64, to: f64) -> Vec<f64> {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        self.rows.source_at(from, &mut before);
        self.rows.source_at(to, &mut after);
        after.iter().zip(&before).map(|(after, before)| after - before).collect()
    }

    /// How many steps the sources can be written for at once.
    pub(super) fn most_steps(&self) -> u64 {
        if self.rows.is_changing() { u64::from(SOURCE_STEPS) } else { u64::MAX }
    }

    /// Writes the sources of the next `steps` steps of `dt` (s) from `time` (s), if they change.
    pub(super) fn prepare(
        &self,
        device: &Device,
        time: f64,
        dt: f64,
        steps: u64,
    ) -> Result<(), GpuError> {
        if self.rows.is_changing() { self.write_sources(device, time, dt, steps) } else { Ok(()) }
    }

    /// Notes that the device takes `steps` steps.
    pub(super) fn advance(&mut self, steps: u64) {
        self.tick = ((u64::from(self.tick) + steps) % u64::from(SOURCE_STEPS)) as u32;
    }

    /// The step of the ring that comes next.
    pub(super) fn tick(&self) -> u32 {
        self.tick
    }

    /// Goes back to a step of the ring.
    pub(super) fn set_tick(&mut self, tick: u32) {
        self.tick = tick;
    }

    /// What entered through walls so far, value x capacity.
    pub(super) fn inflow(&self, device: &Device) -> Result<f64, GpuError> {
        let slots = self.real.from_bytes(&device.read(&self.wall)?);
        let entered = slots.chunks_exact(8).zip(self.rows.capacity());
        Ok(entered.map(|(slot, volume)| volume * (slot[4] + slot[5])).sum())
    }

    fn write_sources(
        &self,
        device: &Device,
        time: f64,
        dt: f64,
        steps: u64,
    ) -> Result<(), GpuError> {
        let slots = self.rows.len();
        let ring = if self.rows.is_changing() { SOURCE_STEPS as usize } else { 1 };
        let mut contents = vec![0.0; ring * slots];
        let mut source = Vec::new();
        for step in 0..steps {
            self.rows.source_at(time + step as f64 * dt, &mut source);
            let place = (self.tick as usize + step as usize) % ring;
            let of_step = &mut contents[place * slots..(place + 1) * slots];
            for (out, value) in of_step.iter_mut().zip(&source) {
                *out = self.reference_step * value;
            }
        }
        device.write(&self.source, &self.real.to_bytes(&contents))
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.wall.bytes() + self.source.bytes()
    }
}
