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
#[derive(Default)]
pub struct Scratch {
    /// Rank of each candidate.
    rank: Vec<u32>,
    /// Position of each candidate, m.
    position: Vec<DVec3>,
    /// The candidates cell by cell.
    groups: Vec<Group>,
    /// What the search writes to: squared distances below the cutoff, then what comes next.
    found: Vec<(u32, f64)>,
    neighbors: Vec<Neighbor>,
    /// Where the cell's own particles begin among the candidates.
    own: usize,
}

/// The candidates of one cell, and the box that they fill.
struct Group {
    candidates: Range<usize>,
    min: DVec3,
    max: DVec3,
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
        let first = self.ranks(cell).start;
        for rank in self.ranks(cell) {
            let own = scratch.own + rank - first;
            if self.layout.domain.periodic.contains(&true) {
                scratch.search::<true>(own, cutoff * cutoff, &self.layout.domain);
            } else {
                scratch.search::<false>(own, cutoff * cutoff, &self.layout.domain);
            }
            row(rank, &scratch.neighbors);
        }
    }

    /// Copies ranks and positions of all candidates, so that they are contiguous in memory.
    fn gather(&self, cell: usize, scratch: &mut Scratch) {
        scratch.rank.clear();
        scratch.position.clear();
        scratch.groups.clear();
        self.layout.for_each_near(cell, |near| {
            let start = scratch.rank.len();
            if near == cell {
                scratch.own = start;
            }
            let ranks = self.ranks(near);
            let particles = &self.order[ranks.clone()];
            scratch.position.extend(particles.iter().map(|&p| self.position[p as usize]));
            scratch.rank.extend(ranks.map(|rank| rank as u32));
            let of_cell = &scratch.position[start..];
            scratch.groups.push(Group {
                candidates: start..scratch.rank.len(),
                min: of_cell.iter().copied().fold(DVec3::INFINITY, DVec3::min),
                max: of_cell.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
            });
        });
        scratch.found.resize(scratch.rank.len() + 1, (0, 0.0));
    }
}

impl Scratch {
    /// Finds the candidates nearer than the cutoff, but for `own`. A cell whose particles are all
    /// too far is passed over: on a lattice that is most cells.
    fn search<const PERIODIC: bool>(&mut self, own: usize, cutoff_squared: f64, domain: &Domain) {
        let here = self.position[own];
        let extent = domain.extent();
        let mut count = 0;
        for group in &self.groups {
            let outside = (group.min - here).max(here - group.max).max(DVec3::ZERO);
            // Round a periodic axis the other way may be shorter.
            let is_far = !PERIODIC && outside.length_squared() >= cutoff_squared;
            if is_far {
                continue;
            }
            for candidate in group.candidates.clone() {
                let mut difference = self.position[candidate] - here;
                if PERIODIC {
                    difference = nearest_image(difference, extent, domain.periodic);
                }
                let squared = difference.length_squared();
                // Written always and kept only if near: no branch to mispredict.
                self.found[count] = (self.rank[candidate], squared);
                count += usize::from(squared < cutoff_squared && candidate != own);
            }
        }
        self.neighbors.clear();
        let found = self.found[..count].iter();
        self.neighbors
            .extend(found.map(|&(rank, squared)| Neighbor { rank, dist: squared.sqrt() }));
    }
}

/// The nearest image of a difference of two positions that are both inside the domain, where one
/// image more or less is enough.
fn nearest_image(mut difference: DVec3, extent: DVec3, periodic: [bool; 3]) -> DVec3 {
    for axis in 0..3 {
        if periodic[axis] {
            let half = 0.5 * extent[axis];
            if difference[axis] > half {
                difference[axis] -= extent[axis];
            } else if difference[axis] < -half {
                difference[axis] += extent[axis];
            }
        }
    }
    difference
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
