//! The rows of some particles alone, for scenes where a stencil is the row of all others.

use std::ops::Range;

use rayon::prelude::*;

use super::fold::RowFold;
use super::row_block::RowBlock;
use super::rows::{Part, Survey, Walk};
use super::source_rows::SourceRowsBuilder;
use super::{PairWeight, SourceRows};
use crate::model::neighbors::Neighbor;
use crate::model::wide::Work;
use crate::model::{Problem, wide};

/// Rows that one task assembles, and one block holds.
const ROWS_PER_TASK: usize = 2048;

/// A rank without a row of walls.
const NONE: u32 = u32::MAX;

/// A particle whose surroundings are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// Its rank.
    pub rank: u32,
    /// Whether its row is stored, and not only what walls add beyond weights and diagonal.
    pub whole: bool,
}

/// Rows of some ranks, and what walls add to these and others.
///
/// Held particles have empty rows, and others kept apart, as in [`super::rows::Rows`].
#[derive(Clone, Debug, Default)]
pub struct SomeRows {
    /// Ranks of the rows, ascending.
    rank: Vec<u32>,
    /// The rows, block after block.
    blocks: Vec<RowBlock>,
    /// The first row of each block.
    first: Vec<usize>,
    held: RowBlock,
    held_rank: Vec<u32>,
    /// Capacity of each held particle.
    held_capacity: Vec<f64>,
    walls: SourceRows,
    /// Which row of walls belongs to each row.
    wall_row: Vec<u32>,
    /// How many ranks there are.
    count: usize,
}

impl SomeRows {
    /// Assembles the rows of `visits`, whose ranks ascend, and surveys those that are stored; of the
    /// others the survey has only what walls tell. `order` is the particle at each rank;
    /// `neighbors(rank, out)` writes all particles within a particle's support.
    pub fn assemble(
        problem: &Problem,
        order: &[u32],
        visits: &[Visit],
        neighbors: impl Fn(u32, &mut Vec<Neighbor>) + Sync,
    ) -> (Survey, Self) {
        let weight = PairWeight::new(problem);
        let walk = Walk::new(problem, order, &weight);
        let visit = |visits: &[Visit]| {
            let (mut part, mut found, mut fold) = (Part::default(), Vec::new(), RowFold::default());
            for visit in visits {
                found.clear();
                neighbors(visit.rank, &mut found);
                let row = walk.row(visit.rank as usize, &found, &mut fold);
                if visit.whole {
                    walk.note(&row, true, &mut part);
                } else {
                    part.keep_source(problem, &row);
                }
            }
            part.free.shrink();
            part
        };
        let parts: Vec<Part> = visits.par_chunks(ROWS_PER_TASK).map(visit).collect();
        let whole = visits.iter().filter(|visit| visit.whole).map(|visit| visit.rank);
        let mut rows = Self { rank: whole.collect(), count: order.len(), ..Self::default() };
        let (mut survey, mut walls) = (Survey::EMPTY, SourceRowsBuilder::default());
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
        let capacity = |&rank: &u32| problem.capacity(order[rank as usize] as usize);
        rows.held_capacity = rows.held_rank.iter().map(capacity).collect();
        let walls = rows.walls.rank();
        let wall_row = |rank: &u32| walls.binary_search(rank).map_or(NONE, |row| row as u32);
        rows.wall_row = rows.rank.iter().map(wall_row).collect();
        (survey, rows)
    }

    /// Ranks of the stored rows, ascending.
    pub fn rank(&self) -> &[u32] {
        &self.rank
    }

    /// The neighbours of every stored row with their weights (1/s), in the order of [`Self::rank`]; those of a
    /// held particle are the free ones alone.
    pub fn entries(&self) -> impl Iterator<Item = (&[u32], &[f64])> {
        let free = self.blocks.iter().flat_map(RowBlock::rows);
        free.zip(&self.rank).map(|(free, rank)| match self.held_rank.binary_search(rank) {
            Ok(row) => self.held.entries(row),
            Err(_) => free,
        })
    }

