//! Lattices as an operator: a stencil, and nothing more but for the rows that need it. Places are sites.

mod around;
mod kernel;
mod mixed;
mod parts;
mod shared_rows;
mod uniform;

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::enthalpy::Enthalpy;
use super::entries::{Entries, Lines, Near};
use super::operator::{Combine, CpuOperator, Now};
use super::partial_step::{PartialStep, SERIAL, WholeStep};
use super::written::Written;
use crate::model::lattice::LatticeScene;
use crate::model::operator::SourceRows;

use around::Around;
use kernel::Scratch;
pub(super) use mixed::Mixed;
pub(super) use uniform::Uniform;

/// Values that one parallel task works on, about: enough to be worth handing out.
const TASK: usize = 1 << 14;
/// Tasks of an enthalpy's step that a thread gets at most.
const TASKS: usize = 4;
/// What melts is looked at in every task that it has neighbours in: tasks of so many times as many places as neighbours
/// are away, at least, unless threads would have none.
const REACHES: usize = 8;

/// What writes rows that are the stencil's but for pairs at [seams](crate::model::operator::Seams).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BesideSeams {
    /// These rows.
    ByRows,
    /// The stencil: seams add to what [`LatticeOperator::written_entries`] tell then.
    ByStencil,
}

/// A lattice with what it has beyond its stencil.
pub(super) trait LatticeOperator: Send + Sync {
    /// Values of a task that are taken on together, about, in one, two and three dimensions: they and what the
    /// stencil reads stay in the fastest caches, and looking for exceptions among them costs little.
    const PARTS: [usize; 3];

    /// Whether all particles have the neighbours and the weights of the stencil: no rows, no factors.
    const IS_STENCIL: bool;

    fn scene(&self) -> &LatticeScene;

    /// Sites of the held particles.
    fn held(&self) -> &[u32];

    /// The rows that walls act on, by site.
    fn sources(&self) -> &SourceRows;

    /// As [`CpuOperator::entries`], where the stencil has what is `around`.
    fn entries<'a>(&'a self, around: &'a Around, site: usize, _near: &mut Near) -> Entries<'a> {
        around.entries(self.scene(), site, 1.0)
    }

    /// Writes what `written` makes of values and rates from site `first` on, wherever that and the
    /// last are along their lines; returns what held particles among them gave, value x capacity / s.
    fn advance(
        &self,
        scratch: &mut Scratch,
        now: &Now<'_>,
        first: usize,
        out: &mut [f64],
        written: Written<'_>,
        beside_seams: BesideSeams,
    ) -> f64;

    /// As [`CpuOperator::written_entries`], where the stencil has what is `around`.
    fn written_entries<'a>(&'a self, _around: &'a Around, _site: usize) -> Option<Entries<'a>> {
        None
    }

    /// The parts of `sites` that are worked on, ascending: there are particles nowhere else.
    fn present(&self, sites: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        [sites].into_iter()
    }

    /// Whether there is a particle at a site.
    fn has_particle(&self, _site: usize) -> bool {
        true
    }

    /// Writes 0 where there is no particle among sites from `first` on.
    fn clear_absent(&self, _first: usize, _out: &mut [f64]) {}

    /// A_aa by site, 1/s; -1 for held particles and where there is none.
    fn diagonal(&self) -> Vec<f64>;

    /// Bytes that it holds, but for the order of the lattice.
    fn memory_bytes(&self) -> usize;
}

/// A lattice that is worked on in parts.
pub(super) struct Lattice<L> {
    of: L,
    /// What is around the sites, for what needs it.
    around: OnceLock<Around>,
}

impl<L: LatticeOperator> Lattice<L> {
    pub(super) fn new(of: L) -> Self {
        Self { of, around: OnceLock::new() }
    }

    #[inline(always)]
    fn around(&self) -> &Around {
        self.around.get_or_init(|| Around::of(self.of.scene()))
    }

    /// Values of whole lines, or of a part of a line that is long: `most`, or a line at least.
    fn lines(&self, most: usize) -> usize {
        let nx = self.of.scene().counts[0];
        if nx < most { nx * (most / nx) } else { most }
    }

