//! Finds the seams of a scene.

use std::collections::HashMap;
use std::ops::Range;

use rayon::prelude::*;

use super::{Pair, RowKind, SeamGroup, Seams};
use crate::model::Problem;
use crate::model::material::Material;
use crate::model::neighbors::{CellGrid, Neighbor, Scratch};
use crate::model::operator::PairWeight;
use crate::model::operator::fold::RowFold;
use crate::model::operator::rows::{Walk, cell_grid, tasks};

/// A row as it is found.
struct Found {
    /// The particle.
    a: usize,
    /// Its neighbours of other materials, with weights, 1/s.
    pairs: Vec<(usize, f64)>,
    /// The weights that a step of an enthalpy has of these before, 1/s, where they are others.
    written: Option<Vec<f64>>,
}

impl Seams {
    /// Those of `problem`, with the place of each particle; `None` where there are none. If they are to be `on_sites` of
    /// a lattice, pairs have its distances, so that those of positions do not keep rows apart by their last digits.
    /// `written` tells of a place its neighbours with the weights (1/s) that a step of an enthalpy has of them before
    /// seams add to it, where those are not the weights of the matrix.
    pub fn of(
        problem: &Problem,
        place: &[u32],
        on_sites: bool,
        written: impl Fn(usize) -> Option<Vec<(usize, f64)>> + Sync,
    ) -> Option<Self> {
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
        let distance = |of_positions: f64| match on_sites {
            true => problem.spacing * (of_positions / problem.spacing).powi(2).round().sqrt(),
            false => of_positions,
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
            let mut found: Vec<Found> = Vec::new();
            for cell in cells.filter(|&cell| may_meet(cell)) {
                grid.for_each_row(
                    cell,
                    problem.kernel.cutoff(),
                    &mut scratch,
                    |rank, neighbors| {
                        let row = walk.row(rank, neighbors, &mut fold);
                        let pair = |(k, n): (usize, &Neighbor)| {
                            let b = grid.order()[n.rank as usize] as usize;
                            let [of_a, of_b] = [material(row.a), material(b)];
                            let meets = of_a != of_b && !shares_curve(of_a, of_b);
                            let is_held = row.held && problem.is_held(b);
                            let by_walls = row.fold.map_or(0.0, |fold| fold.weight[k]);
                            (meets && !is_held)
                                .then(|| (b, weight.between(row.a, b, distance(n.dist)) + by_walls))
                        };
                        let pairs: Vec<_> = neighbors.iter().enumerate().filter_map(pair).collect();
                        if !pairs.is_empty() {
                            let written = written(place[row.a] as usize).map(|all| {
                                let of = |&(b, _): &(usize, f64)| {
                                    let of_b = all.iter().find(|(at, _)| *at == place[b] as usize);
                                    of_b.map_or(0.0, |&(_, weight)| weight)
                                };
                                pairs.iter().map(of).collect()
                            });
                            found.push(Found { a: row.a, pairs, written });
                        }
                    },
                );
            }
            found
        };
        let mut found: Vec<_> = tasks(&grid).into_par_iter().flat_map_iter(of_cells).collect();
        found.par_sort_unstable_by_key(|&Found { a, .. }| (material(a), place[a]));
        if found.is_empty() {
            return None;
        }
        let (mut groups, mut end) = (Vec::new(), 0);
        for of_one in found.chunk_by(|one, other| material(one.a) == material(other.a)) {
            let rows = end..end + of_one.len();
            end = rows.end;
            groups.push(SeamGroup { material: material(of_one[0].a), rows });
        }
        let mut row_of = HashMap::with_capacity(found.len());
        row_of.extend((0..).zip(&found).map(|(row, found)| (found.a, row)));
        let mut seams = Self {
            pair_mean: problem.pair_mean,
            materials: problem.materials.clone(),
            groups,
            places: found.iter().map(|found| place[found.a]).collect(),
            rows: Vec::with_capacity(found.len()),
            kinds: Vec::new(),
            pairs: Vec::new(),
            written: found.iter().any(|found| found.written.is_some()).then(Vec::new),
        };
        let mut kinds = HashMap::new();
        for (row, Found { a, pairs, written }) in (0_isize..).zip(&found) {
            let held = problem.is_held(*a).then(|| problem.capacity(*a));
            let pair = |(k, &(b, weight)): (usize, &(usize, f64))| {
                let written = written.as_ref().map_or(weight, |written| written[k]);
                (row_of[&b] - row, material(b), [weight, written])
            };
            // At the end of a support nothing flows.
            let with_weight =
                pairs.iter().enumerate().map(pair).filter(|(.., weights)| *weights != [0.0; 2]);
            let mut pairs: Vec<_> = with_weight.collect();
            pairs.sort_unstable_by_key(|&(step, _, weights)| (step, weights.map(f64::to_bits)));
            let of_pairs =
                pairs.iter().map(|&(step, of_b, [weight, _])| (step, of_b, weight.to_bits()));
            let of_written = written.is_some().then(|| {
                pairs.iter().map(|(.., [_, written])| written.to_bits()).collect::<Vec<_>>()
            });
            let key =
                (material(*a), held.map(f64::to_bits), of_pairs.collect::<Vec<_>>(), of_written);
            let kind =
                *kinds.entry(key).or_insert_with(|| seams.add_kind(material(*a), held, &pairs));
            seams.rows.push(kind);
        }
        Some(seams)
    }

    /// Adds a kind, with how many rows further, material and weights (1/s) of each neighbour: that of the matrix and the
    /// written one; rows ascend.
    fn add_kind(
        &mut self,
        material: u16,
        held: Option<f64>,
        pairs: &[(isize, u16, [f64; 2])],
    ) -> u32 {
        let conductivity = |of: u16| self.materials[usize::from(of)].conductivity;
        let step = |pair: Option<&(isize, u16, [f64; 2])>| pair.map_or(0, |&(step, ..)| step);
        let (first, last) = (step(pairs.first()), step(pairs.last()));
        let begin = self.pairs.len();
        for &(step, of_other, [weight, written]) in pairs {
            let mean = self.pair_mean.of(conductivity(material), conductivity(of_other));
            let over_mean = weight / mean;
            self.pairs.push(Pair { ahead: (step - first) as usize, weight, over_mean });
            self.written.iter_mut().for_each(|all| all.push(written));
        }
        let (span, pairs) = ((last - first) as usize, begin..self.pairs.len());
        self.kinds.push(RowKind { material, held, first, span, pairs });
        self.kinds.len() as u32 - 1
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