    /// Into how many blocks the rows are divided.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Rank, neighbours and their weights (1/s) of those rows of a block that are of free particles, and to
    /// which neither walls nor sources add anything.
    pub fn plain_rows(&self, block: usize) -> impl Iterator<Item = (u32, &[u32], &[f64])> {
        let (first, rows) = (self.first[block], self.blocks[block].rows());
        let ranks = self.rank[first..].iter().zip(&self.wall_row[first..]);
        let plain =
            rows.zip(ranks).filter(|((free, _), (_, wall))| !free.is_empty() && **wall == NONE);
        plain.map(|((others, weights), (&rank, _))| (rank, others, weights))
    }

    /// Takes the rows of some ranks out, which ascend and have rows.
    pub fn remove(&mut self, ranks: &[u32]) {
        if ranks.is_empty() {
            return;
        }
        let mut gone = ranks.iter().peekable();
        let keep: Vec<bool> =
            self.rank.iter().map(|rank| gone.next_if_eq(&rank).is_none()).collect();
        let (blocks, first) = (std::mem::take(&mut self.blocks), std::mem::take(&mut self.first));
        let mut count = 0;
        for (mut block, first) in blocks.into_iter().zip(first) {
            block.retain(&keep[first..first + block.len()]);
            if block.len() > 0 {
                self.first.push(count);
                count += block.len();
                self.blocks.push(block);
            }
        }
        let mut kept = keep.iter();
        self.rank.retain(|_| *kept.next().expect("one for each row"));
        let mut kept = keep.iter();
        self.wall_row.retain(|_| *kept.next().expect("one for each row"));
        self.rank.shrink_to_fit();
        self.wall_row.shrink_to_fit();
    }

    /// The neighbours of a stored row and their weights, 1/s, none of a held particle; `None` of a rank that has
    /// no row. It is looked for from row `near` on, which becomes the first that is not below the rank.
    pub fn entries_of(&self, rank: usize, near: &mut usize) -> Option<(&[u32], &[f64])> {
        *near = seek(&self.rank, *near, |&of_row| (of_row as usize) < rank);
        let row = *near;
        self.rank.get(row).filter(|of_row| **of_row as usize == rank)?;
        let block = self.first.partition_point(|&first| first <= row) - 1;
        Some(self.blocks[block].entries(row - self.first[block]))
    }

    /// Ranks of the held particles, ascending.
    pub fn held_rank(&self) -> &[u32] {
        &self.held_rank
    }

    /// What walls add to these rows and to others.
    pub fn sources(&self) -> &SourceRows {
        &self.walls
    }

    /// Calls `write(rank, rate)` for every stored row whose rank is in `ranks`, with the rate of
    /// [`super::rows::Rows::apply`]. An empty `source` stands for zeros. Rows are looked for from `near` on, which
    /// becomes the first of them.
    ///
    /// # Panics
    /// If `state` has another length than there are ranks.
    pub fn rates(
        &self,
        ranks: &Range<usize>,
        near: &mut usize,
        state: &[f64],
        source: &[f64],
        write: impl FnMut(usize, f64),
    ) {
        assert_eq!(state.len(), self.count, "one value a rank");
        let rows = within_near(&self.rank, ranks, near);
        if !rows.is_empty() {
            wide::run(Rates { of: self, rows, state, source, write });
        }
    }

    /// Calls `write(rank, A_aa)` for every stored row, 1/s; -1 for held particles.
    pub fn diagonals(&self, mut write: impl FnMut(usize, f64)) {
        let by_pairs = self.blocks.iter().flat_map(RowBlock::diagonals);
        for ((&rank, by_pairs), &wall) in self.rank.iter().zip(by_pairs).zip(&self.wall_row) {
            let by_walls = if wall == NONE { 0.0 } else { self.walls.diagonal()[wall as usize] };
            write(rank as usize, by_pairs + by_walls);
        }
        self.held_rank.iter().for_each(|&rank| write(rank as usize, -1.0));
    }

    fn by_walls(&self, wall: usize, own: f64, source: &[f64]) -> f64 {
        self.walls.diagonal()[wall] * own + source.get(wall).copied().unwrap_or(0.0)
    }

    /// What the held particles with ranks in `ranks` would gain a second from those that are not, capacity x
    /// value. They are looked for from `near` on, which becomes the first of them.
    ///
    /// # Panics
    /// If `state` has another length than there are ranks.
    pub fn held_rate(&self, ranks: &Range<usize>, near: &mut usize, state: &[f64]) -> f64 {
        assert_eq!(state.len(), self.count, "one value a rank");
        let held = within_near(&self.held_rank, ranks, near);
        held.map(|row| {
            let own = state[self.held_rank[row] as usize];
            self.held_capacity[row] * self.held.rate::<false>(row, own, state)
        })
        .sum()
    }

