//! The CPU backend: assembled rows in f64, on every core.

use rayon::prelude::*;

use super::{Backend, SolverError};
use crate::model::Problem;
use crate::model::neighbors::CellGrid;
use crate::model::operator::rows::{Rows, Survey, assemble};
use crate::model::sum::CompensatedSum;

/// Rows that one parallel task advances.
const ROWS_PER_TASK: usize = 8192;
/// Below this many rows one thread is faster than handing out tasks every step.
const SERIAL_ROWS: usize = 16_384;

/// A field of the CPU backend, in the problem's order.
#[derive(Clone, Debug, PartialEq)]
pub struct CpuField(Vec<f64>);

impl AsRef<[f64]> for CpuField {
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

/// The state and the matrix of a scene in memory; ranks are places in cell order.
pub struct CpuBackend {
    /// Particle index at each rank.
    order: Vec<u32>,
    /// Rows of the particles that are free to change.
    rows: Rows,
    /// What happens at held particles; absent where there are none.
    held: Option<Held>,
    state: Vec<f64>,
    next: Vec<f64>,
    saved: Vec<f64>,
    saved_exchange: CompensatedSum,
}

/// Rows of the held particles: they do not change, but what their rows add up to is what the
/// outside has to supply.
struct Held {
    rows: Rows,
    rank: Vec<u32>,
    volume: Vec<f64>,
    exchange: CompensatedSum,
}

impl CpuBackend {
    /// Assembles the rows of `problem` from its sorted particles.
    pub fn new(problem: &Problem, grid: CellGrid<'_>, survey: &Survey) -> Self {
        let rows = assemble(problem, &grid, &survey.neighbors, |a| !problem.is_held(a));
        let held = (!problem.held.is_empty()).then(|| Held::new(problem, &grid, survey));
        let order = grid.into_order();
        let state: Vec<f64> = order.iter().map(|&p| problem.initial[p as usize]).collect();
        Self {
            next: state.clone(),
            saved: Vec::new(),
            saved_exchange: CompensatedSum::default(),
            order,
            rows,
            held,
            state,
        }
    }

    /// The assembled rows of the particles that are not held.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Volumes in the rows' order, m^dim.
    pub fn volume_by_rank(&self, problem: &Problem) -> Vec<f64> {
        self.order
            .iter()
            .map(|&p| problem.particles.volume[p as usize])
            .collect()
    }

    fn step(&mut self, dt: f64) {
        if let Some(held) = &mut self.held {
            held.account(dt, &self.state);
        }
        let (rows, state) = (&self.rows, &self.state);
        let advance = |first: usize, new: &mut [f64]| {
            let count = new.len();
            rows.rates(
                first,
                state,
                |rank, rate| new[rank - first] = state[rank] + dt * rate,
                count,
            );
        };
        if self.next.len() < SERIAL_ROWS {
            advance(0, &mut self.next);
        } else {
            let tasks = self.next.par_chunks_mut(ROWS_PER_TASK).enumerate();
            tasks.for_each(|(task, new)| advance(task * ROWS_PER_TASK, new));
        }
        std::mem::swap(&mut self.state, &mut self.next);
    }

    /// From cell order to the problem's order.
    fn in_problem_order(&self, by_rank: impl Fn(usize) -> f64) -> CpuField {
        let mut out = vec![0.0; self.order.len()];
        for (rank, &particle) in self.order.iter().enumerate() {
            out[particle as usize] = by_rank(rank);
        }
        CpuField(out)
    }
}

impl Held {
    fn new(problem: &Problem, grid: &CellGrid<'_>, survey: &Survey) -> Self {
        let rows = assemble(problem, grid, &survey.neighbors, |a| problem.is_held(a));
        let rank: Vec<u32> = (0_u32..)
            .zip(grid.order())
            .filter(|&(_, &particle)| problem.is_held(particle as usize))
            .map(|(rank, _)| rank)
            .collect();
        let particle = |rank: &u32| grid.order()[*rank as usize] as usize;
        let volume = rank
            .iter()
            .map(|r| problem.particles.volume[particle(r)])
            .collect();
        Self {
            rows,
            rank,
            volume,
            exchange: CompensatedSum::default(),
        }
    }

    /// Books what holding the values takes over a step of `dt`: the negative of what the held
    /// rows would gain. Neighbours that are held too cancel in the sum.
    fn account(&mut self, dt: f64, state: &[f64]) {
        let part = |(ranks, volumes): (&[u32], &[f64])| -> f64 {
            let gains = ranks.iter().zip(volumes);
            gains
                .map(|(&rank, volume)| volume * self.rows.rate(rank as usize, state))
                .sum()
        };
        let gained: f64 = if self.rank.len() < SERIAL_ROWS {
            part((&self.rank, &self.volume))
        } else {
            let ranks = self.rank.par_chunks(ROWS_PER_TASK);
            let parts: Vec<f64> = ranks
                .zip(self.volume.par_chunks(ROWS_PER_TASK))
                .map(part)
                .collect();
            parts.iter().sum()
        };
        self.exchange.add(-dt * gained);
    }
}

impl Backend for CpuBackend {
    type Field = CpuField;

    fn euler(&mut self, dt: f64, count: u64) -> Result<(), SolverError> {
        for _ in 0..count {
            self.step(dt);
        }
        Ok(())
    }

    fn read(&mut self) -> Result<CpuField, SolverError> {
        Ok(self.in_problem_order(|rank| self.state[rank]))
    }

    fn rate(&mut self) -> Result<CpuField, SolverError> {
        Ok(self.in_problem_order(|rank| self.rows.rate(rank, &self.state)))
    }

    fn exchange(&mut self) -> Result<f64, SolverError> {
        Ok(self.held.as_ref().map_or(0.0, |held| held.exchange.value()))
    }

    fn is_finite(&mut self) -> Result<bool, SolverError> {
        Ok(self
            .state
            .par_chunks(ROWS_PER_TASK)
            .all(|part| part.iter().all(|x| x.is_finite())))
    }

    fn save(&mut self) -> Result<(), SolverError> {
        self.saved.clone_from(&self.state);
        self.saved_exchange = self
            .held
            .as_ref()
            .map(|held| held.exchange)
            .unwrap_or_default();
        Ok(())
    }

    fn restore(&mut self) -> Result<(), SolverError> {
        self.state.clone_from(&self.saved);
        if let Some(held) = &mut self.held {
            held.exchange = self.saved_exchange;
        }
        Ok(())
    }

    fn memory_bytes(&self) -> u64 {
        let states = [&self.state, &self.next, &self.saved].map(|s| size_of_val(&**s) as u64);
        let held = self.held.as_ref().map_or(0, |held| {
            held.rows.memory_bytes()
                + (size_of_val(&*held.rank) + size_of_val(&*held.volume)) as u64
        });
        self.rows.memory_bytes()
            + size_of_val(&*self.order) as u64
            + states.iter().sum::<u64>()
            + held
    }
}
