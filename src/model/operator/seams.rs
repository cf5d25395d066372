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
use crate::model::neighbors::{CellGrid, Scratch};
use crate::model::{PairMean, Problem};

/// Rows that one parallel task works on, at least.
const ROWS_OF_A_TASK: usize = 1 << 9;

/// The pairs of different materials, row by row.
#[derive(Clone, Debug)]
pub struct Seams {
    pair_mean: PairMean,
    materials: Vec<Material>,
    /// By material, and then by that of a neighbour: one over the mean of the reference conductivities.
    over_mean: Vec<f64>,
    /// Ascending.
    places: Vec<u32>,
    /// By place.
    rows: Vec<SeamRow>,
    /// The rows of their neighbours, one row after the other.
    neighbors: Vec<u32>,
    /// The weights of the pairs, 1/s.
    weights: Vec<f64>,
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
    material: u16,
    /// Capacity where the particle is held, else none.
    held: Option<f64>,
    /// Where its pairs end.
    end: u32,
}

/// What the particle of a row is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// K
    pub temperature: f64,
    /// K
    pub potential: f64,
    /// What [`PairMean`] needs of its conductivity, W/(m K).
    pub term: f64,
    /// Its material.
    pub material: u16,
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
        // Far from where curves meet no neighbours need to be looked for.
        let curves = curves_of_cells(problem, &grid);
        let may_meet = |cell: usize| {
            let mut near = 0;
            grid.layout().for_each_near(cell, |other| near |= curves[other]);
            near.count_ones() > 1
        };
        let of_cells = |cells: Range<usize>| {
            let (mut scratch, mut fold) = (Scratch::default(), RowFold::default());
            let mut found: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
            for cell in cells.filter(|&cell| may_meet(cell)) {
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
        let places = found.iter().map(|&(a, _)| place[a]).collect();
        let mut rows = Vec::with_capacity(found.len());
        let (mut neighbors, mut weights) = (Vec::new(), Vec::new());
        for (a, pairs) in &found {
            neighbors.extend(pairs.iter().map(|(b, _)| row_of[b]));
            weights.extend(pairs.iter().map(|&(_, weight)| weight));
            let held = problem.is_held(*a).then(|| problem.capacity(*a));
            rows.push(SeamRow { material: material(*a), held, end: neighbors.len() as u32 });
        }
        let (pair_mean, materials) = (problem.pair_mean, problem.materials.clone());
        let over_mean = |a: &Material, b: &Material| {
            // What does not conduct at all has no weight.
            let mean = pair_mean.of(a.conductivity, b.conductivity);
            if mean > 0.0 { 1.0 / mean } else { 0.0 }
        };
        let of_pairs = |a: &Material| materials.iter().map(|b| over_mean(a, b)).collect::<Vec<_>>();
        let over_mean = materials.iter().flat_map(of_pairs).collect();
        (!rows.is_empty()).then_some(Self {
            pair_mean,
            materials,
            over_mean,
            places,
            rows,
            neighbors,
            weights,
        })
    }

    /// The places of its rows, ascending.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    /// The material of a row.
    pub fn material(&self, row: usize) -> usize {
        usize::from(self.rows[row].material)
    }

    /// What the particle of a row is like with an enthalpy (K).
    pub fn local(&self, row: usize, enthalpy: f64) -> Local {
        let material = &self.materials[self.material(row)];
        let plain = || [enthalpy, enthalpy, material.conductivity];
        let [temperature, potential, conductivity] =
            material.curve.as_ref().map_or_else(plain, |curve| curve.state(enthalpy));
        self.local_of(row, [temperature, potential, conductivity])
    }

    /// The same with a temperature (K), a potential (K) and a conductivity (W/(m K)).
    pub fn local_of(&self, row: usize, [temperature, potential, conductivity]: [f64; 3]) -> Local {
        let (term, material) = (self.pair_mean.term(conductivity), self.rows[row].material);
        Local { temperature, potential, term, material }
    }

    /// What all of them are like, which `local` tells of a row and its place.
    pub fn locals(&self, local: impl Fn(usize, usize) -> Local + Sync) -> Vec<Local> {
        let local = |(row, &place): (usize, &u32)| local(row, place as usize);
        let places = self.places.par_iter().with_min_len(ROWS_OF_A_TASK);
        places.enumerate().map(local).collect()
    }

    /// What the rate of a row is short of, where its neighbours are like `locals`, 1/s x K.
    #[inline]
    fn rate(&self, row: usize, locals: &[Local]) -> f64 {
        let own = &locals[row];
        let over_mean = &self.over_mean[usize::from(own.material) * self.materials.len()..];
        let short = |(&other, weight): (&u32, &f64)| {
            let other = &locals[other as usize];
            let mean = self.pair_mean.of_terms(own.term, other.term);
            let by_heat = over_mean[usize::from(other.material)] * mean;
            weight
                * (by_heat * (other.temperature - own.temperature)
                    - (other.potential - own.potential))
        };
        let pairs = self.pairs_of(row);
        self.neighbors[pairs.clone()].iter().zip(&self.weights[pairs]).map(short).sum()
    }

    /// Adds `factor` times what rates of some rows are short of, where their neighbours are like `locals`, to those of
    /// places from `first` on, but not for held particles; returns `factor` times what these gave beyond what the
    /// matrix knows, value x capacity / s.
    pub fn add(
        &self,
        rows: Range<usize>,
        locals: &[Local],
        factor: f64,
        first: usize,
        rates: &mut [f64],
    ) -> f64 {
        let mut given = 0.0;
        for row in rows {
            let rate = factor * self.rate(row, locals);
            match self.rows[row].held {
                Some(capacity) => given -= capacity * rate,
                None => rates[self.places[row] as usize - first] += rate,
            }
        }
        given
    }

    /// Its rows.
    pub fn rows(&self) -> impl Iterator<Item = Seam> + '_ {
        (0..self.rows.len()).map(|row| {
            let pair = |(&other, &weight): (&u32, &f64)| {
                let other = other as usize;
                (self.places[other], self.rows[other].material, weight)
            };
            let pairs = self.pairs_of(row);
            let pairs = self.neighbors[pairs.clone()].iter().zip(&self.weights[pairs]);
            Seam {
                place: self.places[row],
                material: self.rows[row].material,
                pairs: pairs.map(pair).collect(),
            }
        })
    }

    fn pairs_of(&self, row: usize) -> Range<usize> {
        let first = if row > 0 { self.rows[row - 1].end } else { 0 };
        first as usize..self.rows[row].end as usize
    }

    /// Bytes that they hold.
    pub fn memory_bytes(&self) -> usize {
        let pairs = size_of_val(&*self.neighbors) + size_of_val(&*self.weights);
        size_of_val(&*self.places)
            + size_of_val(&*self.rows)
            + size_of_val(&*self.over_mean)
            + pairs
    }
}

/// By cell: which curves its particles have, a bit each.
fn curves_of_cells(problem: &Problem, grid: &CellGrid<'_>) -> Vec<u64> {
    let materials = &problem.materials;
    let bit = |material: &Material| {
        let first = materials.iter().position(|other| other.shares_curve(material));
        // Of so many materials all are taken to meet.
        first.and_then(|first| 1_u64.checked_shl(first as u32)).unwrap_or(u64::MAX)
    };
    let bits: Vec<u64> = materials.iter().map(bit).collect();
    let curve = |&particle: &u32| bits[usize::from(problem.particles.material[particle as usize])];
    let of_cell = |cell: usize| {
        grid.order()[grid.ranks(cell)].iter().map(curve).fold(0, |all, curve| all | curve)
    };
    tasks(grid).into_par_iter().flat_map_iter(|cells| cells.map(of_cell)).collect()
}
