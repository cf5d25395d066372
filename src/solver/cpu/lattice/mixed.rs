//! Scenes that a stencil describes in part: it goes over all sites, and what it does not describe is
//! written again. In an enthalpy's step rows are not that differ from it by seams alone, which are added to anyway.

use std::ops::Range;
use std::sync::Arc;

use super::around::Around;
use super::kernel::{Run, Scratch, Seen};
use super::parts::Parts;
use super::shared_rows::SharedRows;
use super::{BesideSeams, LatticeOperator};
use crate::model::lattice::{LatticeScene, MixedScene};
use crate::model::operator::{SomeRows, SourceRows, within_near};
use crate::model::{Material, Problem};
use crate::solver::cpu::entries::{Entries, Near};
use crate::solver::cpu::operator::Now;
use crate::solver::cpu::written::Written;

/// Empty sites in a row that are passed over: fewer are worked on together with what lies around
/// them, since a short part of a line costs as much as a long one.
const GAP: usize = 128;

/// A stencil that has at most so many times the weight of a pair at a seam may write it for a row: what it writes is
/// taken out again, and of more than a step should move rounding would be seen.
const MOST_OF_WEIGHT: f64 = 100.0;

/// A scene with rows where its stencil does not hold.
pub(in crate::solver::cpu) struct Mixed {
    scene: Arc<MixedScene>,
    /// Of what the stencil writes, and of all rows.
    parts: Parts,
    row_parts: Parts,
    rows: SomeRows,
    /// Those that were among them and share lines.
    shared: SharedRows,
    /// Those of these that an enthalpy's step leaves to the stencil: see [`MixedScene::beside_seams`].
    beside_seams: SharedRows,
}

impl Mixed {
    pub(in crate::solver::cpu) fn new(
        problem: &Problem,
        scene: Arc<MixedScene>,
        mut rows: SomeRows,
    ) -> Self {
        let sites = scene.lattice.counts.iter().product();
        let all_rows: Vec<u32> = rows.rank().to_vec();
        let beside_seams = scene.beside_seams(problem, &rows, MOST_OF_WEIGHT);
        let mut shared = SharedRows::take_from(&mut rows, sites);
        let beside_seams = shared.take_out(&beside_seams);
        if problem.has_one_curve() {
            let [parts, row_parts] = [&scene.ratios[..], &[]].map(Parts::of_factors);
            return Self { scene, parts, row_parts, rows, shared, beside_seams };
        }
        let mut is_by_stencil = vec![true; sites];
        all_rows.iter().for_each(|&site| is_by_stencil[site as usize] = false);
        beside_seams.sites().iter().for_each(|&site| is_by_stencil[site as usize] = true);
        let by_stencil = (0..).zip(is_by_stencil).filter_map(|(site, is)| is.then_some(site));
        let ratio = |material: &Material| scene.ratio(material);
        let parts = Parts::of_materials(problem, &scene.lattice, ratio, by_stencil);
        let row_parts = Parts::of_materials(problem, &scene.lattice, ratio, all_rows.into_iter());
        Self { scene, parts, row_parts, rows, shared, beside_seams }
    }

    /// The empty sites from the first that ends after `site` on.
    fn absent_from(&self, site: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let absent = &self.scene.absent;
        let next = absent.partition_point(|range| range.end as usize <= site);
        absent[next..].iter().map(|range| range.start as usize..range.end as usize)
    }

    /// The neighbours in the stencil of a site, whose part is looked for from `near` on.
    fn stencil_entries<'a>(
        &self,
        around: &'a Around,
        site: usize,
        near: &mut usize,
    ) -> Entries<'a> {
        around.entries(&self.scene.lattice, site, self.parts.at(site, near).factor)
    }

    /// Writes what the stencil does not describe at `sites`, but for rows beside seams; returns what held particles gave.
    fn rest(
        &self,
        seen: &mut Seen,
        now: &Now<'_>,
        sites: &Range<usize>,
        out: &mut [f64],
        written: Written<'_>,
    ) -> f64 {
        let near = self.absent_from(sites.start).take_while(|range| range.start < sites.end);
        for range in near.filter(|range| range.len() < GAP) {
            let (from, to) = (range.start.max(sites.start), range.end.min(sites.end));
            out[from - sites.start..to - sites.start].fill(0.0);
        }
        let (walls, linear) = (self.rows.sources().rank(), self.rows.sources().linear());
        let source = now.source.unwrap_or(&[]);
        if !(source.is_empty() && linear.is_empty()) {
            let of_row = |of: &[f64], row: usize| of.get(row).copied().unwrap_or(0.0);
            let mut parts = self.parts.from(sites.start, &mut seen.parts);
            for row in within_near(walls, sites, &mut seen.walls) {
                let site = walls[row] as usize;
                let rate = of_row(linear, row) * now.values[site] + of_row(source, row);
                out[site - sites.start] +=
                    parts.next(site).written(written).factor(now.values[site]) * rate;
            }
        }
        let Seen { shared, row_parts, .. } = seen;
        self.write_rows(&self.shared, [shared, row_parts], now, sites, out, written);
        let mut parts = self.row_parts.from(sites.start, &mut seen.row_parts);
        self.rows.rates(sites, &mut seen.rows, now.values, source, |site, rate| {
            out[site - sites.start] = parts.next(site).written(written).of(now.values[site], rate);
        });
        -self.rows.held_rate(sites, &mut seen.held, now.values)
    }

    /// Writes some rows that share lines at `sites`, where they and parts are looked for from `near` on.
    fn write_rows(
        &self,
        rows: &SharedRows,
        [near, near_parts]: [&mut usize; 2],
        now: &Now<'_>,
        sites: &Range<usize>,
        out: &mut [f64],
        written: Written<'_>,
    ) {
        let mut parts = self.row_parts.from(sites.start, near_parts);
        rows.rates(sites, near, now.values, |site, rate| {
            out[site - sites.start] = parts.next(site).written(written).of(now.values[site], rate);
        });
    }
}