    /// Bytes that the rows hold.
    pub fn memory_bytes(&self) -> usize {
        let blocks: usize = self.blocks.iter().map(RowBlock::memory_bytes).sum();
        let ranks =
            [&self.rank, &self.held_rank, &self.wall_row].map(|ranks| size_of_val(&**ranks));
        let first = size_of_val(&*self.first) + size_of_val(&*self.held_capacity);
        let ranks: usize = ranks.iter().sum();
        blocks + self.held.memory_bytes() + ranks + first + self.walls.memory_bytes()
    }
}

/// See [`SomeRows::rates`].
struct Rates<'a, W> {
    of: &'a SomeRows,
    rows: Range<usize>,
    state: &'a [f64],
    source: &'a [f64],
    write: W,
}

impl<W: FnMut(usize, f64)> Work for Rates<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { of: all, mut rows, state, source, mut write } = self;
        let mut block = all.first.partition_point(|&first| first <= rows.start);
        while !rows.is_empty() {
            let first = all.first[block - 1];
            let end = all.first.get(block).map_or(rows.end, |&next| next.min(rows.end));
            for row in rows.start..end {
                let rank = all.rank[row] as usize;
                let own = state[rank];
                let rate = all.blocks[block - 1].rate::<FUSED>(row - first, own, state);
                let by_walls = match all.wall_row[row] {
                    NONE => 0.0,
                    wall => all.by_walls(wall as usize, own, source),
                };
                write(rank, rate + by_walls);
            }
            rows.start = end;
            block += 1;
        }
    }
}

/// Which of `ranks`, which ascend, are in `range`.
pub fn within(ranks: &[u32], range: &Range<usize>) -> Range<usize> {
    within_near(ranks, range, &mut 0)
}

/// The same, looked for from `near` on, which becomes their start: fast where the range before was near.
pub fn within_near(ranks: &[u32], range: &Range<usize>, near: &mut usize) -> Range<usize> {
    *near = seek(ranks, *near, |&rank| (rank as usize) < range.start);
    take_below(ranks, &mut (*near..ranks.len()), range.end)
}

/// Takes those that are below an end from the `rest` of ascending ranks.
pub fn take_below(ranks: &[u32], rest: &mut Range<usize>, end: usize) -> Range<usize> {
    let start = rest.start;
    rest.start += leading(&ranks[rest.clone()], |&rank| (rank as usize) < end);
    start..rest.start
}

/// How many of `all`, the first of which are below something and the others are not, are below it: looked for
/// from `near` on.
pub fn seek<T>(all: &[T], near: usize, is_below: impl Fn(&T) -> bool) -> usize {
    let (before, behind) = all.split_at(near.min(all.len()));
    match before.last() {
        Some(last) if !is_below(last) => before.partition_point(is_below),
        _ => before.len() + leading(behind, is_below),
    }
}

/// The same from the first on: few as a rule.
fn leading<T>(all: &[T], is_below: impl Fn(&T) -> bool) -> usize {
    let mut most = 1;
    while all.get(most - 1).is_some_and(&is_below) {
        most *= 2;
    }
    // Those before the half were below.
    let half = most / 2;
    half + all[half..most.min(all.len())].partition_point(is_below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_below_an_end_are_counted() {
        let ranks: Vec<u32> = (0..40).map(|k| 3 * k + 1).collect();
        for count in [0, 1, 2, 3, 4, 5, 8, 9, 39, 40] {
            for end in 0..125 {
                let is_below = |rank: &u32| (*rank as usize) < end;
                let below = ranks[..count].iter().filter(|rank| is_below(rank)).count();
                for near in [0, 1, 7, 39, 40, 50] {
                    let found = seek(&ranks[..count], near, is_below);
                    assert_eq!(found, below, "{count} up to {end} from {near} on");
                }
            }
        }
        assert_eq!(within(&ranks, &(5..14)), 2..5);
        assert_eq!(within(&ranks, &(500..600)), 40..40);
        let mut near = 30;
        assert_eq!(within_near(&ranks, &(5..14), &mut near), 2..5);
        assert_eq!(near, 2);
    }
}
