//! Rows of a lattice whose neighbours are as far away as those of others, with the same weights: only these are stored.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::model::operator::{SomeRows, seek, within_near};
use crate::model::wide::{self, Work};
use crate::solver::cpu::entries::{LANES, Lines};
use crate::solver::cpu::shared_lines::LinesFinder;

/// The rows of some sites, to which neither walls nor sources add anything.
#[derive(Clone)]
pub(super) struct SharedRows {
    /// Ascending.
    sites: Vec<u32>,
    /// By row: which of the lines it is.
    which: Vec<u16>,
    lines: Arc<[Lines]>,
}

impl SharedRows {
    /// Takes such rows out of those of a lattice with `count` sites.
    pub(super) fn take_from(rows: &mut SomeRows, count: usize) -> Self {
        let of_block = |block: usize| {
            let (mut finder, mut found) = (LinesFinder::of_part(), Vec::new());
            for (site, others, weights) in rows.plain_rows(block) {
                // A line may end behind the last neighbour.
                if others.iter().any(|&other| other as usize + LANES > count) {
                    continue;
                }
                let step = |&other: &u32| other as isize - site as isize;
                let neighbors = others.iter().map(step).zip(weights.iter().copied());
                found.extend(finder.which(neighbors).map(|which| (site, which)));
            }
            (finder, found)
        };
        let blocks: Vec<_> = (0..rows.blocks()).into_par_iter().map(of_block).collect();
        let (mut finder, mut sites, mut which) = (LinesFinder::default(), Vec::new(), Vec::new());
        for (of_block, found) in blocks {
            let here = finder.take(of_block);
            for (site, of_block) in found {
                if let Some(here) = here[usize::from(of_block)] {
                    sites.push(site);
                    which.push(here);
                }
            }
        }
        rows.remove(&sites);
        sites.shrink_to_fit();
        which.shrink_to_fit();
        Self { sites, which, lines: finder.lines().into() }
    }

    /// Where they are, ascending.
    pub(super) fn sites(&self) -> &[u32] {
        &self.sites
    }

    /// Takes those at some sites (ascending) out.
    pub(super) fn take_out(&mut self, sites: &[u32]) -> Self {
        let mut rest = sites.iter().peekable();
        let rows: Vec<(u32, u16)> =
            self.sites.iter().copied().zip(self.which.iter().copied()).collect();
        let (out, left): (Vec<_>, Vec<_>) = rows.into_iter().partition(|(site, _)| {
            while rest.next_if(|other| *other < site).is_some() {}
            rest.next_if_eq(&site).is_some()
        });
        let [left, out] = [left, out].map(|rows| {
            let (sites, which) = rows.into_iter().unzip();
            Self { sites, which, lines: Arc::clone(&self.lines) }
        });
        *self = left;
        out
    }

    /// Calls `write(site, rate)` for each of those in `sites`. They are looked for from `near` on, which becomes the
    /// first of them.
    pub(super) fn rates(
        &self,
        sites: &Range<usize>,
        near: &mut usize,
        state: &[f64],
        write: impl FnMut(usize, f64),
    ) {
        let rows = within_near(&self.sites, sites, near);
        if !rows.is_empty() {
            let (sites, which) = (&self.sites[rows.clone()], &self.which[rows]);
            wide::run(Rates { lines: &self.lines, sites, which, state, write });
        }
    }

    /// The neighbours of a site that has such a row, looked for from row `near` on, which becomes the first that is not
    /// before it.
    #[inline(always)]
    pub(super) fn at(&self, site: usize, near: &mut usize) -> Option<&Lines> {
        *near = seek(&self.sites, *near, |&of_row| (of_row as usize) < site);
        let is_there = self.sites.get(*near).is_some_and(|&of_row| of_row as usize == site);
        is_there.then(|| &self.lines[usize::from(self.which[*near])])
    }

    /// Calls `write(site, A_aa)` for each, 1/s.
    pub(super) fn diagonals(&self, mut write: impl FnMut(usize, f64)) {
        let diagonals: Vec<f64> = self.lines.iter().map(Lines::diagonal).collect();
        for (&site, &which) in self.sites.iter().zip(&self.which) {
            write(site as usize, diagonals[usize::from(which)]);
        }
    }

    /// Bytes that they hold, but for lines.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.sites) + size_of_val(&*self.which)
    }

    /// Bytes of lines, which those that were [taken out](Self::take_out) have too.
    pub(super) fn bytes_of_lines(&self) -> usize {
        Lines::all_bytes(&self.lines)
    }
}

/// See [`SharedRows::rates`].
struct Rates<'a, W> {
    lines: &'a [Lines],
    sites: &'a [u32],
    which: &'a [u16],
    state: &'a [f64],
    write: W,
}

