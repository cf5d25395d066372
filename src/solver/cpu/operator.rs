//! What the CPU backend needs of an operator.

use std::ops::Range;

use super::CHUNK;
use super::enthalpy::Enthalpy;
use super::entries::{Entries, Near};
use super::partial_step::{PartialStep, WholeStep};
use crate::model::operator::SourceRows;

/// What is written at each place: `share` x value + `scale` x rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Combine {
    pub(super) share: f64,
    pub(super) scale: f64,
}

/// The rate alone.
pub(super) const RATE: Combine = Combine { share: 0.0, scale: 1.0 };

impl Combine {
    /// An explicit Euler step of `dt` (s).
    pub(super) fn step(dt: f64) -> Self {
        Self { share: 1.0, scale: dt }
    }
}

/// What rates are of.
#[derive(Clone, Copy)]
pub(super) struct Now<'a> {
    pub(super) values: &'a [f64],
    /// Source of the rows of walls, 1/s x value; none of a change.
    pub(super) source: Option<&'a [f64]>,
}

impl<'a> Now<'a> {
    /// A state.
    pub(super) fn state(values: &'a [f64], source: &'a [f64]) -> Self {
        Self { values, source: Some(source) }
    }

    /// A change of a state, which is 0 for held particles: walls impose nothing on it.
    pub(super) fn change(values: &'a [f64]) -> Self {
        Self { values, source: None }
    }
}

/// An operator in memory, with values in an order of its own.
pub(super) trait CpuOperator: Send + Sync {
    /// From the problem's order; 0 where there is no particle.
    fn by_place(&self, values: &[f64]) -> Vec<f64>;

    /// To the problem's order.
    fn by_particle(&self, values: &[f64]) -> Vec<f64>;

    /// Places of the held particles.
    fn held(&self) -> &[u32];

    /// The rows that walls act on.
    fn sources(&self) -> &SourceRows;

    /// The neighbours of the particle in a place, looked up from `near` on. Of a held particle, or where there is
    /// none, they mean nothing.
    fn entries(&self, place: usize, near: &mut Near) -> Entries<'_>;

    /// How many places a neighbour is away at most, round the ends of periodic axes.
    fn reach(&self) -> usize;

    /// Writes what `combine` makes of values and rates, where held particles have the rate 0; returns
    /// what these gave, value x capacity / s.
    fn apply(&self, now: &Now<'_>, out: &mut [f64], combine: Combine) -> f64;

    /// Takes `enthalpy` a step of `dt` (s) on, with what seams and fronts change of the rates: writes the potentials
    /// after it; returns what held particles gave, value x capacity / s.
    fn step_enthalpy(
        &self,
        now: &Now<'_>,
        out: &mut [f64],
        enthalpy: &mut Enthalpy,
        dt: f64,
    ) -> f64 {
        step_in_turn(self, now, out, enthalpy, dt)
    }

    /// Whether there is a particle in a place.
    fn has_particle(&self, _place: usize) -> bool {
        true
    }

    /// Calls `visit` with the parts of `places` where there may be particles, ascending.
    fn for_each_present(&self, places: Range<usize>, visit: &mut dyn FnMut(Range<usize>)) {
        visit(places);
    }

    /// Writes 0 where there is no particle among places from `first` on: steps of potentials leave it.
    fn clear_absent(&self, _first: usize, _out: &mut [f64]) {}

    /// A_aa, 1/s; -1 for held particles and where there is none.
    fn diagonal(&self) -> Vec<f64>;

    /// Bytes that it holds.
    fn memory_bytes(&self) -> u64;
}

/// Parts at most of a step that finds all rates first.
const PARTS: usize = 8;

/// A step of an enthalpy that finds all rates first.
fn step_in_turn<O: CpuOperator + ?Sized>(
    operator: &O,
    now: &Now<'_>,
    out: &mut [f64],
    enthalpy: &mut Enthalpy,
    dt: f64,
) -> f64 {
    let given = operator.apply(now, out, RATE);
    // What melts is looked at again in every part that it has neighbours in; a sum over parts must not depend on
    // the number of threads.
    let task = out.len().div_ceil(PARTS).max(CHUNK);
    let step = WholeStep { operator, now: now.values, dt, task };
    let take_on = |_: &mut (), step: &mut PartialStep<'_, O>, out: &mut [f64]| {
        step.take_on(out, out.len());
        0.0
    };
    given + step.take(enthalpy, out, || (), take_on)
}

/// As [`CpuOperator::apply`]; returns what walls gave as well.
pub(super) fn apply(
    operator: &dyn CpuOperator,
    now: &Now<'_>,
    out: &mut [f64],
    combine: Combine,
) -> f64 {
    operator.apply(now, out, combine) + operator.sources().inflow(now.values, now.source)
}

/// As [`CpuOperator::step_enthalpy`]; returns what walls gave as well.
pub(super) fn step_enthalpy(
    operator: &dyn CpuOperator,
    now: &Now<'_>,
    out: &mut [f64],
    enthalpy: &mut Enthalpy,
    dt: f64,
) -> f64 {
    let through_walls = operator.sources().inflow(now.values, now.source);
    operator.step_enthalpy(now, out, enthalpy, dt) + through_walls
}
