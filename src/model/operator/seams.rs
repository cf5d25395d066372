//! Where materials meet of which one's conductivity depends on temperature, or which melts.
//!
//! Within a material heat flows down its potential, but potentials of different materials are no measure for
//! each other. The matrix has such pairs as if they were: a [`Seam`] says what they are short of. With the
//! weight w of the pair, made from the reference conductivities, that is
//! w ((K / K_ref) (T_b - T_a) - (psi_b - psi_a)), where K is the mean of the conductivities at T_a and T_b.

use std::collections::HashMap;
use std::ops::Range;

use rayon::prelude::*;

use super::PairWeight;
use super::fold::RowFold;
use super::rows::{Walk, cell_grid, tasks};
use crate::model::material::Material;
use crate::model::neighbors::Scratch;
use crate::model::{PairMean, Problem};

/// Rows that one parallel task works on, at least.
const ROWS_OF_A_TASK: usize = 1 << 9;

/// The pairs of different materials, row by row.
#[derive(Clone, Debug)]
pub struct Seams {
    pair_mean: PairMean,
    materials: Vec<Material>,
    /// By place, ascending.
    rows: Vec<SeamRow>,
    /// In the order of their rows.
    pairs: Vec<SeamPair>,
}

/// A particle that has neighbours of other materials.
#[derive(Clone, Debug)]
pub struct Seam {
    /// Its place.
    pub place: u32,
    /// Its material.
    pub material: u16,
    /// Place and material of each of these neighbours, and the weight of the pair, 1/s.
    pub pairs: Vec<(u32, u16, f64)>,
}

#[derive(Clone, Copy, Debug)]
struct SeamRow {
    place: u32,
    material: u16,
    /// Capacity where the particle is held, else none.
    held: Option<f64>,
    end: u32,
}

/// One of these neighbours.
#[derive(Clone, Copy, Debug)]
struct SeamPair {
    /// Its row.
    row: u32,
    /// 1/s
    weight: f64,
    /// The weight over the mean of the reference conductivities.
    over_mean: f64,
}

impl Seams {
    /// Those of `problem`, with the place of each particle; `None` where there are none.
    pub fn of(problem: &Problem, place: &[u32]) -> Option<Self> {
        if problem.has_one_curve() {
            return None;
        }
        let grid = cell_grid(problem);
        let weight = PairWeight::new(problem);
        let walk = Walk::new(problem, grid.order(), &weight);
        let material = |particle: usize| problem.particles.material[particle];
        let shares_curve = |a: u16, b: u16| {
            problem.materials[usize::from(a)].shares_curve(&problem.materials[usize::from(b)])
        };
        let of_cells = |cells: Range<usize>| {
            let (mut scratch, mut fold) = (Scratch::default(), RowFold::default());
            let mut found: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
            for cell in cells {
                grid.for_each_row(
                    cell,
                    problem.kernel.cutoff(),
                    &mut scratch,
                    |rank, neighbors| {
                        let row = walk.row(rank, neighbors, &mut fold);
                        let pair = |(k, n): (usize, &crate::model::neighbors::Neighbor)| {
                            let b = grid.order()[n.rank as usize] as usize;
                            let [of_a, of_b] = [material(row.a), material(b)];
                            let meets = of_a != of_b && !shares_curve(of_a, of_b);
                            let is_held = row.held && problem.is_held(b);
                            let by_walls = row.fold.map_or(0.0, |fold| fold.weight[k]);
                            (meets && !is_held)
                                .then(|| (b, weight.between(row.a, b, n.dist) + by_walls))
                        };
                        let pairs: Vec<_> = neighbors.iter().enumerate().filter_map(pair).collect();
                        if !pairs.is_empty() {
                            found.push((row.a, pairs));
                        }
                    },
                );
            }
            found
        };
        let mut found: Vec<_> = tasks(&grid).into_par_iter().flat_map_iter(of_cells).collect();
        found.par_sort_unstable_by_key(|&(a, _)| place[a]);
        let mut row_of = HashMap::with_capacity(found.len());
        row_of.extend((0..).zip(&found).map(|(row, &(a, _))| (a, row)));
        let (mut rows, mut pairs) = (Vec::with_capacity(found.len()), Vec::new());
        for (a, neighbors) in &found {
            pairs.extend(neighbors.iter().map(|&(b, weight)| {
                let of = [*a, b].map(|p| problem.materials[usize::from(material(p))].conductivity);
                // What does not conduct at all has no weight.
                let mean = problem.pair_mean.of(of[0], of[1]);
                let over_mean = if weight == 0.0 { 0.0 } else { weight / mean };
                SeamPair { row: row_of[&b], weight, over_mean }
            }));
            let held = problem.is_held(*a).then(|| problem.capacity(*a));
            let end = pairs.len() as u32;
            rows.push(SeamRow { place: place[*a], material: material(*a), held, end });
        }
        let (pair_mean, materials) = (problem.pair_mean, problem.materials.clone());
        (!rows.is_empty()).then_some(Self { pair_mean, materials, rows, pairs })
    }

