//! The scene as a matrix: surveyed, then assembled once.

use std::ops::Range;

use rayon::prelude::*;

use super::PairWeight;
use super::row_block::RowBlock;
use crate::model::neighbors::{CellGrid, CellLayout, Neighbor, Scratch};
use crate::model::{Problem, lattice};

/// Cells that one task of a parallel walk handles.
const CELLS_PER_TASK: usize = 256;
/// Below this many rows one thread is faster than handing out tasks for every product.
const SERIAL_ROWS: usize = 16_384;

/// What one walk over all pairs tells about a scene, without storing the pairs.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Neighbours over all particles: twice the number of pairs.
    pub entries: u64,
    /// The most neighbours that a particle has.
    pub most_neighbors: usize,
    /// max_a |A_aa| = max_a sum_b w_ab over particles that are not held, 1/s; 0 if none has a
    /// neighbour.
    pub max_diagonal: f64,
    /// Smallest summation density (18), kg/m^dim.
    pub min_density: f64,
    /// Largest summation density (18), kg/m^dim.
    pub max_density: f64,
    /// Two particles (a, b) at one place, if there are any.
    pub coincident: Option<(usize, usize)>,
}

/// The matrix of a scene. Rows and columns are ranks, places in cell order.
///
/// The rows of held particles are empty among the others, since nothing changes there, and kept
/// apart: what they would gain is what the outside has to take away.
#[derive(Clone, Debug)]
pub struct Rows {
    /// The rows of all ranks, block after block.
    blocks: Vec<RowBlock>,
    /// The rows of held particles in the order of their ranks.
    held: RowBlock,
    /// Ranks of the held particles, ascending.
    held_rank: Vec<u32>,
    count: usize,
}

/// Sorts the particles of `problem` into cells no smaller than the kernel's cutoff.
pub fn cell_grid(problem: &Problem) -> CellGrid<'_> {
    CellGrid::new(CellLayout::of(problem), &problem.particles.position)
}

/// Walks over all pairs once and stores none; see [`Survey`].
pub fn survey(problem: &Problem, grid: &CellGrid<'_>) -> Survey {
    let walk = Walk::new(problem, grid);
    let parts = tasks(grid).into_par_iter().map(|cells| walk.visit(cells, false).survey);
    let parts: Vec<Survey> = parts.collect();
    parts.into_iter().fold(Survey::EMPTY, Survey::merge)
}

/// Walks over all pairs once and stores the weights.
pub fn assemble(problem: &Problem, grid: &CellGrid<'_>) -> (Survey, Rows) {
    let walk = Walk::new(problem, grid);
    let parts: Vec<Part> =
        tasks(grid).into_par_iter().map(|cells| walk.visit(cells, true)).collect();
    let mut survey = Survey::EMPTY;
    let mut rows = Rows {
        blocks: Vec::with_capacity(parts.len()),
        held: RowBlock::default(),
        held_rank: Vec::new(),
        count: grid.order().len(),
    };
    for part in parts {
        survey = survey.merge(part.survey);
        rows.blocks.push(part.free);
        rows.held.append(&part.held);
        rows.held_rank.extend(part.held_rank);
    }
    (survey, rows)
}

/// What the visit of some cells found.
struct Part {
    survey: Survey,
    free: RowBlock,
    held: RowBlock,
    held_rank: Vec<u32>,
}

/// What every task of a walk needs.
struct Walk<'a> {
    problem: &'a Problem,
    grid: &'a CellGrid<'a>,
    weight: PairWeight<'a>,
    /// Neighbours in the interior of a lattice: what rows are expected to have.
    expected: usize,
}

impl<'a> Walk<'a> {
    fn new(problem: &'a Problem, grid: &'a CellGrid<'a>) -> Self {
        let mut expected = 0;
        lattice::for_each_neighbor(&problem.kernel, problem.spacing, |_| expected += 1);
        Self { problem, grid, weight: PairWeight::new(problem), expected }
    }

    fn visit(&self, cells: Range<usize>, store: bool) -> Part {
        let (problem, grid) = (self.problem, self.grid);
        let particles = (grid.start()[cells.end] - grid.start()[cells.start]) as usize;
        let capacity = if store { particles * self.expected } else { 0 };
        let mut part = Part {
            survey: Survey::EMPTY,
            free: RowBlock::with_capacity(particles, capacity),
            held: RowBlock::default(),
            held_rank: Vec::new(),
        };
        let mut scratch = Scratch::default();
        for cell in cells {
            grid.for_each_row(cell, problem.kernel.cutoff(), &mut scratch, |rank, neighbors| {
                let a = grid.order()[rank] as usize;
                part.survey.note_neighbors(grid, a, neighbors);
                part.survey.note_density(density_of(problem, grid, a, neighbors));
                let held = problem.is_held(a);
                if held && store {
                    part.held_rank.push(rank as u32);
                }
                let block = if held { &mut part.held } else { &mut part.free };
                let mut diagonal = 0.0;
                for n in neighbors {
                    let weight = self.weight.of(a, grid.order()[n.rank as usize] as usize, n.dist);
                    diagonal += weight;
                    if store {
                        block.push(n.rank, weight);
                    }
                }
                if held {
                    part.held.end_row();
                } else {
                    part.survey.max_diagonal = part.survey.max_diagonal.max(diagonal);
                }
                part.free.end_row();
            });
        }
        part.free.shrink();
        part
    }
}