impl LatticeOperator for Mixed {
    const PARTS: [usize; 3] = [1 << 15, 1 << 13, 1 << 12];
    const IS_STENCIL: bool = false;

    fn scene(&self) -> &LatticeScene {
        &self.scene.lattice
    }

    fn held(&self) -> &[u32] {
        self.rows.held_rank()
    }

    fn sources(&self) -> &SourceRows {
        self.rows.sources()
    }

    fn entries<'a>(&'a self, around: &'a Around, site: usize, near: &mut Near) -> Entries<'a> {
        let of_stencil = self.beside_seams.at(site, &mut near.beside_seams);
        if let Some(lines) = of_stencil.or_else(|| self.shared.at(site, &mut near.shared)) {
            return Entries::Lines(lines, 1.0);
        }
        if let Some((others, weights)) = self.rows.entries_of(site, &mut near.row) {
            return Entries::Row(others, weights);
        }
        self.stencil_entries(around, site, &mut near.part)
    }

    fn present(&self, sites: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let mut gaps = self.absent_from(sites.start).filter(|range| range.len() >= GAP);
        let mut site = sites.start;
        std::iter::from_fn(move || {
            while site < sites.end {
                let gap = gaps.next().unwrap_or(sites.end..sites.end);
                let range = site..gap.start.min(sites.end);
                site = gap.end;
                if !range.is_empty() {
                    return Some(range);
                }
            }
            None
        })
    }

    fn advance(
        &self,
        scratch: &mut Scratch,
        now: &Now<'_>,
        first: usize,
        out: &mut [f64],
        written: Written<'_>,
        beside_seams: BesideSeams,
    ) -> f64 {
        let end = first + out.len();
        // Empty sites keep the 0 that they start with.
        for Range { mut start, end } in self.present(first..end) {
            while start < end {
                let run = Run::starting(&self.scene.lattice, start, end - start);
                let out = &mut out[start - first..start - first + run.length];
                scratch.work(&self.scene.lattice, now.values, &run, &self.parts, written, out);
                start += run.length;
            }
        }
        let sites = first..end;
        if beside_seams == BesideSeams::ByRows {
            let Seen { beside_seams, row_parts, .. } = &mut scratch.seen;
            let near = [beside_seams, row_parts];
            self.write_rows(&self.beside_seams, near, now, &sites, out, written);
        }
        self.rest(&mut scratch.seen, now, &sites, out, written)
    }

    fn written_entries<'a>(&'a self, around: &'a Around, site: usize) -> Option<Entries<'a>> {
        self.beside_seams.at(site, &mut 0)?;
        Some(self.stencil_entries(around, site, &mut 0))
    }

    fn has_particle(&self, site: usize) -> bool {
        self.absent_from(site).next().is_none_or(|range| !range.contains(&site))
    }

    fn clear_absent(&self, first: usize, out: &mut [f64]) {
        let end = first + out.len();
        for range in self.absent_from(first).take_while(|range| range.start < end) {
            out[range.start.max(first) - first..range.end.min(end) - first].fill(0.0);
        }
    }

    fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![-1.0; self.scene.lattice.counts.iter().product()];
        let of_place = self.scene.lattice.diagonals();
        let mut absent = self.scene.absent.iter().flat_map(Range::clone).peekable();
        let mut parts = self.parts.from(0, &mut 0);
        for (site, diagonal) in diagonal.iter_mut().enumerate() {
            if absent.next_if_eq(&(site as u32)).is_none() {
                *diagonal = parts.next(site).factor * of_place(site);
            }
        }
        let sources = self.rows.sources();
        for (&site, linear) in sources.rank().iter().zip(sources.linear()) {
            diagonal[site as usize] += linear;
        }
        for rows in [&self.shared, &self.beside_seams] {
            rows.diagonals(|site, d| diagonal[site] = d);
        }
        self.rows.diagonals(|site, d| diagonal[site] = d);
        diagonal
    }

    fn memory_bytes(&self) -> usize {
        let shared = [&self.shared, &self.beside_seams].map(SharedRows::memory_bytes);
        let shared = shared.iter().sum::<usize>() + self.shared.bytes_of_lines();
        let rows = self.rows.memory_bytes() + shared;
        rows + self.parts.memory_bytes() + self.row_parts.memory_bytes() + self.scene.memory_bytes()
    }
}

#[cfg(test)]
#[path = "mixed_tests.rs"]
mod tests;