    /// What the rates of its rows are short of, where `state` has the enthalpy of each place.
    pub fn rates(&self, state: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
        let local = |row: &SeamRow| self.at(row.material, state(row.place as usize));
        let rows = self.rows.par_iter().with_min_len(ROWS_OF_A_TASK);
        let locals: Vec<Local> = rows.map(local).collect();
        let rate = |row: usize| {
            let own = &locals[row];
            let short = |pair: &SeamPair| {
                let other = &locals[pair.row as usize];
                let mean = self.pair_mean.of(own.conductivity, other.conductivity);
                pair.over_mean * mean * (other.temperature - own.temperature)
                    - pair.weight * (other.potential - own.potential)
            };
            self.pairs[self.pairs_of(row)].iter().map(short).sum::<f64>()
        };
        (0..self.rows.len()).into_par_iter().with_min_len(ROWS_OF_A_TASK).map(rate).collect()
    }

    /// Adds `factor` times what rates of rows are short of, `of_rows`, to those of places from `first` on, but not
    /// for held particles; returns `factor` times what these gave beyond what the matrix knows,
    /// value x capacity / s.
    pub fn add(&self, of_rows: &[f64], factor: f64, first: usize, rates: &mut [f64]) -> f64 {
        let row_at = |place: usize| self.rows.partition_point(|row| (row.place as usize) < place);
        let mut given = 0.0;
        let rows = row_at(first)..row_at(first + rates.len());
        for (row, rate) in self.rows[rows.clone()].iter().zip(&of_rows[rows]) {
            match row.held {
                Some(capacity) => given -= capacity * factor * rate,
                None => rates[row.place as usize - first] += factor * rate,
            }
        }
        given
    }

    /// Its rows.
    pub fn rows(&self) -> impl Iterator<Item = Seam> + '_ {
        (0..self.rows.len()).map(|row| {
            let SeamRow { place, material, .. } = self.rows[row];
            let pair = |pair: &SeamPair| {
                let other = &self.rows[pair.row as usize];
                (other.place, other.material, pair.weight)
            };
            let pairs = self.pairs[self.pairs_of(row)].iter().map(pair).collect();
            Seam { place, material, pairs }
        })
    }

    fn pairs_of(&self, row: usize) -> Range<usize> {
        let first = if row > 0 { self.rows[row - 1].end } else { 0 };
        first as usize..self.rows[row].end as usize
    }

    fn at(&self, material: u16, enthalpy: f64) -> Local {
        let material = &self.materials[usize::from(material)];
        let plain = || [enthalpy, enthalpy, material.conductivity];
        let [temperature, potential, conductivity] =
            material.curve.as_ref().map_or_else(plain, |curve| curve.state(enthalpy));
        Local { temperature, potential, conductivity }
    }

    /// Bytes that they hold.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.rows) + size_of_val(&*self.pairs)
    }
}

/// What a particle is like.
struct Local {
    temperature: f64,
    potential: f64,
    conductivity: f64,
}