impl Survey {
    const EMPTY: Self = Self {
        entries: 0,
        most_neighbors: 0,
        max_diagonal: 0.0,
        min_density: f64::INFINITY,
        max_density: f64::NEG_INFINITY,
        coincident: None,
    };

    fn merge(self, other: Self) -> Self {
        Self {
            entries: self.entries + other.entries,
            most_neighbors: self.most_neighbors.max(other.most_neighbors),
            max_diagonal: self.max_diagonal.max(other.max_diagonal),
            min_density: self.min_density.min(other.min_density),
            max_density: self.max_density.max(other.max_density),
            coincident: self.coincident.or(other.coincident),
        }
    }

    fn note_neighbors(&mut self, grid: &CellGrid<'_>, a: usize, neighbors: &[Neighbor]) {
        self.entries += neighbors.len() as u64;
        self.most_neighbors = self.most_neighbors.max(neighbors.len());
        if let Some(same) = neighbors.iter().find(|n| n.dist == 0.0) {
            self.coincident = Some((a, grid.order()[same.rank as usize] as usize));
        }
    }

    fn note_density(&mut self, density: f64) {
        self.min_density = self.min_density.min(density);
        self.max_density = self.max_density.max(density);
    }
}

/// Summation density (18) of particle `a`: sum_b m_b W(r_ab), itself included.
fn density_of(problem: &Problem, grid: &CellGrid<'_>, a: usize, neighbors: &[Neighbor]) -> f64 {
    let of_others: f64 = neighbors
        .iter()
        .map(|n| problem.mass(grid.order()[n.rank as usize] as usize) * problem.kernel.w(n.dist))
        .sum();
    of_others + problem.mass(a) * problem.kernel.w(0.0)
}

/// The summation density (18) of every particle, in the problem's order, kg/m^dim.
pub fn density(problem: &Problem) -> Vec<f64> {
    let grid = cell_grid(problem);
    let cutoff = problem.kernel.cutoff();
    let of_cells = |cells: Range<usize>| {
        let mut scratch = Scratch::default();
        let mut density = Vec::new();
        for cell in cells {
            grid.for_each_row(cell, cutoff, &mut scratch, |rank, neighbors| {
                let a = grid.order()[rank] as usize;
                density.push(density_of(problem, &grid, a, neighbors));
            });
        }
        density
    };
    let by_task: Vec<Vec<f64>> = tasks(&grid).into_par_iter().map(of_cells).collect();
    let mut out = vec![0.0; problem.particles.len()];
    for (&particle, value) in grid.order().iter().zip(by_task.into_iter().flatten()) {
        out[particle as usize] = value;
    }
    out
}

/// The cells in equal runs, one a parallel task. They do not depend on the number of threads, so
/// that neither do results.
fn tasks(grid: &CellGrid<'_>) -> Vec<Range<usize>> {
    let cells = grid.layout().count();
    (0..cells)
        .step_by(CELLS_PER_TASK)
        .map(|first| first..(first + CELLS_PER_TASK).min(cells))
        .collect()
}

impl Rows {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Ranks of the held particles, ascending.
    pub fn held_rank(&self) -> &[u32] {
        &self.held_rank
    }

    /// `out[a] = combine(state[a], rate_a)` for every row, in parallel, with
    /// rate_a = sum_b w_ab (C_b - C_a), 1/s x the unit of `state`; 0 for held particles. Both
    /// slices are in cell order.
    ///
    /// # Panics
    /// If a slice has another length than there are rows.
    pub fn apply(&self, state: &[f64], out: &mut [f64], combine: impl Fn(f64, f64) -> f64 + Sync) {
        assert!(state.len() == self.count && out.len() == self.count, "one value a row");
        let advance = |(first, block, out): (usize, &RowBlock, &mut [f64])| {
            for (row, out) in out.iter_mut().enumerate() {
                let own = state[first + row];
                *out = combine(own, block.rate(row, own, state));
            }
        };
        let mut tasks = Vec::with_capacity(self.blocks.len());
        let (mut first, mut rest) = (0, out);
        for block in &self.blocks {
            let (head, tail) = rest.split_at_mut(block.len());
            tasks.push((first, block, head));
            first += block.len();
            rest = tail;
        }
        if self.count < SERIAL_ROWS {
            tasks.into_iter().for_each(advance);
        } else {
            tasks.into_par_iter().for_each(advance);
        }
    }

    /// The rate that each held particle would have, in the order of [`Rows::held_rank`].
    ///
    /// # Panics
    /// If `state` has another length than there are rows.
    pub fn held_rates<'a>(&'a self, state: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        assert_eq!(state.len(), self.count, "one value a row");
        let rows = self.held_rank.iter().enumerate();
        rows.map(|(row, &rank)| self.held.rate(row, state[rank as usize], state))
    }

    /// Bytes that the rows hold.
    pub fn memory_bytes(&self) -> u64 {
        let blocks: usize = self.blocks.iter().map(RowBlock::memory_bytes).sum();
        (blocks + self.held.memory_bytes() + size_of_val(&*self.held_rank)) as u64
    }
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod tests;
