//! The CPU backend: f64, on every core.

mod aggregates;
mod change;
mod course;
mod crossings;
mod curves;
mod enthalpy;
mod entries;
mod fronts;
mod latent;
mod lattice;
mod mushy;
mod operator;
mod partial_step;
mod rows;
mod seam_step;
mod shared_lines;
mod vector;
mod written;

use std::sync::Arc;

use rayon::prelude::*;

use super::{Backend, Precision, SolverError};
use crate::model::Problem;
use crate::model::lattice::{LatticeScene, MixedScene};
use crate::model::operator::rows::{Rows, assemble, cell_grid};
use crate::model::operator::{SomeRows, SourceRows};
use crate::model::sum::CompensatedSum;

use aggregates::Aggregates;
use enthalpy::Enthalpy;
use lattice::{Lattice, Mixed, Uniform};
use operator::{Combine, CpuOperator, Now, RATE};
use rows::StoredRows;
pub use vector::CpuVector;
use vector::{Capacities, Count, largest};

/// Values that one parallel task looks at.
const CHUNK: usize = 1 << 15;

/// A field of the CPU backend, in the problem's order.
#[derive(Clone, Debug, PartialEq)]
pub struct CpuField(Vec<f64>);

impl AsRef<[f64]> for CpuField {
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

/// A copy of the state.
#[derive(Default)]
struct Saved {
    state: Vec<f64>,
    enthalpy: Vec<f64>,
    exchange: CompensatedSum,
}

/// The state and the operator of a scene in memory. Values are in the operator's order: places in cell
/// order, or sites of a lattice.
pub struct CpuBackend {
    operator: Box<dyn CpuOperator>,
    /// What the operator acts on: the state, or its potentials where `enthalpy` is the state.
    state: Vec<f64>,
    next: Vec<f64>,
    /// The state, only where it is not what the operator acts on.
    enthalpy: Option<Enthalpy>,
    /// Source of the rows of walls, 1/s x value.
    source: Vec<f64>,
    /// What held particles and walls have given to the others: value x capacity.
    exchange: CompensatedSum,
    saved: Option<Saved>,
    capacities: Arc<Capacities>,
    /// The aggregates of a coarse space, once a solver has one.
    aggregates: Aggregates,
    vectors: Count,
    /// A_aa, 1/s, once a solver has asked for it.
    diagonal: Vec<f64>,
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
        Self::with(problem, Box::new(StoredRows::new(problem, order, rows)))
    }

    /// The lattice `scene` of `problem`, whose walls add `walls` at its sites.
    pub fn lattice(
        problem: &Problem,
        scene: impl Into<Arc<LatticeScene>>,
        walls: SourceRows,
    ) -> Self {
        Self::with(problem, Box::new(Lattice::new(Uniform::new(problem, scene.into(), walls))))
    }

    /// The lattice `scene` of `problem`, with the rows that its stencil does not describe.
    pub fn mixed(problem: &Problem, scene: impl Into<Arc<MixedScene>>, rows: SomeRows) -> Self {
        Self::with(problem, Box::new(Lattice::new(Mixed::new(problem, scene.into(), rows))))
    }

    fn with(problem: &Problem, operator: Box<dyn CpuOperator>) -> Self {
        let mut source = Vec::new();
        operator.sources().source_at(0.0, &mut source);
        let state = operator.by_place(&problem.potentials(&problem.initial));
        let capacities =
            Arc::new(Capacities::of(&problem.capacities(), |each| operator.by_place(each)));
        let enthalpy =
            problem.has_curves().then(|| Enthalpy::new(problem, &*operator, &capacities));
        Self {
            // What is at no particle stays 0.
            next: vec![0.0; state.len()],
            capacities,
            operator,
            source,
            state,
            enthalpy,
            exchange: CompensatedSum::default(),
            saved: None,
            aggregates: Aggregates::default(),
            vectors: Count::default(),
            diagonal: Vec::new(),
        }
    }

    /// Brings the source to `time` (s).
    fn update_source(&mut self, time: f64) {
        if self.operator.sources().is_changing() {
            self.operator.sources().source_at(time, &mut self.source);
        }
    }

    /// The state, whatever the operator acts on.
    fn content(&self) -> &[f64] {
        self.enthalpy.as_ref().map_or(&self.state, Enthalpy::values)
    }

    /// Brings all enthalpies to where Euler's steps have left them.
    fn settle(&mut self) {
        if let Some(enthalpy) = &mut self.enthalpy {
            enthalpy.settle(&self.state, &*self.operator);
        }
    }

    fn field(&self, values: &[f64]) -> CpuField {
        CpuField(self.operator.by_particle(values))
    }
}

impl Backend for CpuBackend {
    type Field = CpuField;
    type Vector = CpuVector;

