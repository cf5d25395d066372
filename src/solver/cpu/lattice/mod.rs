//! Lattices as an operator: a stencil, and nothing more but for the rows that need it. Places are sites.

mod kernel;
mod mixed;
mod uniform;

use rayon::prelude::*;

use super::enthalpy::Enthalpy;
use super::operator::{Combine, CpuOperator, Now, RATE, step_in_turn};
use crate::model::lattice::LatticeScene;
use crate::model::operator::SourceRows;

use kernel::Scratch;
pub(super) use mixed::Mixed;
pub(super) use uniform::Uniform;

/// Values that one parallel task works on, about: enough to be worth handing out.
const TASK: usize = 1 << 14;
/// Below this many particles one thread is faster than handing out tasks for every step.
const SERIAL: usize = 1 << 15;

/// A lattice with what it has beyond its stencil.
pub(super) trait LatticeOperator: Send + Sync {
    fn scene(&self) -> &LatticeScene;

    /// Sites of the held particles.
    fn held(&self) -> &[u32];

    /// The rows that walls act on, by site.
    fn sources(&self) -> &SourceRows;

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

/// A lattice that is worked on in parts.
pub(super) struct Lattice<L>(pub(super) L);

impl<L: LatticeOperator> Lattice<L> {
    /// Values of a task: whole lines, or a part of a line that is long.
    fn task(&self) -> usize {
        let nx = self.0.scene().counts[0];
        if nx < TASK { nx * (TASK / nx).max(1) } else { TASK }
    }
}

impl<L: LatticeOperator> CpuOperator for Lattice<L> {
    fn by_place(&self, values: &[f64]) -> Vec<f64> {
        self.0.scene().by_site(values)
    }

    fn by_particle(&self, values: &[f64]) -> Vec<f64> {
        self.0.scene().by_particle(values)
    }

    fn held(&self) -> &[u32] {
        self.0.held()
    }

    fn sources(&self) -> &SourceRows {
        self.0.sources()
    }

    fn apply(&self, now: &Now<'_>, out: &mut [f64], combine: Combine) -> f64 {
        let task = self.task();
        let scratch = || Scratch::new(self.0.scene());
        let advance = |scratch: &mut Scratch, (k, out): (usize, &mut [f64])| {
            self.0.advance(scratch, now, k * task, out, combine)
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
        self.0.clear_absent(0, out);
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
        let task = self.task();
        let (curves, values) = enthalpy.parts();
        let scratch = || Scratch::new(self.0.scene());
        let advance =
            |scratch: &mut Scratch, (k, (out, values)): (usize, (&mut [f64], &mut [f64]))| {
                let given = self.0.advance(scratch, now, k * task, out, RATE);
                self.0.clear_absent(k * task, out);
                curves.advance(k * task, values, out, dt);
                given
            };
        let given: Vec<f64> = if out.len() < SERIAL {
            let mut scratch = scratch();
            let parts = out.chunks_mut(task).zip(values.chunks_mut(task)).enumerate();
            parts.map(|part| advance(&mut scratch, part)).collect()
        } else {
            let parts = out.par_chunks_mut(task).zip(values.par_chunks_mut(task)).enumerate();
            parts.map_init(scratch, advance).collect()
        };
        given.iter().sum()
    }

    fn diagonal(&self) -> Vec<f64> {
        self.0.diagonal()
    }

    fn memory_bytes(&self) -> u64 {
        let order = self.0.scene().order.as_ref().map_or(0, |order| size_of_val(&**order));
        (order + self.0.memory_bytes()) as u64
    }
}
