//! Scenes that a stencil describes in part: it goes over all sites, and what it does not describe is
//! written again.

use std::ops::Range;
use std::sync::Arc;

use super::LatticeOperator;
use super::around::Around;
use super::kernel::{Part, Run, Scratch, Seen};
use super::shared_rows::SharedRows;
use crate::model::lattice::{LatticeScene, MixedScene};
use crate::model::operator::{SomeRows, SourceRows, seek, within_near};
use crate::solver::cpu::entries::{Entries, Near};
use crate::solver::cpu::operator::{Combine, Now};

/// Empty sites in a row that are passed over: fewer are worked on together with what lies around
/// them, since a short part of a line costs as much as a long one.
const GAP: usize = 128;

/// A scene with rows where its stencil does not hold.
pub(in crate::solver::cpu) struct Mixed {
    scene: Arc<MixedScene>,
    rows: SomeRows,
    /// Those that were among them and share lines.
    shared: SharedRows,
}

impl Mixed {
    pub(in crate::solver::cpu) fn new(scene: Arc<MixedScene>, mut rows: SomeRows) -> Self {
        let shared = SharedRows::take_from(&mut rows, scene.lattice.counts.iter().product());
        Self { scene, rows, shared }
    }

    /// The empty sites from the first that ends after `site` on.
    fn absent_from(&self, site: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let absent = &self.scene.absent;
        let next = absent.partition_point(|range| range.end as usize <= site);
        absent[next..].iter().map(|range| range.start as usize..range.end as usize)
    }

    /// Writes a run by the stencil, each part of it with its own factor.
    fn stencil(
        &self,
        scratch: &mut Scratch,
        now: &Now<'_>,
        run: &Run,
        out: &mut [f64],
        combine: Combine,
    ) {
        let sites = run.first..run.first + run.length;
        let ratios = &self.scene.ratios;
        let start = |k: usize| ratios.get(k).map_or(usize::MAX, |&(first, _)| first as usize);
        let seen = &mut scratch.seen.parts;
        *seen = seek(ratios, *seen, |&(first, _)| first as usize <= sites.start);
        let factor_before = |next: usize| if next > 0 { ratios[next - 1].1 } else { 1.0 };
        let first = *seen;
        let mut parts = std::mem::take(&mut scratch.parts);
        parts.clear();
        for next in first.. {
            let end = start(next).min(sites.end) - sites.start;
            parts.push(Part { end, combine: combine.times(factor_before(next)) });
            if end == run.length {
                break;
            }
        }
        scratch.work_in_parts(&self.scene.lattice, now.values, run, &parts, out);
        scratch.parts = parts;
    }

    /// Writes what the stencil does not describe at `sites`; returns what held particles gave.
    fn rest(
        &self,
        seen: &mut Seen,
        now: &Now<'_>,
        sites: &Range<usize>,
        out: &mut [f64],
        combine: Combine,
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
            for row in within_near(walls, sites, &mut seen.walls) {
                let site = walls[row] as usize;
                let rate = of_row(linear, row) * now.values[site] + of_row(source, row);
                out[site - sites.start] += combine.factor(now.values[site]) * rate;
            }
        }
        let mut write = |site: usize, rate: f64| {
            out[site - sites.start] = combine.of(now.values[site], rate);
        };
        self.shared.rates(sites, &mut seen.shared, now.values, &mut write);
        self.rows.rates(sites, &mut seen.rows, now.values, source, write);
        -self.rows.held_rate(sites, &mut seen.held, now.values)
    }
}

impl LatticeOperator for Mixed {
    const PARTS: [usize; 3] = [1 << 15, 1 << 13, 1 << 11];

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
        if let Some(lines) = self.shared.at(site, &mut near.shared) {
            return Entries::Lines(lines, 1.0);
        }
        if let Some((others, weights)) = self.rows.entries_of(site, &mut near.row) {
            return Entries::Row(others, weights);
        }
        let ratios = &self.scene.ratios;
        near.part = seek(ratios, near.part, |&(first, _)| first as usize <= site);
        let factor = if near.part > 0 { ratios[near.part - 1].1 } else { 1.0 };
        around.entries(&self.scene.lattice, site, factor)
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
        combine: Combine,
    ) -> f64 {
        let end = first + out.len();
        // Empty sites keep the 0 that they start with.
        for Range { mut start, end } in self.present(first..end) {
            while start < end {
                let run = Run::starting(&self.scene.lattice, start, end - start);
                let out = &mut out[start - first..start - first + run.length];
                self.stencil(scratch, now, &run, out, combine);
                start += run.length;
            }
        }
        self.rest(&mut scratch.seen, now, &(first..end), out, combine)
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
        let mut part = 0;
        for (site, diagonal) in diagonal.iter_mut().enumerate() {
            let next = self.scene.ratios.get(part);
            part += usize::from(next.is_some_and(|&(first, _)| first as usize == site));
            if absent.next_if_eq(&(site as u32)).is_none() {
                *diagonal =
                    if part > 0 { self.scene.ratios[part - 1].1 } else { 1.0 } * of_place(site);
            }
        }
        let sources = self.rows.sources();
        for (&site, linear) in sources.rank().iter().zip(sources.linear()) {
            diagonal[site as usize] += linear;
        }
        self.shared.diagonals(|site, d| diagonal[site] = d);
        self.rows.diagonals(|site, d| diagonal[site] = d);
        diagonal
    }

    fn memory_bytes(&self) -> usize {
        self.rows.memory_bytes() + self.shared.memory_bytes() + self.scene.memory_bytes()
    }
}
