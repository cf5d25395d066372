//! Lattices as an operator: a stencil, and nothing more but for the rows that need it. Places are sites.

mod kernel;
mod mixed;
mod uniform;

use rayon::prelude::*;

use super::enthalpy::Enthalpy;
use super::operator::{Combine, CpuOperator, Entries, Now, RATE, step_in_turn};
use crate::model::lattice::LatticeScene;
use crate::model::operator::SourceRows;

use kernel::Scratch;
pub(super) use mixed::Mixed;
pub(super) use uniform::Uniform;

/// Values that one parallel task works on, about: enough to be worth handing out.
const TASK: usize = 1 << 14;
/// Such tasks as one at most where something may melt, and the parts that are left at least.
const MOST_TASKS_AS_ONE: usize = 4;
const LEAST_PARTS: usize = 8;
/// Below this many particles one thread is faster than handing out tasks for every step.
const SERIAL: usize = 1 << 15;

/// A lattice with what it has beyond its stencil.
pub(super) trait LatticeOperator: Send + Sync {
    fn scene(&self) -> &LatticeScene;

    /// Sites of the held particles.
    fn held(&self) -> &[u32];

    /// The rows that walls act on, by site.
    fn sources(&self) -> &SourceRows;

    /// As [`CpuOperator::entries`]; `inner` are [`LatticeScene::inner_entries`].
    fn entries<'a>(&'a self, inner: &'a [(isize, f64)], site: usize) -> Entries<'a> {
        stencil_entries(self.scene(), inner, site, 1.0)
    }

    /// Writes what `combine` makes of values and rates from site `first` on, wherever that and the
    /// last are along their lines; returns what held particles among them gave, value x capacity / s.
    fn advance(
        &self,
        scratch: &mut Scratch,
        now: &Now<'_>,
        first: usize,
        out: &mut [f64],
        combine: Combine,
    ) -> f64;

    /// Writes 0 where there is no particle, from site `first` on.
    fn clear_absent(&self, _first: usize, _out: &mut [f64]) {}

    /// A_aa by site, 1/s; -1 for held particles and where there is none.
    fn diagonal(&self) -> Vec<f64>;

    /// Bytes that it holds, but for the order of the lattice.
    fn memory_bytes(&self) -> usize;
}

/// The stencil of `scene` around a site, with weights times `factor`; `inner` are its
/// [`LatticeScene::inner_entries`].
fn stencil_entries<'a>(
    scene: &LatticeScene,
    inner: &'a [(isize, f64)],
    site: usize,
    factor: f64,
) -> Entries<'a> {
    if scene.is_inner(site) {
        return Entries::Steps(inner, factor);
    }
    let mut found = Vec::with_capacity(inner.len());
    scene.entries(site, |other, weight| found.push((other, factor * weight)));
    Entries::Found(found)
}

/// A lattice that is worked on in parts.
pub(super) struct Lattice<L> {
    of: L,
    /// [`LatticeScene::inner_entries`].
    inner: Vec<(isize, f64)>,
}

impl<L: LatticeOperator> Lattice<L> {
    pub(super) fn new(of: L) -> Self {
        Self { inner: of.scene().inner_entries(), of }
    }

    /// Values of a task: whole lines, or a part of a line that is long.
    fn task(&self) -> usize {
        let nx = self.of.scene().counts[0];
        if nx < TASK { nx * (TASK / nx).max(1) } else { TASK }
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

    fn entries(&self, place: usize) -> Entries<'_> {
        self.of.entries(&self.inner, place)
    }

    fn reach(&self) -> usize {
        self.of.scene().longest_step()
    }

    fn apply(&self, now: &Now<'_>, out: &mut [f64], combine: Combine) -> f64 {
        let task = self.task();
        let scratch = || Scratch::new(self.of.scene());
        let advance = |scratch: &mut Scratch, (k, out): (usize, &mut [f64])| {
            self.of.advance(scratch, now, k * task, out, combine)
        };
        let given: Vec<f64> = if out.len() < SERIAL {
            let mut scratch = scratch();
            out.chunks_mut(task).enumerate().map(|part| advance(&mut scratch, part)).collect()
        } else {
            out.par_chunks_mut(task).enumerate().map_init(scratch, advance).collect()
        };
        given.iter().sum()
    }

    fn clear_absent(&self, out: &mut [f64]) {
        self.of.clear_absent(0, out);
    }

    /// Each part while it is in the cache: enthalpy costs little more than reading and writing it.
    fn step_enthalpy(
        &self,
        now: &Now<'_>,
        out: &mut [f64],
        enthalpy: &mut Enthalpy,
        dt: f64,
    ) -> f64 {
        if enthalpy.has_seams() {
            return step_in_turn(self, now, out, enthalpy, dt);
        }
        let melting = enthalpy.melting();
        // What melts is looked at again in every part that it has neighbours in.
        let task = self.task();
        let task = task * (out.len() / task / LEAST_PARTS).clamp(1, MOST_TASKS_AS_ONE);
        let (curves, fronts, values) = enthalpy.parts();
        let scratch = || Scratch::new(self.of.scene());
        let advance =
            |scratch: &mut Scratch, (k, (out, values)): (usize, (&mut [f64], &mut [f64]))| {
                let mut given = self.of.advance(scratch, now, k * task, out, RATE);
                self.of.clear_absent(k * task, out);
                if let Some((fronts, melting)) = fronts.zip(melting.as_ref()) {
                    given += fronts.add(melting, self, now.values, k * task, out);
                }
                curves.advance(k * task, values, out, dt);
                (given, fronts.map(|fronts| fronts.among(k * task, values)).unwrap_or_default())
            };
        let parts: Vec<(f64, Vec<u32>)> = if out.len() < SERIAL {
            let mut scratch = scratch();
            let parts = out.chunks_mut(task).zip(values.chunks_mut(task)).enumerate();
            parts.map(|part| advance(&mut scratch, part)).collect()
        } else {
            let parts = out.par_chunks_mut(task).zip(values.par_chunks_mut(task)).enumerate();
            parts.map_init(scratch, advance).collect()
        };
        let given = parts.iter().map(|(given, _)| given).sum();
        enthalpy.set_melting(parts.into_iter().flat_map(|(_, melting)| melting).collect());
        given
    }

    fn diagonal(&self) -> Vec<f64> {
        self.of.diagonal()
    }

    fn memory_bytes(&self) -> u64 {
        let order = self.of.scene().order.as_ref().map_or(0, |order| size_of_val(&**order));
        (order + self.of.memory_bytes()) as u64
    }
}