impl<W: FnMut(usize, f64)> Work for Rates<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { lines, sites, which, state, mut write } = self;
        for (&site, &which) in sites.iter().zip(which) {
            let site = site as usize;
            write(site, lines[usize::from(which)].rate::<FUSED>(site, state));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::lattice::MixedScene;
    use crate::model::{KernelKind, Material, scenes};

    #[test]
    fn rows_give_the_same_rates_with_lines_and_with_weights_of_their_own() {
        for (counts, interface) in [
            ([40, 1, 1], 0.5),
            ([40, 1, 1], 3.8),
            ([16, 12, 1], 0.5),
            ([16, 12, 1], 1.5),
            ([12, 10, 9], 0.5),
        ] {
            let dimension = counts.iter().filter(|&&count| count > 1).count();
            let mut problem = scenes::lattice(KernelKind::WendlandC4, dimension, counts, 0.1, 2.5);
            problem.domain.periodic[1] = dimension == 2;
            problem.materials.push(Material::diffusive("sand", 0.3, 1000.0));
            let count = problem.particles.len();
            for particle in 0..count {
                let position = problem.particles.position[particle];
                problem.particles.material[particle] = u16::from(position.x > interface);
            }
            problem.held = vec![3, (count / 2) as u32];
            let (_, all) = MixedScene::of(&problem).expect("a lattice").assemble(&problem);
            let mut rest = all.clone();
            let shared = SharedRows::take_from(&mut rest, count);
            let state: Vec<f64> = (0..count).map(|k| ((37 * k) % 101) as f64).collect();
            for sites in [0..count, 5..count / 2] {
                let mut expected = Vec::new();
                let of_all = |site, rate| expected.push((site, rate));
                all.rates(&sites, &mut 0, &state, &[], of_all);
                let mut found = Vec::new();
                shared.rates(&sites, &mut 0, &state, |site, rate| found.push((site, rate)));
                if dimension > 1 {
                    let (lines, all) = (shared.lines.len(), shared.sites.len());
                    assert!(3 * lines < 2 * all, "{counts:?}, {interface}: {lines} of {all}");
                    assert!(
                        2 * found.len() > expected.len(),
                        "{counts:?}, {interface}: most are shared"
                    );
                }
                rest.rates(&sites, &mut 0, &state, &[], |site, rate| found.push((site, rate)));
                found.sort_by_key(|&(site, _)| site);
                assert_eq!(found.len(), expected.len());
                for ((site, rate), (expected_site, expected)) in found.iter().zip(&expected) {
                    assert_eq!(site, expected_site);
                    assert!((rate - expected).abs() < 1e-10, "{site}: {rate}");
                }
            }
            let (mut of_all, mut of_both) = (vec![0.0; count], vec![0.0; count]);
            all.diagonals(|site, diagonal| of_all[site] = diagonal);
            shared.diagonals(|site, diagonal| of_both[site] = diagonal);
            rest.diagonals(|site, diagonal| of_both[site] = diagonal);
            for (one, other) in of_all.iter().zip(&of_both) {
                assert!((one - other).abs() <= 1e-13 * one.abs());
            }
            for (k, &site) in shared.sites.iter().enumerate() {
                let (lines, site) =
                    (shared.at(site as usize, &mut 0).expect("a row"), site as usize);
                assert!(std::ptr::eq(lines, &shared.lines[usize::from(shared.which[k])]));
                let (others, weights) = all.entries_of(site, &mut 0).expect("a row");
                let mut entries: Vec<_> =
                    others.iter().map(|&b| b as usize).zip(weights.iter().copied()).collect();
                entries.sort_by_key(|&(other, _)| other);
                let mut of_lines = Vec::new();
                lines.for_each(site, |other, weight| of_lines.push((other, weight)));
                assert_eq!(of_lines, entries);
                assert!(rest.entries_of(site, &mut 0).is_none());
            }
            assert!(shared.at(3, &mut 0).is_none(), "held");
            let mut odd = shared.clone();
            // Some of them have no such row.
            let even = odd.take_out(&(0..count as u32).step_by(2).collect::<Vec<_>>());
            for &site in shared.sites() {
                let site = site as usize;
                let found = [&even, &odd].map(|rows| rows.at(site, &mut 0));
                let expected = shared.at(site, &mut 0);
                assert_eq!(
                    found,
                    if site.is_multiple_of(2) { [expected, None] } else { [None, expected] }
                );
            }
            assert_eq!(even.sites().len() + odd.sites().len(), shared.sites().len());
            // Of lines that would end behind the last site nothing is shared.
            let at_end = |site: usize| {
                all.entries_of(site, &mut 0)
                    .is_some_and(|(others, _)| others.contains(&(count as u32 - 1)))
            };
            let ends = (0..count).filter(|&site| at_end(site));
            assert!(ends.clone().all(|site| shared.at(site, &mut 0).is_none()));
            assert_eq!(ends.count() > 0, interface > 1.0);
        }
    }
}
