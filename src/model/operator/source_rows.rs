//! The rows to which walls and sources add more than weights: a diagonal and a source.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::fold::{RowFold, Term};
use crate::model::{Condition, Problem, ScalarField, Source, WallKind};

/// Rows that one parallel task works on.
const CHUNK: usize = 1 << 13;

/// What walls, surfaces and sources ask of a run, each kind more than the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FoldNeeds {
    /// There are none but free ones.
    None,
    /// Weights alone.
    Insulated,
    /// A diagonal and a source as well.
    Steady,
    /// A source that changes in time.
    Changing,
}

impl FoldNeeds {
    /// What the walls, surfaces and sources of `problem` ask for.
    pub fn of(problem: &Problem) -> Self {
        let of_source = |source: &Source| match source.rate.depends_on_time() {
            true => Self::Changing,
            false => Self::Steady,
        };
        problem.sources.iter().map(of_source).fold(Self::of_walls(problem), Self::max)
    }

    /// What the walls and surfaces ask for.
    pub fn of_walls(problem: &Problem) -> Self {
        let walls = problem.walls.iter().map(|wall| &wall.condition);
        let surfaces = problem.surfaces.iter().map(|surface| &surface.condition);
        let of_condition = |condition: &Condition| match condition.kind {
            WallKind::Free => Self::None,
            WallKind::Insulated => Self::Insulated,
            _ if condition.imposed.depends_on_time() => Self::Changing,
            _ => Self::Steady,
        };
        walls.chain(surfaces).map(of_condition).max().unwrap_or(Self::None)
    }
}

/// Diagonals and sources of rows, and what enters there through walls and from sources.
///
/// Row k of these belongs to rank `rank[k]` of the matrix. Its rate gets
/// `diagonal[k] C + source`, and what enters the body is the sum over k of
/// `capacity[k] (flow[k] C + source)`; both are 0 for held particles but for the flow.
#[derive(Clone, Debug, Default)]
pub struct SourceRows {
    rank: Vec<u32>,
    diagonal: Vec<f64>,
    /// The part of the diagonal that is of sources; empty where none is in proportion to the value.
    linear: Vec<f64>,
    flow: Vec<f64>,
    capacity: Vec<f64>,
    source: RowSources,
}

/// The source of each row, 1/s x the value's unit: a fixed part, and one that changes in time.
#[derive(Clone, Debug, Default)]
struct RowSources {
    fixed: Vec<f64>,
    /// Where something that changes is imposed.
    points: Vec<Point>,
    /// Row, point and coefficient (1/s).
    terms: Vec<(u32, u32, f64)>,
}

#[derive(Clone, Debug)]
struct Point {
    imposed: ScalarField,
    at: DVec3,
}

/// Collects the rows of a walk.
#[derive(Debug, Default)]
pub(super) struct SourceRowsBuilder {
    rows: SourceRows,
    terms: Vec<(u32, Term)>,
}

impl SourceRowsBuilder {
    /// Takes the row at `rank`, of a particle of this capacity, if anything but insulation acts.
    pub(super) fn add(&mut self, rank: u32, capacity: f64, held: bool, fold: &RowFold) {
        if !fold.acts || (held && fold.skew == 0.0) {
            return;
        }
        let row = self.rows.rank.len() as u32;
        // The value of a held particle does not change: nothing is added to it.
        let live = if held { 0.0 } else { 1.0 };
        self.rows.rank.push(rank);
        self.rows.capacity.push(capacity);
        let diagonal = live * (fold.diagonal + fold.linear);
        self.rows.diagonal.push(diagonal);
        self.rows.flow.push(diagonal + fold.skew);
        self.rows.linear.push(live * fold.linear);
        self.rows.source.fixed.push(live * fold.source);
        if !held {
            self.terms.extend(fold.changing.iter().map(|&term| (row, term)));
        }
    }

    /// Appends the rows of a later part of the walk.
    pub(super) fn append(&mut self, other: Self) {
        let base = self.rows.rank.len() as u32;
        self.rows.rank.extend(other.rows.rank);
        self.rows.capacity.extend(other.rows.capacity);
        self.rows.diagonal.extend(other.rows.diagonal);
        self.rows.linear.extend(other.rows.linear);
        self.rows.flow.extend(other.rows.flow);
        self.rows.source.fixed.extend(other.rows.source.fixed);
        self.terms.extend(other.terms.into_iter().map(|(row, term)| (base + row, term)));
    }

    /// The finished rows. What is imposed at one place is evaluated once, however many rows it
    /// acts on.
    pub(super) fn finish(mut self, problem: &Problem) -> SourceRows {
        if self.rows.linear.iter().all(|&linear| linear == 0.0) {
            self.rows.linear = Vec::new();
        }
        let imposed = problem.imposed();
        let mut known: HashMap<(usize, [u64; 3]), u32> = HashMap::new();
        let RowSources { points, terms, .. } = &mut self.rows.source;
        for (row, term) in self.terms {
            let key = (term.imposed, term.foot.to_array().map(f64::to_bits));
            let point = *known.entry(key).or_insert_with(|| {
                points.push(Point { imposed: imposed[term.imposed].clone(), at: term.foot });
                points.len() as u32 - 1
            });
            match terms.last_mut() {
                Some(last) if last.0 == row && last.1 == point => last.2 += term.coefficient,
                _ => terms.push((row, point, term.coefficient)),
            }
        }
        self.rows
    }
}

