//! The scene as a matrix: surveyed, then assembled once.

use std::ops::Range;

use rayon::prelude::*;

use super::fold::{Fault, Fold, RowFold};
use super::row_block::{Advance, RowBlock};
use super::source_rows::SourceRowsBuilder;
pub use super::survey::Survey;
use super::{PairWeight, SourceRows};
use crate::model::neighbors::{CellGrid, CellLayout, Neighbor, Scratch};
use crate::model::{Problem, lattice, wide};

/// Cells that one task of a parallel walk handles.
const CELLS_PER_TASK: usize = 256;
/// Below this many rows one thread is faster than handing out tasks for every product.
const SERIAL_ROWS: usize = 16_384;

/// The matrix of a scene. Rows and columns are ranks, places in cell order.
///
/// The rows of held particles are empty among the others, since nothing changes there, and kept
/// apart: what they would gain from particles that are not held is what the outside has to take
/// away. Walls are folded into the weights; what else they add is kept by [`SourceRows`].
#[derive(Clone, Debug)]
pub struct Rows {
    /// The rows of all ranks, block after block.
    blocks: Vec<RowBlock>,
    /// The first row of each block.
    first: Vec<usize>,
    /// The rows of held particles in the order of their ranks.
    held: RowBlock,
    /// Ranks of the held particles, ascending.
    held_rank: Vec<u32>,
    walls: SourceRows,
    count: usize,
}

/// Sorts the particles of `problem` into cells no smaller than the kernel's cutoff.
pub fn cell_grid(problem: &Problem) -> CellGrid<'_> {
    CellGrid::new(CellLayout::of(problem), &problem.particles.position)
}

/// Walks over all pairs once and stores none; see [`Survey`].
pub fn survey(problem: &Problem, grid: &CellGrid<'_>) -> Survey {
    let weight = PairWeight::new(problem);
    let walk = Walk::new(problem, grid.order(), &weight);
    let visit = |cells| walk.visit(grid, cells, Keep::Nothing).survey;
    let parts = tasks(grid).into_par_iter().map(visit);
    let parts: Vec<Survey> = parts.collect();
    let merged = parts.into_iter().fold(Survey::EMPTY, Survey::merge);
    merged.with_sources(problem)
}

/// Walks over all pairs once and stores the weights.
pub fn assemble(problem: &Problem, grid: &CellGrid<'_>) -> (Survey, Rows) {
    let weight = PairWeight::new(problem);
    let walk = Walk::new(problem, grid.order(), &weight);
    let parts: Vec<Part> =
        tasks(grid).into_par_iter().map(|cells| walk.visit(grid, cells, Keep::Rows)).collect();
    let mut survey = Survey::EMPTY;
    let mut rows = Rows {
        blocks: Vec::with_capacity(parts.len()),
        first: Vec::with_capacity(parts.len()),
        held: RowBlock::default(),
        held_rank: Vec::new(),
        walls: SourceRows::default(),
        count: grid.order().len(),
    };
    let mut walls = SourceRowsBuilder::default();
    let mut first = 0;
    for part in parts {
        survey = survey.merge(part.survey);
        rows.first.push(first);
        first += part.free.len();
        rows.blocks.push(part.free);
        rows.held.append(&part.held);
        rows.held_rank.extend(part.held_rank);
        walls.append(part.walls);
    }
    rows.walls = walls.finish(problem);
    (survey.with_sources(problem), rows)
}

/// What walls, and interfaces whose place is known, add to the matrix of a scene, kept apart from it: for a backend that computes the
/// weights between particles itself. Ranks are places in cell order.
#[derive(Clone, Debug, Default)]
pub struct WallFold {
    /// What the weights of pairs (row, neighbour) get, 1/s, row by row.
    pub weight: Vec<(u32, u32, f64)>,
    /// The rows with more than weights.
    pub rows: SourceRows,
    /// Whether they leave the matrix unsymmetric.
    pub is_skew: bool,
    /// What is wrong with a wall or surface, if anything is.
    pub fault: Option<Fault>,
}

/// Walks over the particles near walls and stores what these add.
pub fn wall_fold(problem: &Problem, grid: &CellGrid<'_>) -> WallFold {
    let weight = PairWeight::new(problem);
    let walk = Walk::new(problem, grid.order(), &weight);
    if walk.fold.is_none() && !weight.knows_interfaces() {
        return WallFold::default();
    }
    let parts: Vec<Part> =
        tasks(grid).into_par_iter().map(|cells| walk.visit(grid, cells, Keep::Walls)).collect();
    let (mut weight, mut fault, mut is_skew) = (Vec::new(), None, false);
    let mut walls = SourceRowsBuilder::default();
    for part in parts {
        fault = fault.or(part.survey.fault);
        is_skew |= !part.survey.symmetric;
        weight.extend(part.folded);
        walls.append(part.walls);
    }
    WallFold { weight, rows: walls.finish(problem), is_skew, fault }
}