    fn euler(&mut self, time: f64, dt: f64, count: u64) -> Result<(), SolverError> {
        let mut next = std::mem::take(&mut self.next);
        if let Some(enthalpy) = &mut self.enthalpy {
            enthalpy.begin(&self.state, &*self.operator);
        }
        for step in 0..count {
            self.update_source(time + step as f64 * dt);
            let now = Now::state(&self.state, &self.source);
            let operator = &*self.operator;
            let given = match &mut self.enthalpy {
                None => operator::apply(operator, &now, &mut next, Combine::step(dt)),
                Some(enthalpy) => operator::step_enthalpy(operator, &now, &mut next, enthalpy, dt),
            };
            self.exchange.add(dt * given);
            std::mem::swap(&mut self.state, &mut next);
        }
        self.next = next;
        Ok(())
    }

    fn wait(&mut self) -> Result<(), SolverError> {
        Ok(())
    }

    fn read(&mut self) -> Result<CpuField, SolverError> {
        self.settle();
        Ok(self.field(self.content()))
    }

    fn rate(&mut self, time: f64) -> Result<CpuField, SolverError> {
        self.settle();
        self.update_source(time);
        let mut rates = vec![0.0; self.state.len()];
        let now = Now::state(&self.state, &self.source);
        operator::apply(&*self.operator, &now, &mut rates, RATE);
        if let Some(enthalpy) = &self.enthalpy {
            enthalpy.add_seams(&mut rates);
        }
        Ok(self.field(&rates))
    }

    fn exchange(&mut self) -> Result<f64, SolverError> {
        Ok(self.exchange.value())
    }

    fn is_finite(&mut self) -> Result<bool, SolverError> {
        let is_finite = |values: &[f64]| {
            values.par_chunks(CHUNK).all(|part| part.iter().all(|x| x.is_finite()))
        };
        // Where all potentials are, all enthalpies are.
        if is_finite(&self.state) {
            return Ok(true);
        }
        self.settle();
        Ok(is_finite(self.content()))
    }

    fn save(&mut self) -> Result<(), SolverError> {
        self.settle();
        let saved = self.saved.get_or_insert_default();
        saved.state.clone_from(&self.state);
        if let Some(enthalpy) = &self.enthalpy {
            saved.enthalpy.clear();
            saved.enthalpy.extend_from_slice(enthalpy.values());
        }
        saved.exchange = self.exchange;
        Ok(())
    }

    fn restore(&mut self) -> Result<(), SolverError> {
        if let Some(saved) = &self.saved {
            self.state.clone_from(&saved.state);
            if let Some(enthalpy) = &mut self.enthalpy {
                enthalpy.restore(&saved.enthalpy);
            }
            self.exchange = saved.exchange;
        }
        Ok(())
    }

    fn memory_bytes(&self) -> u64 {
        let of_saved = |saved: &Saved| size_of_val(&*saved.state) + size_of_val(&*saved.enthalpy);
        let saved = self.saved.as_ref().map_or(0, of_saved);
        let enthalpy = self.enthalpy.as_ref().map_or(0, Enthalpy::memory_bytes);
        let values = 2 * size_of_val(&*self.state) + saved + enthalpy + size_of_val(&*self.source);
        let vectors = self.vectors.most * size_of_val(&*self.state);
        let solver = vectors + size_of_val(&*self.diagonal);
        let rest = solver + self.capacities.memory_bytes() + self.aggregates.memory_bytes();
        self.operator.memory_bytes() + (values + rest) as u64
    }
    fn vector(&mut self) -> Result<CpuVector, SolverError> {
        Ok(self.vectors.vector(self.state.len()))
    }

    fn load(&mut self, values: &[f64], out: &mut CpuVector) -> Result<(), SolverError> {
        out.values = self.operator.by_place(values);
        out.given = 0.0;
        self.operator.held().iter().for_each(|&place| out.values[place as usize] = 0.0);
        Ok(())
    }

    fn rate_into(&mut self, time: f64, out: &mut CpuVector) -> Result<(), SolverError> {
        self.settle();
        self.update_source(time);
        let now = Now::state(&self.state, &self.source);
        out.given = operator::apply(&*self.operator, &now, &mut out.values, RATE);
        if let Some(enthalpy) = &self.enthalpy {
            out.given += enthalpy.add_seams(&mut out.values);
        }
        Ok(())
    }

    fn is_source_changing(&self) -> bool {
        self.operator.sources().is_changing()
    }

    fn source_change(
        &mut self,
        from: f64,
        to: f64,
        out: &mut CpuVector,
    ) -> Result<(), SolverError> {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        let walls = self.operator.sources();
        walls.source_at(from, &mut before);
        walls.source_at(to, &mut after);
        out.values.fill(0.0);
        out.given = 0.0;
        for (row, &place) in walls.rank().iter().enumerate() {
            let change = after[row] - before[row];
            out.values[place as usize] = change;
            out.given += walls.capacity()[row] * change;
        }
        Ok(())
    }

