//! Particles sorted into cells, and the walk over their neighbours.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::CellLayout;

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
#[derive(Default)]
pub struct Scratch {
    rank: Vec<u32>,
    position: Vec<DVec3>,
    neighbors: Vec<Neighbor>,
}

impl<'a> CellGrid<'a> {
    /// Sorts `position` into the cells of `layout`.
    pub fn new(layout: CellLayout, position: &'a [DVec3]) -> Self {
        let cell: Vec<u32> = position
            .par_iter()
            .map(|&x| layout.index(layout.coordinates(x)) as u32)
            .collect();
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
        Self {
            layout,
            position,
            start,
            order,
        }
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

    /// Calls `row(rank, neighbours)` for the particles of `cell` whose rank passes `wanted`: all
    /// particles nearer than `cutoff` (m), in cell order, without the particle itself.
    pub fn for_each_row(
        &self,
        cell: usize,
        cutoff: f64,
        scratch: &mut Scratch,
        wanted: impl Fn(usize) -> bool,
        mut row: impl FnMut(usize, &[Neighbor]),
    ) {
        if !self.ranks(cell).any(&wanted) {
            return;
        }
        self.gather(cell, scratch);
        for rank in self.ranks(cell).filter(|&rank| wanted(rank)) {
            self.collect_neighbors(rank, cutoff * cutoff, scratch);
            row(rank, &scratch.neighbors);
        }
    }

    /// Copies ranks and positions of all candidates, so that they are contiguous in memory.
    fn gather(&self, cell: usize, scratch: &mut Scratch) {
        scratch.rank.clear();
        scratch.position.clear();
        self.layout.for_each_near(cell, |near| {
            let ranks = self.ranks(near);
            let particles = &self.order[ranks.clone()];
            scratch.rank.extend(ranks.map(|rank| rank as u32));
            scratch
                .position
                .extend(particles.iter().map(|&p| self.position[p as usize]));
        });
    }

    fn collect_neighbors(&self, rank: usize, cutoff_squared: f64, scratch: &mut Scratch) {
        if self.layout.domain.periodic.contains(&true) {
            let half = 0.5 * self.layout.domain.extent();
            let shortest = |difference| self.shortest(difference, half);
            self.collect(rank, cutoff_squared, scratch, shortest);
        } else {
            self.collect(rank, cutoff_squared, scratch, |difference| difference);
        }
    }

    /// The search itself, once for each way to take a difference of positions.
    fn collect(
        &self,
        rank: usize,
        cutoff_squared: f64,
        scratch: &mut Scratch,
        shortest: impl Fn(DVec3) -> DVec3,
    ) {
        let here = self.position[self.order[rank] as usize];
        let Scratch {
            rank: ranks,
            position,
            neighbors,
        } = scratch;
        neighbors.clear();
        for (&other, &x) in ranks.iter().zip(position.iter()) {
            let squared = shortest(x - here).length_squared();
            if squared < cutoff_squared && other as usize != rank {
                neighbors.push(Neighbor {
                    rank: other,
                    dist: squared.sqrt(),
                });
            }
        }
    }

    /// The nearest image of a difference of two positions that are both inside the domain.
    fn shortest(&self, mut difference: DVec3, half: DVec3) -> DVec3 {
        for axis in 0..3 {
            if self.layout.domain.periodic[axis] {
                if difference[axis] > half[axis] {
                    difference[axis] -= 2.0 * half[axis];
                } else if difference[axis] < -half[axis] {
                    difference[axis] += 2.0 * half[axis];
                }
            }
        }
        difference
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
