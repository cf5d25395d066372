//! What the CPU backend needs of an operator.

use std::ops::Range;

use super::enthalpy::Enthalpy;
use crate::model::operator::SourceRows;

/// What is written at each place: `share` x value + `scale` x rate.
#[derive(Clone, Copy, Debug)]
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

/// The neighbours of a particle with their weights, 1/s; what walls add to weights is part of them.
pub(super) enum Entries<'a> {
    /// So many places from its own, ascending, and all weights times a factor.
    Steps(&'a [(isize, f64)], f64),
    /// Places and weights.
    Row(&'a [u32], &'a [f64]),
    /// Both; some may come more than once.
    Found(Vec<(usize, f64)>),
}

impl Entries<'_> {
    /// Those in `places` at least, of the particle in a place.
    #[inline(always)]
    pub(super) fn within(self, place: usize, places: &Range<usize>) -> Self {
        match self {
            Self::Steps(steps, factor) => {
                let from = |bound: usize| {
                    let step = bound.wrapping_sub(place) as isize;
                    steps.partition_point(|&(other, _)| other < step)
                };
                Self::Steps(&steps[from(places.start)..from(places.end)], factor)
            }
            all => all,
        }
    }

    /// Calls `visit(b, w_ab)` for those of the particle in a place.
    #[inline(always)]
    pub(super) fn for_each(&self, place: usize, mut visit: impl FnMut(usize, f64)) {
        match self {
            Self::Steps(steps, factor) => {
                for &(step, weight) in *steps {
                    visit(place.wrapping_add_signed(step), factor * weight);
                }
            }
            Self::Row(others, weights) => {
                for (&other, &weight) in others.iter().zip(*weights) {
                    visit(other as usize, weight);
                }
            }
            Self::Found(found) => found.iter().for_each(|&(other, weight)| visit(other, weight)),
        }
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

    /// The neighbours of the particle in a place, which is not held.
    fn entries(&self, place: usize) -> Entries<'_>;

    /// How many places a neighbour is away at most, round the ends of periodic axes.
    fn reach(&self) -> usize;

    /// Writes what `combine` makes of values and rates, where held particles have the rate 0; returns
    /// what these gave, value x capacity / s.
    fn apply(&self, now: &Now<'_>, out: &mut [f64], combine: Combine) -> f64;

    /// Adds `dt` (s) times the rates to `enthalpy`, with what fronts change of them, and writes the potentials that
    /// come of it; returns what held particles gave, value x capacity / s.
    fn step_enthalpy(
        &self,
        now: &Now<'_>,
        out: &mut [f64],
        enthalpy: &mut Enthalpy,
        dt: f64,
    ) -> f64 {
        step_in_turn(self, now, out, enthalpy, dt)
    }

    /// Writes 0 where there is no particle.
    fn clear_absent(&self, _out: &mut [f64]) {}

    /// A_aa, 1/s; -1 for held particles and where there is none.
    fn diagonal(&self) -> Vec<f64>;

    /// Bytes that it holds.
    fn memory_bytes(&self) -> u64;
}

/// A step of an enthalpy that finds all rates first.
pub(super) fn step_in_turn<O: CpuOperator + ?Sized>(
    operator: &O,
    now: &Now<'_>,
    out: &mut [f64],
    enthalpy: &mut Enthalpy,
    dt: f64,
) -> f64 {
    let mut given = operator.apply(now, out, RATE) + enthalpy.add_seams(out);
    operator.clear_absent(out);
    if let Some(melting) = enthalpy.melting() {
        given += enthalpy.add_fronts(&melting, operator, now.values, out);
    }
    enthalpy.advance(out, dt);
    given
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
