//! The CPU backend of scenes that are lattices: two states and a stencil, and nothing more but for
//! the rows that need it.

pub(super) mod kernel;

use std::ops::Range;

use rayon::prelude::*;

use super::cpu::CpuField;
use super::{Backend, SolverError};
use crate::model::Problem;
use crate::model::lattice::LatticeScene;
use crate::model::operator::WallRows;
use crate::model::sum::CompensatedSum;

use kernel::{Combine, Run, Scratch};

/// Values that one parallel task works on, about: enough to be worth handing out.
const TASK: usize = 1 << 14;
/// Below this many particles one thread is faster than handing out tasks for every step.
const SERIAL: usize = 1 << 15;

/// The rate alone.
const RATE: Combine = Combine { share: 0.0, scale: 1.0 };

/// A lattice in memory. States are in the order of the sites.
pub struct LatticeBackend {
    scene: LatticeScene,
    /// Volume of a particle.
    volume: f64,
    /// Sites of the held particles, ascending.
    held: Vec<u32>,
    /// What ghosts add to the diagonal of each of them, 1/s: it is no exchange with other particles.
    held_diagonal: Vec<f64>,
    /// The rows that walls act on, by site.
    walls: WallRows,
    /// Their source, 1/s x value.
    source: Vec<f64>,
    state: Vec<f64>,
    next: Vec<f64>,
    /// What held particles and walls have given to the others: value x volume.
    exchange: CompensatedSum,
    saved: Option<(Vec<f64>, CompensatedSum)>,
}

impl LatticeBackend {
    /// The lattice `scene` of `problem`, whose walls add `walls` at its sites.
    pub fn new(problem: &Problem, scene: LatticeScene, walls: WallRows) -> Self {
        let mut held = problem.held.clone();
        if let Some(sites) = scene.sites() {
            held.iter_mut().for_each(|particle| *particle = sites[*particle as usize]);
            held.sort_unstable();
        }
        let mut source = Vec::new();
        walls.source_at(0.0, &mut source);
        let state = scene.by_site(&problem.initial);
        let diagonal = |&site: &u32| scene.ghost_diagonal(site as usize);
        Self {
            held_diagonal: held.iter().map(diagonal).collect(),
            volume: problem.particles.volume.first().copied().unwrap_or(0.0),
            next: vec![0.0; state.len()],
            exchange: CompensatedSum::default(),
            saved: None,
            scene,
            held,
            walls,
            source,
            state,
        }
    }

    /// Brings the source to `time` (s).
    fn update_source(&mut self, time: f64) {
        if self.walls.is_changing() {
            self.walls.source_at(time, &mut self.source);
        }
    }

    /// Values of a task: whole lines, or a part of a line that is long.
    fn task(&self) -> usize {
        let nx = self.scene.counts[0];
        if nx < TASK { nx * (TASK / nx).max(1) } else { TASK }
    }

    /// Writes what `combine` makes of values and rates everywhere; returns what entered a second,
    /// value x volume / s.
    fn apply(&self, out: &mut [f64], combine: Combine) -> f64 {
        let task = self.task();
        let scratch = || Scratch::new(&self.scene);
        let advance = |scratch: &mut Scratch, (k, out): (usize, &mut [f64])| {
            self.advance(scratch, k * task, out, combine)
        };
        let entered: Vec<f64> = if out.len() < SERIAL {
            let mut scratch = scratch();
            out.chunks_mut(task).enumerate().map(|part| advance(&mut scratch, part)).collect()
        } else {
            out.par_chunks_mut(task).enumerate().map_init(scratch, advance).collect()
        };
        let through_walls = match self.walls.is_empty() {
            true => 0.0,
            false => self.walls.inflow(&self.state, &self.source),
        };
        through_walls + entered.iter().sum::<f64>()
    }

