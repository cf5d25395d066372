//! Vectors on the device: changes and rates of the state, with what integrators and solvers do to
//! them.
//!
//! A vector is in the parts of the state, in its precision and order, and in plain units. A last small
//! buffer has what the outside gave, an entry for each held particle and then one for each slot of a
//! wall, to be multiplied by its volume. Passes and buffers are made when an operation first needs them:
//! a run of explicit Euler steps has none.

mod aggregates;
mod arithmetic;
mod curves;
mod operations;
mod passes;
mod queue;
mod reductions;

use std::sync::{Arc, Weak};

use super::operator::Operator;
use super::passes::{COMBINATION, NO_SLOT};
use super::steps::Steps;
use super::{GpuBackend, by_place};
use crate::gpu::{Buffer, Device, GpuError};
use crate::model::Problem;

use aggregates::Aggregates;

pub(super) use operations::Operations;
use passes::REDUCED;
pub use passes::{ENTRIES, PLACES, UPDATE, vector_passes};
use queue::Queue;

/// A vector on the device.
#[derive(Debug)]
pub struct GpuVector {
    number: u64,
    parts: Vec<Buffer>,
    given: Buffer,
    /// Nothing but what ends with the vector.
    _life: Arc<()>,
}

impl GpuVector {
    /// The parts, and what the outside gave.
    fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        self.parts.iter().chain([&self.given])
    }
}

/// What operations on vectors need of a scene.
#[derive(Debug)]
pub(super) struct VectorScene {
    /// Place, slot of a wall and place among the held of each particle that has one of these.
    pub(super) exceptions: Vec<[u32; 4]>,
    pub(super) capacities: Capacities,
}

/// The capacities of particles.
#[derive(Debug)]
pub(super) enum Capacities {
    /// All have this one.
    Same(f64),
    /// By place.
    Each(Vec<f64>),
}

impl Capacities {
    /// Those of the particles at sites, which may have none.
    pub(super) fn of_sites(problem: &Problem, order: Option<&[u32]>) -> Self {
        let particles = 0..problem.particles.len();
        match Self::of(particles.map(|particle| problem.capacity(particle))) {
            Self::Same(capacity) => Self::Same(capacity),
            Self::Each(capacities) => Self::Each(by_place(order, &capacities, 0.0).into_owned()),
        }
    }

    /// Those of particles in the order of the device.
    pub(super) fn of(volume: impl Iterator<Item = f64> + Clone) -> Self {
        let first = volume.clone().next().unwrap_or(0.0);
        match volume.clone().all(|volume| volume == first) {
            true => Self::Same(first),
            false => Self::Each(volume.collect()),
        }
    }