/// What a walk stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keep {
    Nothing,
    /// The rows of the matrix.
    Rows,
    /// What walls add to them.
    Walls,
}

/// What the visit of some particles found.
#[derive(Default)]
pub(super) struct Part {
    pub(super) survey: Survey,
    pub(super) free: RowBlock,
    pub(super) held: RowBlock,
    pub(super) held_rank: Vec<u32>,
    folded: Vec<(u32, u32, f64)>,
    pub(super) walls: SourceRowsBuilder,
}

/// What every task of a walk needs.
pub(super) struct Walk<'a> {
    problem: &'a Problem,
    /// The particle at each rank.
    order: &'a [u32],
    weight: &'a PairWeight<'a>,
    fold: Option<Fold<'a>>,
    /// Neighbours in the interior of a lattice: what rows are expected to have.
    expected: usize,
}

/// One row of a walk.
pub(super) struct Row<'a> {
    pub(super) rank: usize,
    /// Index of the particle.
    pub(super) a: usize,
    pub(super) held: bool,
    pub(super) neighbors: &'a [Neighbor],
    /// What walls add, if any reaches.
    pub(super) fold: Option<&'a RowFold>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(problem: &'a Problem, order: &'a [u32], weight: &'a PairWeight<'a>) -> Self {
        let mut expected = 0;
        lattice::for_each_neighbor(&problem.kernel, problem.spacing, |_| expected += 1);
        Self { problem, order, weight, fold: Fold::new(problem, weight), expected }
    }

    fn visit(&self, grid: &CellGrid<'_>, cells: Range<usize>, keep: Keep) -> Part {
        let problem = self.problem;
        let particles = (grid.start()[cells.end] - grid.start()[cells.start]) as usize;
        let capacity = if keep == Keep::Rows { particles * self.expected } else { 0 };
        let free = RowBlock::with_capacity(particles, capacity);
        let mut part = Part { free, ..Part::default() };
        let mut scratch = Scratch::default();
        let mut row_fold = RowFold::default();
        for cell in cells {
            let is_known = self.weight.knows_interfaces();
            let reached = || self.walls_reach(&grid.order()[grid.ranks(cell)]);
            if keep == Keep::Walls && !is_known && !reached() {
                continue;
            }
            grid.for_each_row(cell, problem.kernel.cutoff(), &mut scratch, |rank, neighbors| {
                let row = self.row(rank, neighbors, &mut row_fold);
                match keep {
                    Keep::Walls => {
                        part.keep_walls(problem, &row);
                        self.keep_interfaces(&row, &mut part);
                    }
                    _ => self.note(&row, keep == Keep::Rows, &mut part),
                }
            });
        }
        part.free.shrink();
        part
    }

    /// The row at `rank`; what walls add to it is written to `fold`.
    pub(super) fn row<'b>(
        &self,
        rank: usize,
        neighbors: &'b [Neighbor],
        fold: &'b mut RowFold,
    ) -> Row<'b> {
        let a = self.order[rank] as usize;
        let of_row = |walls: &Fold<'_>| walls.of_row(a, neighbors, self.order, fold);
        let folded = self.fold.as_ref().is_some_and(of_row);
        Row { rank, a, held: self.problem.is_held(a), neighbors, fold: folded.then_some(fold) }
    }

    /// Stores what weights get beyond the pair mean, where it is known where materials meet.
    fn keep_interfaces(&self, row: &Row<'_>, part: &mut Part) {
        if !self.weight.knows_interfaces() {
            return;
        }
        for n in row.neighbors {
            let b = self.order[n.rank as usize] as usize;
            let [known, half_way] =
                [self.weight.between(row.a, b, n.dist), self.weight.of(row.a, b, n.dist)];
            if known != half_way {
                part.folded.push((row.rank as u32, n.rank, known - half_way));
            }
        }
    }

    /// Whether a wall reaches or a source acts on one of `particles`.
    fn walls_reach(&self, particles: &[u32]) -> bool {
        let reached = |fold: &Fold<'_>| particles.iter().any(|&p| fold.reaches(p as usize));
        self.fold.as_ref().is_some_and(reached)
    }

    /// Surveys a row, and stores it with `store`.
    pub(super) fn note(&self, row: &Row<'_>, store: bool, part: &mut Part) {
        let (problem, order) = (self.problem, self.order);
        part.survey.note_neighbors(order, row.a, row.neighbors);
        part.survey.note_density(density_of(problem, order, row.a, row.neighbors));
        let block = if row.held { &mut part.held } else { &mut part.free };
        let (mut weights, mut negative) = (0.0, 0.0);
        for (k, n) in row.neighbors.iter().enumerate() {
            let b = order[n.rank as usize] as usize;
            // Between two held particles nothing is exchanged.
            if row.held && problem.is_held(b) {
                continue;
            }
            let between = self.weight.between(row.a, b, n.dist);
            let weight = between + row.fold.map_or(0.0, |fold| fold.weight[k]);
            weights += weight;
            negative -= weight.min(0.0);
            if store {
                block.push(n.rank, weight);
            }
        }
        if row.held {
            part.held.end_row();
        } else {
            part.survey.note_diagonal(weights - row.fold.map_or(0.0, |f| f.diagonal), negative);
        }
        part.free.end_row();
        if let Some(fold) = row.fold {
            part.survey.note_fold(fold);
        }
        if store {
            if row.held {
                part.held_rank.push(row.rank as u32);
            }
            part.add_wall_row(problem, row);
        }
    }
}

