//! Rows that differ from a lattice's stencil by seams alone.
//!
//! A step of an enthalpy adds to what is written of a pair at a [seam](crate::model::operator::Seams) what that is short
//! of. It may as well be written by the stencil, which goes over all sites anyway, as by a row.

use rayon::prelude::*;

use super::MixedScene;
use crate::model::Problem;
use crate::model::operator::SomeRows;

/// A weight is that of a stencil if it is so near to it, as a share: sums of ghosts are rounded, and walls add to rows what
/// comes of positions.
const ROUNDING: f64 = 1e-12;

impl MixedScene {
    /// The sites, ascending, of those of its `rows` to which neither walls nor sources add anything, and which are the
    /// stencil's but for pairs at seams: of such a pair the stencil has at most so many times the weight of the row.
    pub fn beside_seams(&self, problem: &Problem, rows: &SomeRows, most: f64) -> Vec<u32> {
        if problem.has_one_curve() {
            return Vec::new();
        }
        let of_block = |block: usize| {
            let is_so = move |(site, others, weights): &(u32, &[u32], &[f64])| {
                let row = others.iter().map(|&other| other as usize).zip(weights.iter().copied());
                let row = row.filter(|&(_, weight)| weight != 0.0);
                self.is_beside_seams(problem, *site as usize, row.collect(), most)
            };
            rows.plain_rows(block).filter(is_so).map(|(site, ..)| site)
        };
        (0..rows.blocks()).into_par_iter().flat_map_iter(of_block).collect()
    }

    /// The factor of the stencil at a site with a particle.
    pub fn factor(&self, problem: &Problem, site: usize) -> f64 {
        let material = self.lattice.material(problem, site).expect("a particle");
        self.ratio(&problem.materials[usize::from(material)])
    }

    /// The neighbours in the stencil of a site with a particle, ascending, and their weights, 1/s.
    pub fn stencil(&self, problem: &Problem, site: usize) -> Vec<(usize, f64)> {
        let (ratio, mut entries) = (self.factor(problem, site), Vec::new());
        self.lattice.entries(site, |other, weight| entries.push((other, ratio * weight)));
        // At the end of a support nothing flows.
        entries.retain(|&(_, weight)| weight != 0.0);
        entries.sort_unstable_by_key(|&(other, _)| other);
        // Ghosts of a particle are entries of their own.
        entries.dedup_by(|next, last| {
            let is_same = next.0 == last.0;
            if is_same {
                last.1 += next.1;
            }
            is_same
        });
        entries
    }

    fn is_beside_seams(
        &self,
        problem: &Problem,
        site: usize,
        mut row: Vec<(usize, f64)>,
        most: f64,
    ) -> bool {
        let material = |site: usize| self.lattice.material(problem, site);
        let is_seam = |other: usize| {
            let of = material(site).zip(material(other)).filter(|(own, of_other)| own != of_other);
            let curves = of
                .map(|(own, of_other)| [own, of_other].map(|m| &problem.materials[usize::from(m)]));
            curves.is_some_and(|[own, of_other]| !own.shares_curve(of_other))
        };
        let stencil = self.stencil(problem, site);
        row.sort_unstable_by_key(|&(other, _)| other);
        let is_close =
            |weight: f64, of_row: f64| (of_row - weight).abs() <= ROUNDING * weight.abs();
        stencil.len() == row.len()
            && stencil.iter().zip(&row).all(|(&(other, weight), &(in_row, of_row))| {
                let holds = match is_seam(other) {
                    true => weight.abs() <= most * of_row.abs(),
                    false => is_close(weight, of_row),
                };
                other == in_row && holds
            })
    }
}