    /// The capacity that those on the device are relative to.
    fn reference(&self) -> f64 {
        match self {
            Self::Same(volume) => *volume,
            Self::Each(capacities) => capacities.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// What all vectors of a scene share on the device.
#[derive(Debug)]
pub(super) struct Tools {
    /// Factors of combinations and of sums.
    combination: Buffer,
    update: Buffer,
    exception: Buffer,
    /// Entries of what the outside gave to nothing.
    nothing_given: Buffer,
    /// In place of what sites of a lattice get among held ones, and of the sources of walls: a change
    /// has neither.
    nothing_held: Option<Buffer>,
    no_source: Option<Buffer>,
    /// What the sources of walls have gained.
    source: Buffer,
    /// What workgroups found, by part.
    sums: Vec<Buffer>,
    /// Capacities over the reference capacity, where they differ.
    capacity: Option<Buffer>,
    /// Changes of potentials, once asked for.
    potential: Option<GpuVector>,
    /// The factor of each value in its rate a reference step, once asked for.
    diagonal: Vec<Buffer>,
    /// The aggregates of a coarse space, once a solver has one.
    aggregates: Option<Aggregates>,
    /// Number, life and bytes of each vector.
    vectors: Vec<(u64, Weak<()>, u64)>,
    /// The most bytes that they had at once.
    most_bytes: u64,
    made: u64,
    queue: Queue,
}

impl Tools {
    fn new(
        device: &Device,
        operator: &Operator,
        steps: &Steps,
        scene: &VectorScene,
    ) -> Result<Self, GpuError> {
        let precision = operator.precision();
        let real = precision.real();
        let entries = scene.entries();
        let reals = |count: u64| count * real.size() as u64;
        let twin = |buffer: &Buffer| device.storage("nothing", buffer.bytes());
        let sums = |part: &Buffer| {
            let groups = precision.values_in(part).div_ceil(REDUCED);
            device.storage("sums", reals(4 * groups))
        };
        let held = match operator {
            Operator::List { .. } | Operator::Search { .. } => None,
            Operator::Lattice(_) => steps.exchange().map(twin),
        };
        let walls = steps.walls().map(|walls| twin(walls.buffers()[1]));
        Ok(Self {
            combination: device.block("factors", &COMBINATION.contents(real, [0], [0.0; 2]))?,
            update: device.block("factors", &UPDATE.contents(real, [0], [0.0; 5]))?,
            exception: device
                .storage_with("exceptions", bytemuck::cast_slice(&scene.exceptions))?,
            nothing_given: device
                .storage("nothing given", (entries.0 + entries.1) * precision.state_bytes())?,
            nothing_held: held.transpose()?,
            no_source: walls.transpose()?,
            source: device.storage("changes of sources", reals(entries.1))?,
            sums: steps.state().iter().map(sums).collect::<Result<_, _>>()?,
            capacity: None,
            potential: None,
            diagonal: Vec::new(),
            aggregates: None,
            vectors: Vec::new(),
            most_bytes: 0,
            made: 0,
            queue: Queue::default(),
        })
    }

    /// A vector of zeros.
    fn vector(&mut self, device: &Device, steps: &Steps) -> Result<GpuVector, GpuError> {
        self.vectors.retain(|(_, life, _)| life.strong_count() > 0);
        let vectors = &self.vectors;
        self.queue.retain(|number| vectors.iter().any(|(lives, ..)| *lives == number));
        let twin = |buffer: &Buffer| device.storage("vector", buffer.bytes());
        let parts: Vec<Buffer> = steps.state().iter().map(twin).collect::<Result<_, _>>()?;
        let given = twin(&self.nothing_given)?;
        let bytes = parts.iter().chain([&given]).map(Buffer::bytes).sum();
        let life = Arc::new(());
        self.made += 1;
        self.vectors.push((self.made, Arc::downgrade(&life), bytes));
        let all = self.vectors.iter().map(|(.., bytes)| bytes).sum();
        self.most_bytes = self.most_bytes.max(all);
        Ok(GpuVector { number: self.made, parts, given, _life: life })
    }

    /// Bytes on the device, at most.
    fn bytes(&self) -> u64 {
        let blocks = [&self.combination, &self.update, &self.exception, &self.nothing_given];
        let buffers = blocks.into_iter().chain([&self.source]).chain(&self.sums);
        let buffers = buffers.chain(&self.nothing_held).chain(&self.no_source);
        let buffers = buffers.chain(&self.capacity).chain(&self.diagonal);
        let aggregates = self.aggregates.as_ref().map_or(0, Aggregates::bytes);
        self.most_bytes + buffers.map(Buffer::bytes).sum::<u64>() + aggregates
    }
}

impl VectorScene {
    /// How many particles are held, and how many slots of walls there are.
    fn entries(&self) -> (u64, u64) {
        let count = |of: usize| self.exceptions.iter().filter(|e| e[of] != NO_SLOT).count() as u64;
        (count(2), count(1))
    }
}

impl GpuBackend {
    /// What is done to vectors.
    pub(super) fn vectors(&mut self) -> Result<Operations<'_>, GpuError> {
        self.steps.settle(&self.device)?;
        let tools = match self.tools.take() {
            Some(tools) => tools,
            None => Box::new(Tools::new(&self.device, &self.operator, &self.steps, &self.scene)?),
        };
        Ok(Operations {
            device: &self.device,
            operator: &self.operator,
            steps: &mut self.steps,
            scene: &self.scene,
            held: &self.held,
            order: self.order.as_deref(),
            reference_step: self.reference_step,
            tools: self.tools.insert(tools),
        })
    }

    /// Bytes of all that vectors have on the device.
    pub(super) fn vector_bytes(&self) -> u64 {
        self.tools.as_ref().map_or(0, |tools| tools.bytes())
    }
}
