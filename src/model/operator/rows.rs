//! The scene as a matrix: surveyed, then assembled once.

use rayon::prelude::*;

use super::PairWeight;
use crate::model::Problem;
use crate::model::neighbors::{CellGrid, CellLayout, Neighbor, Scratch};

/// Cells that one task of a parallel walk handles.
const CELLS_PER_TASK: usize = 256;

/// What one walk over all pairs tells about a scene, without storing the pairs.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Neighbours of the particle at each rank.
    pub neighbors: Vec<u32>,
    /// Neighbours over all particles: twice the number of pairs.
    pub entries: u64,
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

/// The weights of some rows of the matrix in compressed form: row `rank` has the columns
/// `index[start[rank]..start[rank + 1]]`. Ranks are places in cell order.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Where each row begins, and one entry more for the end.
    start: Vec<usize>,
    /// Ranks of the neighbours, each below the number of rows.
    index: Vec<u32>,
    /// Weights w_ab, 1/s, never negative.
    weight: Vec<f64>,
}

/// Sorts the particles of `problem` into cells no smaller than the kernel's cutoff.
pub fn cell_grid(problem: &Problem) -> CellGrid<'_> {
    CellGrid::new(CellLayout::of(problem), &problem.particles.position)
}

/// Walks over all pairs once; see [`Survey`].
pub fn survey(problem: &Problem, grid: &CellGrid<'_>) -> Survey {
    let blocks: Vec<Survey> = tasks(grid)
        .into_par_iter()
        .map(|cells| survey_cells(problem, grid, cells))
        .collect();
    let mut whole = Survey {
        neighbors: Vec::with_capacity(grid.order().len()),
        ..Survey::empty()
    };
    for block in blocks {
        whole.neighbors.extend(&block.neighbors);
        whole.entries += block.entries;
        whole.max_diagonal = whole.max_diagonal.max(block.max_diagonal);
        whole.min_density = whole.min_density.min(block.min_density);
        whole.max_density = whole.max_density.max(block.max_density);
        whole.coincident = whole.coincident.or(block.coincident);
    }
    whole
}

impl Survey {
    fn empty() -> Self {
        Self {
            neighbors: Vec::new(),
            entries: 0,
            max_diagonal: 0.0,
            min_density: f64::INFINITY,
            max_density: f64::NEG_INFINITY,
            coincident: None,
        }
    }
}

fn survey_cells(problem: &Problem, grid: &CellGrid<'_>, cells: std::ops::Range<usize>) -> Survey {
    let weight = PairWeight::new(problem);
    let mut scratch = Scratch::default();
    let mut found = Survey::empty();
    for cell in cells {
        let cutoff = problem.kernel.cutoff();
        grid.for_each_row(
            cell,
            cutoff,
            &mut scratch,
            |_| true,
            |rank, neighbors| {
                let a = grid.order()[rank] as usize;
                found.neighbors.push(neighbors.len() as u32);
                found.entries += neighbors.len() as u64;
                let density = density_of(problem, grid, a, neighbors);
                found.min_density = found.min_density.min(density);
                found.max_density = found.max_density.max(density);
                if let Some(same) = neighbors.iter().find(|n| n.dist == 0.0) {
                    found.coincident = Some((a, grid.order()[same.rank as usize] as usize));
                }
                if !problem.is_held(a) {
                    let diagonal = neighbors
                        .iter()
                        .map(|n| weight.of(a, grid.order()[n.rank as usize] as usize, n.dist))
                        .sum();
                    found.max_diagonal = found.max_diagonal.max(diagonal);
                }
            },
        );
    }
    found
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
    let by_task: Vec<Vec<f64>> = tasks(&grid)
        .into_par_iter()
        .map(|cells| {
            let mut scratch = Scratch::default();
            let mut density = Vec::new();
            for cell in cells {
                grid.for_each_row(
                    cell,
                    cutoff,
                    &mut scratch,
                    |_| true,
                    |rank, neighbors| {
                        let a = grid.order()[rank] as usize;
                        density.push(density_of(problem, &grid, a, neighbors));
                    },
                );
            }
            density
        })
        .collect();
    let mut out = vec![0.0; problem.particles.len()];
    for (&particle, value) in grid.order().iter().zip(by_task.into_iter().flatten()) {
        out[particle as usize] = value;
    }
    out
}

