//! The CPU backend of scenes on a lattice: two states and a stencil, and nothing more but for the rows
//! that need it.

mod kernel;
mod mixed;
mod uniform;

use std::sync::Arc;

use rayon::prelude::*;

use super::cpu::CpuField;
use super::{Backend, SolverError};
use crate::model::Problem;
use crate::model::lattice::{LatticeScene, MixedScene};
use crate::model::operator::{SomeRows, WallRows};
use crate::model::sum::CompensatedSum;

use kernel::{Combine, Scratch};
use mixed::Mixed;
use uniform::Uniform;

/// Values that one parallel task works on, about: enough to be worth handing out.
const TASK: usize = 1 << 14;
/// Below this many particles one thread is faster than handing out tasks for every step.
const SERIAL: usize = 1 << 15;

/// The rate alone.
const RATE: Combine = Combine { share: 0.0, scale: 1.0 };

/// What a rate is made of.
struct Now<'a> {
    state: &'a [f64],
    /// Source of the rows of walls, 1/s x value.
    source: &'a [f64],
}

/// A lattice with what it has beyond its stencil.
trait LatticeOperator: Send + Sync {
    fn lattice(&self) -> &LatticeScene;

    /// The rows that walls act on, by site.
    fn walls(&self) -> &WallRows;

    /// Writes what `combine` makes of values and rates from site `first` on, wherever that and the
    /// last are along their lines; returns what held particles among them gave, value x volume / s.
    fn advance(
        &self,
        scratch: &mut Scratch,
        now: &Now<'_>,
        first: usize,
        out: &mut [f64],
        combine: Combine,
    ) -> f64;

    /// Bytes that it holds, but for the order of the lattice.
    fn memory_bytes(&self) -> usize;
}

/// A lattice in memory. States are in the order of the sites; where there is no particle they are 0.
pub struct LatticeBackend {
    operator: Box<dyn LatticeOperator>,
    source: Vec<f64>,
    state: Vec<f64>,
    next: Vec<f64>,
    /// What held particles and walls have given to the others: value x volume.
    exchange: CompensatedSum,
    saved: Option<(Vec<f64>, CompensatedSum)>,
}

impl LatticeBackend {
    /// The lattice `scene` of `problem`, whose walls add `walls` at its sites.
    pub fn new(problem: &Problem, scene: impl Into<Arc<LatticeScene>>, walls: WallRows) -> Self {
        Self::with(problem, Box::new(Uniform::new(problem, scene.into(), walls)))
    }

    /// The lattice `scene` of `problem`, with the rows that its stencil does not describe.
    pub fn mixed(problem: &Problem, scene: impl Into<Arc<MixedScene>>, rows: SomeRows) -> Self {
        Self::with(problem, Box::new(Mixed::new(problem, scene.into(), rows)))
    }

    fn with(problem: &Problem, operator: Box<dyn LatticeOperator>) -> Self {
        let mut source = Vec::new();
        operator.walls().source_at(0.0, &mut source);
        let state = operator.lattice().by_site(&problem.initial);
        let next = vec![0.0; state.len()];
        Self { operator, source, state, next, exchange: CompensatedSum::default(), saved: None }
    }

    /// Brings the source to `time` (s).
    fn update_source(&mut self, time: f64) {
        if self.operator.walls().is_changing() {
            self.operator.walls().source_at(time, &mut self.source);
        }
    }

    /// Values of a task: whole lines, or a part of a line that is long.
    fn task(&self) -> usize {
        let nx = self.operator.lattice().counts[0];
        if nx < TASK { nx * (TASK / nx).max(1) } else { TASK }
    }

    /// Writes what `combine` makes of values and rates everywhere; returns what entered a second,
    /// value x volume / s.
    fn apply(&self, out: &mut [f64], combine: Combine) -> f64 {
        let task = self.task();
        let scratch = || Scratch::new(self.operator.lattice());
        let now = Now { state: &self.state, source: &self.source };
        let advance = |scratch: &mut Scratch, (k, out): (usize, &mut [f64])| {
            self.operator.advance(scratch, &now, k * task, out, combine)
        };
        let entered: Vec<f64> = if out.len() < SERIAL {
            let mut scratch = scratch();
            out.chunks_mut(task).enumerate().map(|part| advance(&mut scratch, part)).collect()
        } else {
            out.par_chunks_mut(task).enumerate().map_init(scratch, advance).collect()
        };
        let through_walls = match self.operator.walls().is_empty() {
            true => 0.0,
            false => self.operator.walls().inflow(&self.state, &self.source),
        };
        through_walls + entered.iter().sum::<f64>()
    }
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
        Ok(CpuField::new(self.operator.lattice().by_particle(&self.state)))
    }

    fn rate(&mut self, time: f64) -> Result<CpuField, SolverError> {
        self.update_source(time);
        let mut rates = vec![0.0; self.state.len()];
        self.apply(&mut rates, RATE);
        Ok(CpuField::new(self.operator.lattice().by_particle(&rates)))
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
        let order = self.operator.lattice().order.as_ref().map_or(0, |order| size_of_val(&**order));
        (states + order + self.operator.memory_bytes()) as u64
    }
}
