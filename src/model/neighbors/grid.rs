//! Particles sorted into cells, and the walk over their neighbours.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::CellLayout;
use crate::model::Domain;

/// Particles in cell order: a permutation of the scene's particles, and where each cell starts.
///
/// The sort is stable, so the order inside a cell is that of the scene's indices.
pub struct CellGrid<'a> {
    layout: CellLayout,
    position: &'a [DVec3],
    /// Entry c is the first rank of cell c; one entry more closes the last cell.
    start: Vec<u32>,
    /// Particle index at each rank.
    order: Vec<u32>,
}

/// A neighbour of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbor {
    /// Its rank, i.e. its place in cell order.
    pub rank: u32,
    /// Its distance, m.
    pub dist: f64,
}

/// Buffers that a walk over cells uses again and again.
///
/// The candidates of a cell, coordinate by coordinate: what the search does with them is then
/// arithmetic on whole arrays, without a branch that depends on the data.
#[derive(Default)]
pub struct Scratch {
    rank: Vec<u32>,
    coordinate: [Vec<f64>; 3],
    squared: Vec<f64>,
    near: Vec<u32>,
    neighbors: Vec<Neighbor>,
    /// Where the cell's own particles begin among the candidates.
    own: usize,
}

impl<'a> CellGrid<'a> {
    /// Sorts `position` into the cells of `layout`.
    pub fn new(layout: CellLayout, position: &'a [DVec3]) -> Self {
        let cell: Vec<u32> =
            position.par_iter().map(|&x| layout.index(layout.coordinates(x)) as u32).collect();
        let mut start = vec![0_u32; layout.count() + 1];
        for &c in &cell {
            start[c as usize + 1] += 1;
        }
        for c in 0..layout.count() {
            start[c + 1] += start[c];
        }
        let mut next = start.clone();
        let mut order = vec![0_u32; position.len()];
        for (particle, &c) in cell.iter().enumerate() {
            order[next[c as usize] as usize] = particle as u32;
            next[c as usize] += 1;
        }
        Self { layout, position, start, order }
    }

    /// The cells.
    pub fn layout(&self) -> &CellLayout {
        &self.layout
    }

    /// First rank of each cell, and one entry more for the end.
    pub fn start(&self) -> &[u32] {
        &self.start
    }

    /// The particle index at each rank.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The permutation alone, for who no longer needs the cells.
    pub fn into_order(self) -> Vec<u32> {
        self.order
    }

    /// The ranks of the particles in `cell`.
    pub fn ranks(&self, cell: usize) -> Range<usize> {
        self.start[cell] as usize..self.start[cell + 1] as usize
    }

    /// Calls `row(rank, neighbours)` for every particle of `cell`: all particles nearer than
    /// `cutoff` (m), in cell order, without the particle itself.
    pub fn for_each_row(
        &self,
        cell: usize,
        cutoff: f64,
        scratch: &mut Scratch,
        mut row: impl FnMut(usize, &[Neighbor]),
    ) {
        if self.ranks(cell).is_empty() {
            return;
        }
        self.gather(cell, scratch);
        for rank in self.ranks(cell) {
            let own = scratch.own + rank - self.ranks(cell).start;
            self.measure(own, scratch);
            scratch.select(own, cutoff * cutoff);
            row(rank, &scratch.neighbors);
        }
    }

    /// Copies ranks and coordinates of all candidates, so that they are contiguous in memory.
    fn gather(&self, cell: usize, scratch: &mut Scratch) {
        scratch.rank.clear();
        scratch.coordinate.iter_mut().for_each(Vec::clear);
        self.layout.for_each_near(cell, |near| {
            if near == cell {
                scratch.own = scratch.rank.len();
            }
            let ranks = self.ranks(near);
            for (axis, coordinate) in scratch.coordinate.iter_mut().enumerate() {
                let particles = &self.order[ranks.clone()];
                coordinate.extend(particles.iter().map(|&p| self.position[p as usize][axis]));
            }
            scratch.rank.extend(ranks.map(|rank| rank as u32));
        });
    }

    /// The squared distance of every candidate from candidate `own`.
    fn measure(&self, own: usize, scratch: &mut Scratch) {
        let Scratch { coordinate, squared, .. } = scratch;
        squared.clear();
        squared.resize(coordinate[0].len(), 0.0);
        let Domain { periodic, .. } = self.layout.domain;
        let extent = self.layout.domain.extent();
        for axis in 0..3 {
            let here = coordinate[axis][own];
            let candidates = squared.iter_mut().zip(&coordinate[axis]);
            if periodic[axis] {
                // Both are inside the domain, so one image more or less is enough.
                let (length, half) = (extent[axis], 0.5 * extent[axis]);
                candidates.for_each(|(squared, x)| {
                    let mut difference = x - here;
                    difference -= if difference > half { length } else { 0.0 };
                    difference += if difference < -half { length } else { 0.0 };
                    *squared += difference * difference;
                });
            } else {
                candidates.for_each(|(squared, x)| *squared += (x - here) * (x - here));
            }
        }
    }
}

impl Scratch {
    /// The candidates nearer than the cutoff, but for `own`.
    fn select(&mut self, own: usize, cutoff_squared: f64) {
        self.squared[own] = f64::INFINITY;
        self.near.resize(self.squared.len(), 0);
        let mut count = 0;
        for (candidate, &squared) in (0_u32..).zip(&self.squared) {
            // Written always and kept only if near: no branch to mispredict.
            self.near[count] = candidate;
            count += usize::from(squared < cutoff_squared);
        }
        let (rank, squared) = (&self.rank, &self.squared);
        self.neighbors.clear();
        self.neighbors.extend(self.near[..count].iter().map(|&candidate| Neighbor {
            rank: rank[candidate as usize],
            dist: squared[candidate as usize].sqrt(),
        }));
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