impl Part {
    /// Stores what walls add to a row.
    fn keep_walls(&mut self, problem: &Problem, row: &Row<'_>) {
        let Some(fold) = row.fold else {
            return;
        };
        let weights = row.neighbors.iter().zip(&fold.weight).filter(|(_, weight)| **weight != 0.0);
        self.folded.extend(weights.map(|(n, weight)| (row.rank as u32, n.rank, *weight)));
        self.keep_source(problem, row);
    }

    /// Stores what walls add to a row beyond weights.
    pub(super) fn keep_source(&mut self, problem: &Problem, row: &Row<'_>) {
        if let Some(fold) = row.fold {
            self.survey.note_fold(fold);
        }
        self.add_wall_row(problem, row);
    }

    fn add_wall_row(&mut self, problem: &Problem, row: &Row<'_>) {
        if let Some(fold) = row.fold {
            self.walls.add(row.rank as u32, problem.capacity(row.a), row.held, fold);
        }
    }
}

/// Summation density (18) of particle `a`: sum_b m_b W(r_ab), itself included.
fn density_of(problem: &Problem, order: &[u32], a: usize, neighbors: &[Neighbor]) -> f64 {
    let of_others: f64 = neighbors
        .iter()
        .map(|n| problem.mass(order[n.rank as usize] as usize) * problem.kernel.w(n.dist))
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
                density.push(density_of(problem, grid.order(), a, neighbors));
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
pub(super) fn tasks(grid: &CellGrid<'_>) -> Vec<Range<usize>> {
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

    /// The rows with a part of walls beyond their weights.
    pub fn sources(&self) -> &SourceRows {
        &self.walls
    }

    /// `out[a] = combine(state[a], rate_a)` for every row, in parallel, with
    /// rate_a = sum_b w_ab (C_b - C_a), 1/s x the unit of `state`, and in the rows of
    /// [`Rows::sources`] their diagonal x C_a + `source`; 0 for held particles. Both fields are in
    /// cell order. An empty `source` stands for zeros: the matrix alone.
    ///
    /// # Panics
    /// If a field has another length than there are rows, or the source than there are wall rows.
    pub fn apply(
        &self,
        state: &[f64],
        source: &[f64],
        out: &mut [f64],
        combine: impl Fn(f64, f64) -> f64 + Sync,
    ) {
        assert!(state.len() == self.count && out.len() == self.count, "one value a row");
        assert!(source.is_empty() || source.len() == self.walls.len(), "one source a wall row");
        let advance = |(first, block, out): (usize, &RowBlock, &mut [f64])| {
            let walls = self.walls.cursor(first, source);
            wide::run(Advance { block, walls, first, state, out, combine: &combine });
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

    /// The neighbours of a row and their weights, 1/s; none of a held particle.
    pub fn entries(&self, rank: usize) -> (&[u32], &[f64]) {
        // Blocks without rows begin where the next one does.
        let block = self.first.partition_point(|&first| first <= rank) - 1;
        self.blocks[block].entries(rank - self.first[block])
    }

    /// A_aa of every row, 1/s; 0 for held particles.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal: Vec<f64> = self.blocks.iter().flat_map(RowBlock::diagonals).collect();
        for (&rank, by_walls) in self.walls.rank().iter().zip(self.walls.diagonal()) {
            diagonal[rank as usize] += by_walls;
        }
        diagonal
    }

    /// The rate that each held particle would have from those that are not held, in the order of
    /// [`Rows::held_rank`].
    ///
    /// # Panics
    /// If `state` has another length than there are rows.
    pub fn held_rates<'a>(&'a self, state: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        assert_eq!(state.len(), self.count, "one value a row");
        let rows = self.held_rank.iter().enumerate();
        rows.map(|(row, &rank)| self.held.rate::<false>(row, state[rank as usize], state))
    }

    /// Bytes that the rows hold.
    pub fn memory_bytes(&self) -> u64 {
        let blocks: usize = self.blocks.iter().map(RowBlock::memory_bytes).sum();
        let walls = self.walls.memory_bytes();
        (blocks
            + self.held.memory_bytes()
            + size_of_val(&*self.held_rank)
            + walls
            + size_of_val(&*self.first)) as u64
    }
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod tests;