    /// Writes the values from `first` on; returns what the held ones among them gave.
    fn advance(
        &self,
        scratch: &mut Scratch,
        first: usize,
        out: &mut [f64],
        combine: Combine,
    ) -> f64 {
        let (mut given, mut done) = (0.0, 0);
        while done < out.len() {
            let run = Run::starting(&self.scene, first + done, out.len() - done);
            let out = &mut out[done..done + run.length];
            let sites = run.first..run.first + run.length;
            done += run.length;
            if !self.is_exceptional(&sites) {
                scratch.work(&self.scene, &self.state, &run, combine, out);
                continue;
            }
            scratch.work(&self.scene, &self.state, &run, RATE, out);
            given += self.exceptions(sites.clone(), out);
            for (out, own) in out.iter_mut().zip(&self.state[sites]) {
                *out = combine.share * own + combine.scale * *out;
            }
        }
        given
    }

    /// Whether a held particle or one with a source of a wall is among `sites`.
    fn is_exceptional(&self, sites: &Range<usize>) -> bool {
        !(within(&self.held, sites).is_empty() && within(self.walls.rank(), sites).is_empty())
    }

    /// Adds the sources of walls at `sites` to their rates and takes those of held particles out;
    /// returns what these gave.
    fn exceptions(&self, sites: Range<usize>, rate: &mut [f64]) -> f64 {
        let mut given = 0.0;
        for k in within(&self.held, &sites) {
            let held = self.held[k] as usize;
            let rate = &mut rate[held - sites.start];
            given -= self.volume * (*rate - self.held_diagonal[k] * self.state[held]);
            *rate = 0.0;
        }
        for row in within(self.walls.rank(), &sites) {
            rate[self.walls.rank()[row] as usize - sites.start] += self.source[row];
        }
        given
    }
}

/// Which of `ranks`, which ascend, are among `sites`.
fn within(ranks: &[u32], sites: &Range<usize>) -> Range<usize> {
    let place = |site: usize| ranks.partition_point(|&rank| (rank as usize) < site);
    place(sites.start)..place(sites.end)
}

impl Backend for LatticeBackend {
    type Field = CpuField;

    fn euler(&mut self, time: f64, dt: f64, count: u64) -> Result<(), SolverError> {
        let mut next = std::mem::take(&mut self.next);
        for step in 0..count {
            self.update_source(time + step as f64 * dt);
            let entered = self.apply(&mut next, Combine { share: 1.0, scale: dt });
            self.exchange.add(dt * entered);
            std::mem::swap(&mut self.state, &mut next);
        }
        self.next = next;
        Ok(())
    }

    fn wait(&mut self) -> Result<(), SolverError> {
        Ok(())
    }

    fn read(&mut self) -> Result<CpuField, SolverError> {
        Ok(CpuField::new(self.scene.by_particle(&self.state)))
    }

    fn rate(&mut self, time: f64) -> Result<CpuField, SolverError> {
        self.update_source(time);
        let mut rates = vec![0.0; self.state.len()];
        self.apply(&mut rates, RATE);
        Ok(CpuField::new(self.scene.by_particle(&rates)))
    }

    fn exchange(&mut self) -> Result<f64, SolverError> {
        Ok(self.exchange.value())
    }

    fn is_finite(&mut self) -> Result<bool, SolverError> {
        Ok(self.state.par_chunks(TASK).all(|part| part.iter().all(|x| x.is_finite())))
    }

    fn save(&mut self) -> Result<(), SolverError> {
        let (state, exchange) = self.saved.get_or_insert_default();
        state.clone_from(&self.state);
        *exchange = self.exchange;
        Ok(())
    }

    fn restore(&mut self) -> Result<(), SolverError> {
        if let Some((state, exchange)) = &self.saved {
            self.state.clone_from(state);
            self.exchange = *exchange;
        }
        Ok(())
    }

    fn memory_bytes(&self) -> u64 {
        let saved = self.saved.as_ref().map_or(0, |(state, _)| size_of_val(&**state));
        let states = 2 * size_of_val(&*self.state) + saved + size_of_val(&*self.source);
        let order = self.scene.order.as_ref().map_or(0, |order| size_of_val(&**order));
        let held = size_of_val(&*self.held) + size_of_val(&*self.held_diagonal);
        (states + order + held + self.walls.memory_bytes()) as u64
    }
}
