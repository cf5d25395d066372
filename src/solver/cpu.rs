//! The CPU backend: assembled rows in f64, on every core.

use rayon::prelude::*;

use super::{Backend, SolverError};
use crate::model::Problem;
use crate::model::operator::rows::{Rows, assemble, cell_grid};
use crate::model::sum::CompensatedSum;

/// Values that one parallel task looks at.
const CHUNK: usize = 1 << 15;

/// A field of the CPU backend, in the problem's order.
#[derive(Clone, Debug, PartialEq)]
pub struct CpuField(Vec<f64>);

impl CpuField {
    /// From values in the problem's order.
    pub(super) fn new(values: Vec<f64>) -> Self {
        Self(values)
    }
}

impl AsRef<[f64]> for CpuField {
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

/// The state and the matrix of a scene in memory; ranks are places in cell order.
pub struct CpuBackend {
    /// Particle index at each rank.
    order: Vec<u32>,
    rows: Rows,
    /// Volumes of the held particles, by rank.
    held_volume: Vec<f64>,
    state: Vec<f64>,
    next: Vec<f64>,
    /// Source of the wall rows, 1/s x value.
    source: Vec<f64>,
    /// What held particles and walls have given to the others: value x volume.
    exchange: CompensatedSum,
    saved: Option<(Vec<f64>, CompensatedSum)>,
}

impl CpuBackend {
    /// Assembles the rows of `problem` and takes them.
    pub fn of(problem: &Problem) -> Self {
        let grid = cell_grid(problem);
        let (_, rows) = assemble(problem, &grid);
        Self::new(problem, grid.into_order(), rows)
    }

    /// Takes the assembled rows of `problem`; `order` is the grid's.
    pub fn new(problem: &Problem, order: Vec<u32>, rows: Rows) -> Self {
        let particle_at = |rank: &u32| order[*rank as usize] as usize;
        let held = rows.held_rank().iter().map(particle_at);
        let state: Vec<f64> = order.iter().map(|&p| problem.initial[p as usize]).collect();
        let mut source = Vec::new();
        rows.walls().source_at(0.0, &mut source);
        Self {
            source,
            held_volume: held.map(|particle| problem.particles.volume[particle]).collect(),
            next: state.clone(),
            saved: None,
            exchange: CompensatedSum::default(),
            order,
            rows,
            state,
        }
    }

    /// Brings the source to `time` (s).
    fn update_source(&mut self, time: f64) {
        if self.rows.walls().is_changing() {
            self.rows.walls().source_at(time, &mut self.source);
        }
    }

    fn step(&mut self, time: f64, dt: f64) {
        self.update_source(time);
        if !self.held_volume.is_empty() {
            // What holding the values takes: the negative of what the held rows would gain.
            let gains = self.rows.held_rates(&self.state).zip(&self.held_volume);
            let gained: f64 = gains.map(|(rate, volume)| volume * rate).sum();
            self.exchange.add(-dt * gained);
        }
        if !self.source.is_empty() {
            self.exchange.add(dt * self.rows.walls().inflow(&self.state, &self.source));
        }
        self.rows.apply(&self.state, &self.source, &mut self.next, |own, rate| own + dt * rate);
        std::mem::swap(&mut self.state, &mut self.next);
    }

    /// From cell order to the problem's order.
    fn in_problem_order(&self, by_rank: &[f64]) -> CpuField {
        let mut out = vec![0.0; self.order.len()];
        for (&particle, value) in self.order.iter().zip(by_rank) {
            out[particle as usize] = *value;
        }
        CpuField(out)
    }
}

impl Backend for CpuBackend {
    type Field = CpuField;

    fn euler(&mut self, time: f64, dt: f64, count: u64) -> Result<(), SolverError> {
        for step in 0..count {
            self.step(time + step as f64 * dt, dt);
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), SolverError> {
        Ok(())
    }

    fn read(&mut self) -> Result<CpuField, SolverError> {
        Ok(self.in_problem_order(&self.state))
    }

    fn rate(&mut self, time: f64) -> Result<CpuField, SolverError> {
        self.update_source(time);
        let mut rates = vec![0.0; self.state.len()];
        self.rows.apply(&self.state, &self.source, &mut rates, |_, rate| rate);
        Ok(self.in_problem_order(&rates))
    }

    fn exchange(&mut self) -> Result<f64, SolverError> {
        Ok(self.exchange.value())
    }

    fn is_finite(&mut self) -> Result<bool, SolverError> {
        Ok(self.state.par_chunks(CHUNK).all(|part| part.iter().all(|x| x.is_finite())))
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
        let states = 2 * size_of_val(&*self.state) + saved;
        let states = states + size_of_val(&*self.held_volume) + size_of_val(&*self.source);
        self.rows.memory_bytes() + (size_of_val(&*self.order) + states) as u64
    }
}