/// Assembles the rows of the particles that pass `wanted` (called with a particle's index); the
/// other rows are empty. `neighbors` are the survey's.
pub fn assemble(
    problem: &Problem,
    grid: &CellGrid<'_>,
    neighbors: &[u32],
    wanted: impl Fn(usize) -> bool + Sync,
) -> Rows {
    let wanted_rank = |rank: usize| wanted(grid.order()[rank] as usize);
    let mut start = Vec::with_capacity(neighbors.len() + 1);
    let mut end = 0;
    start.push(0);
    for (rank, &count) in neighbors.iter().enumerate() {
        end += if wanted_rank(rank) { count as usize } else { 0 };
        start.push(end);
    }
    let mut rows = Rows {
        start,
        index: vec![0; end],
        weight: vec![0.0; end],
    };
    let mut blocks = Vec::new();
    let (mut index, mut weight) = (rows.index.as_mut_slice(), rows.weight.as_mut_slice());
    for cells in tasks(grid) {
        let last = grid.start()[cells.end] as usize;
        let first = grid.start()[cells.start] as usize;
        let length = rows.start[last] - rows.start[first];
        let (head_index, rest_index) = index.split_at_mut(length);
        let (head_weight, rest_weight) = weight.split_at_mut(length);
        (index, weight) = (rest_index, rest_weight);
        blocks.push((cells, head_index, head_weight));
    }
    blocks.into_par_iter().for_each(|(cells, index, weight)| {
        fill(problem, grid, cells, &wanted_rank, index, weight);
    });
    rows
}

/// Fills the entries of the rows of `cells`, which lie one behind the other.
fn fill(
    problem: &Problem,
    grid: &CellGrid<'_>,
    cells: std::ops::Range<usize>,
    wanted: &impl Fn(usize) -> bool,
    index: &mut [u32],
    weight: &mut [f64],
) {
    let pair_weight = PairWeight::new(problem);
    let mut scratch = Scratch::default();
    let mut at = 0;
    for cell in cells {
        let cutoff = problem.kernel.cutoff();
        grid.for_each_row(cell, cutoff, &mut scratch, wanted, |rank, neighbors| {
            let a = grid.order()[rank] as usize;
            for n in neighbors {
                let b = grid.order()[n.rank as usize] as usize;
                index[at] = n.rank;
                weight[at] = pair_weight.of(a, b, n.dist);
                at += 1;
            }
        });
    }
}

/// The cells in equal runs, one a parallel task. They do not depend on the number of threads, so
/// that neither do results.
fn tasks(grid: &CellGrid<'_>) -> Vec<std::ops::Range<usize>> {
    let cells = grid.layout().count();
    (0..cells)
        .step_by(CELLS_PER_TASK)
        .map(|first| first..(first + CELLS_PER_TASK).min(cells))
        .collect()
}

impl Rows {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Entries of the row `rank`.
    pub fn row_len(&self, rank: usize) -> usize {
        self.start[rank + 1] - self.start[rank]
    }

    /// Entries of all rows.
    pub fn entries(&self) -> usize {
        self.index.len()
    }

    /// sum_b w_ab (C_b - C_a) of each row from `first` on, into `rate`: 1/s x the unit of `state`,
    /// which is in cell order.
    ///
    /// # Panics
    /// If `state` has another length than there are rows.
    pub fn rates(
        &self,
        first: usize,
        state: &[f64],
        mut rate: impl FnMut(usize, f64),
        count: usize,
    ) {
        assert_eq!(state.len(), self.len(), "one value a row");
        for rank in first..first + count {
            rate(rank, self.row_rate(rank, state));
        }
    }

    /// The rate of one row; see [`Rows::rates`].
    pub fn rate(&self, rank: usize, state: &[f64]) -> f64 {
        assert_eq!(state.len(), self.len(), "one value a row");
        self.row_rate(rank, state)
    }

    /// Differences, not a product with a stored diagonal: a constant field has rate 0 exactly.
    /// Four sums run side by side, so that the chain of additions does not set the speed.
    #[inline]
    #[allow(
        unsafe_code,
        reason = "checking the bounds of every neighbour costs a fifth of the speed of the product"
    )]
    fn row_rate(&self, rank: usize, state: &[f64]) -> f64 {
        let range = self.start[rank]..self.start[rank + 1];
        let own = state[rank];
        // SAFETY: `assemble`, which alone makes rows, fills `index` with ranks below the number of
        // rows, and callers have compared that number with the length of `state`.
        let term = |b: u32, w: f64| w * (unsafe { state.get_unchecked(b as usize) } - own);
        let index = self.index[range.clone()].chunks_exact(4);
        let weight = self.weight[range].chunks_exact(4);
        let tail = index.remainder().iter().zip(weight.remainder());
        let tail: f64 = tail.map(|(&b, &w)| term(b, w)).sum();
        let mut sum = [0.0_f64; 4];
        for (b, w) in index.zip(weight) {
            for lane in 0..4 {
                sum[lane] += term(b[lane], w[lane]);
            }
        }
        (sum[0] + sum[1]) + (sum[2] + sum[3]) + tail
    }

    /// Bytes that the rows hold.
    pub fn memory_bytes(&self) -> u64 {
        (size_of_val(&*self.start) + size_of_val(&*self.index) + size_of_val(&*self.weight)) as u64
    }
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod tests;