impl SourceRows {
    /// The same rows with other ranks, `to` of the present ones, in ascending order again.
    pub fn renumbered(&self, to: impl Fn(u32) -> u32) -> Self {
        let mut from: Vec<u32> = (0..self.len() as u32).collect();
        from.sort_by_key(|&row| to(self.rank[row as usize]));
        let mut place = vec![0; from.len()];
        for (new, &old) in (0..).zip(&from) {
            place[old as usize] = new;
        }
        let taken = |values: &[f64]| match values {
            [] => Vec::new(),
            _ => from.iter().map(|&row| values[row as usize]).collect(),
        };
        let RowSources { fixed, points, terms } = &self.source;
        let moved = |&(row, point, coefficient): &(u32, u32, f64)| {
            (place[row as usize], point, coefficient)
        };
        Self {
            rank: from.iter().map(|&row| to(self.rank[row as usize])).collect(),
            diagonal: taken(&self.diagonal),
            linear: taken(&self.linear),
            flow: taken(&self.flow),
            capacity: taken(&self.capacity),
            source: RowSources {
                fixed: taken(fixed),
                points: points.clone(),
                terms: terms.iter().map(moved).collect(),
            },
        }
    }

    /// The same rows for a stencil that has the diagonals of walls already, but at the ranks `stored`
    /// (ascending), whose rows are not the stencil's.
    pub fn beside_stencil(mut self, stored: &[u32]) -> Self {
        for (row, (rank, diagonal)) in self.rank.iter().zip(&mut self.diagonal).enumerate() {
            if stored.binary_search(rank).is_err() {
                *diagonal = self.linear.get(row).copied().unwrap_or(0.0);
            }
        }
        self
    }

    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.rank.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.rank.is_empty()
    }

    /// Their ranks in the matrix, ascending.
    pub fn rank(&self) -> &[u32] {
        &self.rank
    }

    /// Factor of each row's own value in its rate, 1/s.
    pub fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    /// The part of [`SourceRows::diagonal`] that is of sources; empty where that is 0.
    pub fn linear(&self) -> &[f64] {
        &self.linear
    }

    /// Factor of each row's own value in what enters, 1/s.
    pub fn flow(&self) -> &[f64] {
        &self.flow
    }

    /// Capacity rho c V of each row's particle.
    pub fn capacity(&self) -> &[f64] {
        &self.capacity
    }

    /// Whether a source changes in time.
    pub fn is_changing(&self) -> bool {
        !self.source.terms.is_empty()
    }

    /// Writes the source of every row at time `t` (s) into `source`.
    pub fn source_at(&self, t: f64, source: &mut Vec<f64>) {
        source.clone_from(&self.source.fixed);
        let at_point = |point: &Point| point.imposed.at(point.at, t);
        let values: Vec<f64> =
            self.source.points.par_iter().with_min_len(CHUNK).map(at_point).collect();
        for &(row, point, coefficient) in &self.source.terms {
            source[row as usize] += coefficient * values[point as usize];
        }
    }

    /// What enters the body through walls and from sources, value x capacity a second, with values `state`
    /// by rank; no source is none at all.
    pub fn inflow(&self, state: &[f64], source: Option<&[f64]>) -> f64 {
        let of_chunk = |rows: Range<usize>| -> f64 {
            let of_row = |row: usize| {
                let source = source.map_or(0.0, |source| source[row]);
                self.capacity[row] * (self.flow[row] * state[self.rank[row] as usize] + source)
            };
            rows.map(of_row).sum()
        };
        let count = self.len();
        if count <= CHUNK {
            return of_chunk(0..count);
        }
        let starts: Vec<usize> = (0..count).step_by(CHUNK).collect();
        let of_start = |&start: &usize| of_chunk(start..(start + CHUNK).min(count));
        let sums: Vec<f64> = starts.par_iter().map(of_start).collect();
        sums.iter().sum()
    }

    /// The rows from `rank` on, one after another.
    pub(super) fn cursor<'a>(&'a self, rank: usize, source: &'a [f64]) -> SourceCursor<'a> {
        let next = self.rank.partition_point(|&r| (r as usize) < rank);
        SourceCursor { rows: self, source, next }
    }

    /// Bytes that the rows hold.
    pub fn memory_bytes(&self) -> usize {
        let by_row = size_of::<u32>() + 4 * size_of::<f64>();
        let linear = size_of_val(&*self.linear);
        let RowSources { points, terms, .. } = &self.source;
        self.rank.len() * by_row + linear + size_of_val(&**points) + size_of_val(&**terms)
    }
}

/// Goes through the rows in the order of their ranks.
pub(super) struct SourceCursor<'a> {
    rows: &'a SourceRows,
    /// Source of each row; none means 0.
    source: &'a [f64],
    next: usize,
}

impl SourceCursor<'_> {
    /// The rank of the next row; of none, one that no row has.
    #[inline(always)]
    pub(super) fn next_rank(&self) -> usize {
        self.rows.rank.get(self.next).map_or(usize::MAX, |&rank| rank as usize)
    }

    /// What the next row's rate gets, where its own value is `own`.
    pub(super) fn take(&mut self, own: f64) -> f64 {
        let source = self.source.get(self.next).copied().unwrap_or(0.0);
        let rate = self.rows.diagonal[self.next] * own + source;
        self.next += 1;
        rate
    }
}
