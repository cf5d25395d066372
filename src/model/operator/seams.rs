//! Where materials meet of which one's conductivity depends on temperature, or which melts.
//!
//! Within a material heat flows down its potential, but potentials of different materials are no measure for
//! each other. The matrix has such pairs as if they were: a [`Seam`] says what they are short of. With the
//! weight w of the pair, made from the reference conductivities, that is
//! w ((K / K_ref) (T_b - T_a) - (psi_b - psi_a)), where K is the mean of the conductivities at T_a and T_b.

use std::ops::Range;

use rayon::prelude::*;

use super::PairWeight;
use super::fold::RowFold;
use super::rows::{Walk, cell_grid, tasks};
use crate::model::material::Material;
use crate::model::neighbors::Scratch;
use crate::model::{HeatCurve, PairMean, Problem};

/// The pairs of different materials, row by row.
#[derive(Clone, Debug)]
pub struct Seams {
    pair_mean: PairMean,
    materials: Vec<Material>,
    /// In the order of their pairs.
    rows: Vec<SeamRow>,
    pairs: Vec<SeamPair>,
}

/// Place and material of the other particle, and the weight, 1/s.
pub type SeamPair = (u32, u16, f64);

/// A particle that has neighbours of other materials.
#[derive(Clone, Copy, Debug)]
pub struct Seam<'a> {
    /// Its place.
    pub place: u32,
    /// Its material.
    pub material: u16,
    /// The pairs with these neighbours.
    pub pairs: &'a [SeamPair],
}

#[derive(Clone, Copy, Debug)]
struct SeamRow {
    place: u32,
    material: u16,
    /// Capacity where the particle is held, else none.
    held: Option<f64>,
    end: u32,
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
            let mut found: Vec<(usize, Vec<SeamPair>)> = Vec::new();
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
                            (meets && !is_held).then(|| {
                                (place[b], of_b, weight.between(row.a, b, n.dist) + by_walls)
                            })
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
        let found: Vec<_> = tasks(&grid).into_par_iter().flat_map_iter(of_cells).collect();
        let (mut rows, mut all) = (Vec::new(), Vec::new());
        for (a, pairs) in found {
            all.extend(pairs);
            let held = problem.is_held(a).then(|| problem.capacity(a));
            let end = all.len() as u32;
            rows.push(SeamRow { place: place[a], material: material(a), held, end });
        }
        let (pair_mean, materials) = (problem.pair_mean, problem.materials.clone());
        (!rows.is_empty()).then_some(Self { pair_mean, materials, rows, pairs: all })
    }

    /// Adds `factor` times what the rates are short of to `rates`, where `state` has the enthalpy of each
    /// place, but not for held particles; returns `factor` times what these gave beyond what the matrix knows,
    /// value x capacity / s.
    pub fn add(&self, state: impl Fn(usize) -> f64, factor: f64, rates: &mut [f64]) -> f64 {
        let (mut first, mut given) = (0, 0.0);
        for row in &self.rows {
            let place = row.place as usize;
            let own = self.at(row.material, state(place));
            let pairs = &self.pairs[first as usize..row.end as usize];
            let short = |&(b, material, weight): &SeamPair| {
                let other = self.at(material, state(b as usize));
                let reference =
                    [row.material, material].map(|m| self.materials[usize::from(m)].conductivity);
                let mean = self.pair_mean.of(own.conductivity, other.conductivity);
                let ratio = mean / self.pair_mean.of(reference[0], reference[1]);
                let by_matrix = other.potential - own.potential;
                weight * (ratio * (other.temperature - own.temperature) - by_matrix)
            };
            let rate = factor * pairs.iter().map(short).sum::<f64>();
            match row.held {
                Some(capacity) => given -= capacity * rate,
                None => rates[place] += rate,
            }
            first = row.end;
        }
        given
    }

    /// The rows.
    pub fn rows(&self) -> impl Iterator<Item = Seam<'_>> {
        let firsts = std::iter::once(0).chain(self.rows.iter().map(|row| row.end));
        self.rows.iter().zip(firsts).map(|(row, first)| Seam {
            place: row.place,
            material: row.material,
            pairs: &self.pairs[first as usize..row.end as usize],
        })
    }

    fn at(&self, material: u16, enthalpy: f64) -> Local {
        let material = &self.materials[usize::from(material)];
        let of = |of: fn(&HeatCurve, f64) -> f64, plain: f64| {
            material.curve.as_ref().map_or(plain, |curve| of(curve, enthalpy))
        };
        Local {
            temperature: of(HeatCurve::temperature, enthalpy),
            potential: of(HeatCurve::potential, enthalpy),
            conductivity: of(HeatCurve::conductivity, material.conductivity),
        }
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