    fn apply(
        &mut self,
        x: &CpuVector,
        share: f64,
        scale: f64,
        out: &mut CpuVector,
    ) -> Result<(), SolverError> {
        let now = Now::change(&x.values);
        let combine = Combine::new(share, scale);
        let given = operator::apply(&*self.operator, &now, &mut out.values, combine);
        out.given = share * x.given + scale * given;
        Ok(())
    }

    fn update(
        &mut self,
        out: &mut CpuVector,
        keep: f64,
        terms: &[(f64, &CpuVector)],
    ) -> Result<(), SolverError> {
        out.update(keep, terms);
        Ok(())
    }

    fn update_given(
        &mut self,
        out: &mut CpuVector,
        keep: f64,
        terms: &[(f64, &CpuVector)],
    ) -> Result<(), SolverError> {
        out.update_given(keep, terms);
        Ok(())
    }

    fn divide(
        &mut self,
        x: &CpuVector,
        shift: f64,
        scale: f64,
        out: &mut CpuVector,
    ) -> Result<(), SolverError> {
        if self.diagonal.is_empty() {
            // Of a particle without neighbours, nothing that anything is divided by may be 0.
            let diagonal = self.operator.diagonal().into_iter();
            self.diagonal = diagonal.map(|d| if d == 0.0 { -1.0 } else { d }).collect();
        }
        out.divide(x, shift, scale, &self.diagonal);
        Ok(())
    }

    fn dot(&mut self, x: &CpuVector, y: &CpuVector) -> Result<f64, SolverError> {
        Ok(self.capacities.dot(x, y))
    }

    fn aggregate(&mut self, of: &[u32], count: usize) -> Result<(), SolverError> {
        let numbers: Vec<f64> = of.iter().map(|&aggregate| f64::from(aggregate)).collect();
        let by_place = self.operator.by_place(&numbers);
        // Where there is no particle, by_place has 0.
        let there = self.operator.by_place(&vec![1.0; of.len()]);
        let places = by_place.iter().zip(&there);
        let of = places.map(|(&a, &there)| if there > 0.0 { a as u32 } else { u32::MAX });
        self.aggregates = Aggregates::new(of.collect(), count);
        Ok(())
    }

    fn restrict(&mut self, x: &CpuVector, out: &mut [f64]) -> Result<(), SolverError> {
        self.aggregates.restrict(&x.values, &self.capacities, out);
        Ok(())
    }

    fn prolong(&mut self, values: &[f64], out: &mut CpuVector) -> Result<(), SolverError> {
        self.aggregates.prolong(values, &mut out.values);
        Ok(())
    }

    fn largest(&mut self, x: &CpuVector) -> Result<f64, SolverError> {
        Ok(largest(&x.values))
    }

    fn largest_value(&mut self) -> Result<f64, SolverError> {
        self.settle();
        Ok(largest(self.content()))
    }

    fn precision(&self) -> Precision {
        Precision::F64
    }

    fn is_linear(&self) -> bool {
        self.enthalpy.is_none()
    }

    fn rate_change(&mut self, x: &CpuVector, out: &mut CpuVector) -> Result<(), SolverError> {
        self.settle();
        let Some(enthalpy) = &self.enthalpy else {
            return self.apply(x, 0.0, 1.0, out);
        };
        enthalpy.potential_change(&x.values, &self.state, &mut self.next);
        let now = Now::change(&self.next);
        out.given = operator::apply(&*self.operator, &now, &mut out.values, RATE);
        out.given += enthalpy.add_change_of_seams(&x.values, &mut out.values);
        Ok(())
    }

    fn slope_root(&mut self, x: &CpuVector, out: &mut CpuVector) -> Result<(), SolverError> {
        self.settle();
        out.given = 0.0;
        match &self.enthalpy {
            None => out.values.fill(1.0),
            Some(enthalpy) => enthalpy.slope_root(&x.values, &mut out.values),
        }
        Ok(())
    }

    fn multiply(&mut self, out: &mut CpuVector, by: &CpuVector) -> Result<(), SolverError> {
        out.multiply(by);
        Ok(())
    }

    fn add(&mut self, x: &CpuVector) -> Result<(), SolverError> {
        self.settle();
        if let Some(enthalpy) = &mut self.enthalpy {
            self.state.copy_from_slice(&x.values);
            enthalpy.change(&mut self.state);
            self.operator.clear_absent(0, &mut self.state);
            self.exchange.add(x.given);
            return Ok(());
        }
        let parts = self.state.par_chunks_mut(CHUNK).zip(x.values.par_chunks(CHUNK));
        parts.for_each(|(state, x)| state.iter_mut().zip(x).for_each(|(c, x)| *c += x));
        self.exchange.add(x.given);
        Ok(())
    }
}
