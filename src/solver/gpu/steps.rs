//! The state on the device, and the passes that go through the list.

use super::list::{Chunk, List};
use super::passes::{Choices, STEP_SIZE};
use super::walls::WallSlots;
use crate::gpu::{Buffer, Device, GpuError, Pace, Pass, Real};

/// Dispatches in a submission at most.
const MOST_DISPATCHES: u64 = 1000;

/// The state with everything that changes it.
#[derive(Debug)]
pub(super) struct Steps {
    real: Real,
    /// A step reads one and writes the other.
    state: [Buffer; 2],
    /// Which of the two holds the present state.
    current: usize,
    /// What each held particle has given, value; only where there is one.
    exchange: Option<Buffer>,
    /// The rows to which walls add more than weights; only where there is one.
    walls: Option<WallSlots>,
    step_size: Buffer,
    over_reference: Option<f64>,
    flag: Buffer,
    /// A pass a chunk, by which state it reads.
    step: [Vec<Pass>; 2],
    finite: [Pass; 2],
    pace: Pace,
}

impl Steps {
    /// The passes of `list`, from values `initial` in sorted order.
    pub(super) fn new(
        device: &Device,
        choices: &Choices,
        list: &List,
        initial: &[f64],
        walls: Option<WallSlots>,
    ) -> Result<Self, GpuError> {
        let real = choices.real();
        let contents = real.to_bytes(initial);
        let state = [
            device.storage_with("state", &contents)?,
            device.storage("state", contents.len() as u64)?,
        ];
        let exchange = match choices.held {
            true => Some(device.storage("exchange", contents.len() as u64)?),
            false => None,
        };
        let step_size = device.block("step size", &STEP_SIZE.contents(real, [], [0.0]))?;
        let flag = device.storage("flag", 4)?;
        let step_of = |chunk: &Chunk, from: usize| {
            let mut buffers =
                list_buffers(list, chunk, &state, from, exchange.as_ref(), walls.as_ref());
            buffers.push(&step_size);
            device.pass(&choices.step(), &buffers, chunk.row_count())
        };
        let chunks = || list.chunks.iter();
        let steps_from =
            |from| -> Result<Vec<_>, GpuError> { chunks().map(|c| step_of(c, from)).collect() };
        let count = initial.len() as u64;
        let finite_of = |from: usize| device.pass(&choices.finite(), &[&state[from], &flag], count);
        Ok(Self {
            real,
            step: [steps_from(0)?, steps_from(1)?],
            finite: [finite_of(0)?, finite_of(1)?],
            pace: Pace::new(MOST_DISPATCHES / list.chunks.len().max(1) as u64),
            state,
            current: 0,
            exchange,
            walls,
            step_size,
            over_reference: None,
            flag,
        })
    }

    /// Takes `count` steps of `dt` (s) from `time` (s); the reference step is `reference` (s).
    pub(super) fn run(
        &mut self,
        device: &Device,
        time: f64,
        dt: f64,
        reference: f64,
        count: u64,
    ) -> Result<(), GpuError> {
        let over_reference = dt / reference;
        if self.over_reference != Some(over_reference) {
            let contents = STEP_SIZE.contents(self.real, [], [over_reference]);
            device.write(&self.step_size, &contents)?;
            self.over_reference = Some(over_reference);
        }
        let mut remaining = count;
        while remaining > 0 {
            let mut steps = self.pace.next(device, remaining)?;
            if let Some(walls) = &mut self.walls {
                steps = steps.min(walls.most_steps());
                walls.prepare(device, time + (count - remaining) as f64 * dt, dt, steps)?;
                walls.advance(steps);
            }
            let from = |k: u64| (self.current + k as usize) % 2;
            let passes = (0..steps).flat_map(|k| &self.step[from(k)]);
            let submission = device.submit(passes)?;
            self.pace.submitted(submission, steps);
            self.current = from(steps);
            remaining -= steps;
        }
        Ok(())
    }

    /// The present state.
    pub(super) fn state(&self) -> &Buffer {
        &self.state[self.current]
    }

    /// What each held particle has given, value.
    pub(super) fn exchange(&self) -> Option<&Buffer> {
        self.exchange.as_ref()
    }

    /// The rows to which walls add more than weights.
    pub(super) fn walls(&self) -> Option<&WallSlots> {
        self.walls.as_ref()
    }

    /// The same, to be changed.
    pub(super) fn walls_mut(&mut self) -> Option<&mut WallSlots> {
        self.walls.as_mut()
    }

    /// The rate of change a reference step at `time` (s); it lies where the next step will write. A
    /// run of explicit steps never asks, so its passes are made here.
    pub(super) fn rate(
        &self,
        device: &Device,
        choices: &Choices,
        list: &List,
        time: f64,
    ) -> Result<&Buffer, GpuError> {
        if let Some(walls) = &self.walls {
            walls.prepare(device, time, 0.0, 1)?;
        }
        let pass_of = |chunk: &Chunk| {
            let (exchange, walls) = (self.exchange.as_ref(), self.walls.as_ref());
            let buffers = list_buffers(list, chunk, &self.state, self.current, exchange, walls);
            device.pass(&choices.rate(), &buffers, chunk.row_count())
        };
        let passes = list.chunks.iter().map(pass_of).collect::<Result<Vec<_>, _>>()?;
        device.submit(&passes)?;
        Ok(&self.state[1 - self.current])
    }

    /// Whether every value is finite.
    pub(super) fn is_finite(&self, device: &Device) -> Result<bool, GpuError> {
        device.write(&self.flag, &[0; 4])?;
        device.submit([&self.finite[self.current]])?;
        Ok(device.read(&self.flag)?.iter().all(|&byte| byte == 0))
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let fixed = [&self.state[0], &self.state[1], &self.step_size, &self.flag];
        let buffers = fixed.into_iter().chain(&self.exchange);
        buffers.map(Buffer::bytes).sum::<u64>() + self.walls.as_ref().map_or(0, WallSlots::bytes)
    }
}

/// The buffers of a pass through the list, in the order of its bindings, that reads state `from`.
fn list_buffers<'a>(
    list: &'a List,
    chunk: &'a Chunk,
    state: &'a [Buffer; 2],
    from: usize,
    exchange: Option<&'a Buffer>,
    walls: Option<&'a WallSlots>,
) -> Vec<&'a Buffer> {
    let mut buffers = vec![
        &chunk.block,
        &list.row_length,
        &list.slice_start,
        &chunk.neighbor,
        &chunk.weight,
        &state[from],
        &state[1 - from],
    ];
    buffers.extend(exchange);
    buffers.extend(walls.into_iter().flat_map(|walls| [&walls.wall, &walls.source]));
    buffers
}