    /// Into how many tasks an enthalpy's step of so many places is divided: as many for each thread, where there are
    /// enough.
    fn tasks(&self, places: usize) -> usize {
        if places < SERIAL {
            return 1;
        }
        let threads = rayon::current_num_threads();
        let most = places / (TASK / 2).max(REACHES * self.reach());
        match most / threads {
            0 => most.max(places / TASK).clamp(1, threads),
            of_each => threads * of_each.min(TASKS),
        }
    }
}

impl<L: LatticeOperator> CpuOperator for Lattice<L> {
    fn by_place(&self, values: &[f64]) -> Vec<f64> {
        self.of.scene().by_site(values)
    }

    fn by_particle(&self, values: &[f64]) -> Vec<f64> {
        self.of.scene().by_particle(values)
    }

    fn held(&self) -> &[u32] {
        self.of.held()
    }

    fn sources(&self) -> &SourceRows {
        self.of.sources()
    }

    fn entries(&self, place: usize, near: &mut Near) -> Entries<'_> {
        self.of.entries(self.around(), place, near)
    }

    fn has_lines(&self) -> bool {
        true
    }

    fn which_lines(&self, place: usize) -> Option<u16> {
        L::IS_STENCIL.then(|| self.around().which(self.of.scene(), place) as u16)
    }

    #[inline(always)]
    fn shared_lines(&self, which: u16) -> Option<&Lines> {
        self.around().lines().get(usize::from(which))
    }

    fn written_entries(&self, place: usize) -> Option<Entries<'_>> {
        self.of.written_entries(self.around(), place)
    }

    fn reach(&self) -> usize {
        self.of.scene().longest_step()
    }

    fn apply(&self, now: &Now<'_>, out: &mut [f64], combine: Combine) -> f64 {
        let task = self.lines(TASK);
        let scratch = || Scratch::new(self.of.scene());
        let advance = |scratch: &mut Scratch, (k, out): (usize, &mut [f64])| {
            let written = Written::Same(combine);
            self.of.advance(scratch, now, k * task, out, written, BesideSeams::ByRows)
        };
        let given: Vec<f64> = if out.len() < SERIAL {
            let mut scratch = scratch();
            out.chunks_mut(task).enumerate().map(|part| advance(&mut scratch, part)).collect()
        } else {
            out.par_chunks_mut(task).enumerate().map_init(scratch, advance).collect()
        };
        given.iter().sum()
    }

    fn clear_absent(&self, first: usize, out: &mut [f64]) {
        self.of.clear_absent(first, out);
    }

    /// Each part while it is in the cache: enthalpy costs little more than its arithmetic.
    fn step_enthalpy(
        &self,
        now: &Now<'_>,
        out: &mut [f64],
        enthalpy: &mut Enthalpy,
        dt: f64,
    ) -> f64 {
        let (nx, dimension) = (self.of.scene().counts[0], self.of.scene().dimension);
        let part = L::PARTS[dimension - 1];
        let part = self.lines(if nx > TASK { part } else { part.max(nx) });
        let parts = out.len().div_ceil(part).div_ceil(self.tasks(out.len()));
        let scratch = || Scratch::new(self.of.scene());
        let whole = WholeStep::new(self, now.values, dt, part, enthalpy.scene());
        let written = whole.written();
        let step = |scratch: &mut Scratch, step: &mut PartialStep<'_, Self>, out: &mut [f64]| {
            let first = step.places().start;
            for known in (0..out.len()).step_by(part) {
                let next = (known + part).min(out.len());
                step.fetch(next - known);
                let of_part = &mut out[known..next];
                let given = self.of.advance(
                    scratch,
                    now,
                    first + known,
                    of_part,
                    written,
                    BesideSeams::ByStencil,
                );
                step.take_on(out, next, given);
            }
        };
        whole.take(parts, enthalpy, out, scratch, step)
    }

    fn has_particle(&self, place: usize) -> bool {
        self.of.has_particle(place)
    }

    fn for_each_present(&self, places: Range<usize>, visit: &mut dyn FnMut(Range<usize>)) {
        self.of.present(places).for_each(visit);
    }

    fn diagonal(&self) -> Vec<f64> {
        self.of.diagonal()
    }

    fn memory_bytes(&self) -> u64 {
        let order = self.of.scene().order.as_ref().map_or(0, |order| size_of_val(&**order));
        (order + self.of.memory_bytes()) as u64
    }
}
