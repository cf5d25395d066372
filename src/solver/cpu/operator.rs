//! What the CPU backend needs of an operator.

use std::ops::Range;

use super::CHUNK;
use super::enthalpy::Enthalpy;
use super::entries::{Entries, Lines, Near};
use super::partial_step::{PartialStep, WholeStep};
use super::written::Written;
use crate::model::operator::SourceRows;
use crate::model::wide::{self, Work, choose, multiply_add};

/// What is written at each place: `share` x value + a factor x rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Combine {
    pub(super) share: f64,
    /// The factor of values that are not above a limit, and of those that are.
    pub(super) factors: [f64; 2],
    /// The limit, which has the unit of the values.
    pub(super) limit: f64,
}

/// The rate alone.
pub(super) const RATE: Combine = Combine::new(0.0, 1.0);

impl Combine {
    /// With one factor for all.
    pub(super) const fn new(share: f64, factor: f64) -> Self {
        Self { share, factors: [factor; 2], limit: f64::INFINITY }
    }

    /// An explicit Euler step of `dt` (s).
    pub(super) fn step(dt: f64) -> Self {
        Self::new(1.0, dt)
    }

    /// The same where all rates are to be multiplied by a number.
    pub(super) fn times(self, by: f64) -> Self {
        Self { factors: self.factors.map(|factor| by * factor), ..self }
    }

    /// Whether the factor depends on the value.
    pub(super) fn has_two_factors(self) -> bool {
        self.factors[0] != self.factors[1]
    }

    /// How far the limit is above a value: of a value above it by its sign a negative number, which a choice takes as
    /// it is.
    #[inline(always)]
    pub(super) fn room(self, own: f64) -> f64 {
        self.limit - own
    }

    /// The factor at a value.
    #[inline(always)]
    pub(super) fn factor(self, own: f64) -> f64 {
        choose(self.room(own).is_sign_negative(), self.factors[1], self.factors[0])
    }

    /// What is written.
    #[inline(always)]
    pub(super) fn of(self, own: f64, rate: f64) -> f64 {
        self.share * own + self.factor(own) * rate
    }

    /// Writes it where rates are, which are in `out`.
    pub(super) fn write(self, own: &[f64], out: &mut [f64]) {
        if self == RATE {
            return;
        }
        wide::run(OfRates { combine: self, own, out });
    }

    /// The rate in what was written, and what is written without one.
    pub(super) fn rate_and_rest(self, own: f64, written: f64) -> [f64; 2] {
        let rest = self.share * own;
        [(written - rest) / self.factor(own), rest]
    }
}

/// See [`Combine::write`].
struct OfRates<'a> {
    combine: Combine,
    own: &'a [f64],
    out: &'a mut [f64],
}

impl Work for OfRates<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { combine, own, out } = self;
        for (out, &own) in out.iter_mut().zip(own) {
            *out = multiply_add::<FUSED>(combine.factor(own), *out, combine.share * own);
        }
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

    /// Whether places are sites of a lattice: many have neighbours as far away as others, in lines.
    fn has_lines(&self) -> bool {
        false
    }

    /// Which of [`Self::shared_lines`] go over the neighbours of the particle in a place, where this is known of all places.
    fn which_lines(&self, _place: usize) -> Option<u16> {
        None
    }

    /// Lines that places share.
    fn shared_lines(&self, _which: u16) -> Option<&Lines> {
        None
    }

    /// The neighbours of a place with the weights (1/s) that [`Self::step_enthalpy`] has of them before seams add to it,
    /// where those are not the weights of the matrix.
    fn written_entries(&self, _place: usize) -> Option<Entries<'_>> {
        None
    }

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

    /// Writes 0 where there is no particle among places from `first` on, which steps of potentials pass over.
    fn clear_absent(&self, _first: usize, _out: &mut [f64]) {}

    /// A_aa, 1/s; -1 for held particles and where there is none.
    fn diagonal(&self) -> Vec<f64>;

    /// Bytes that it holds.
    fn memory_bytes(&self) -> u64;
}

/// Parts at most of a step in which the operator writes everything first.
const PARTS: usize = 8;

/// A step of an enthalpy in which the operator writes everything first.
fn step_in_turn<O: CpuOperator + ?Sized>(
    operator: &O,
    now: &Now<'_>,
    out: &mut [f64],
    enthalpy: &mut Enthalpy,
    dt: f64,
) -> f64 {
    // What melts is looked at again in every part that it has neighbours in.
    let part = out.len().div_ceil(PARTS).max(CHUNK);
    let step = WholeStep::new(operator, now.values, dt, part, enthalpy.scene());
    // Rows are gone through once more where each curve has its own: they are far longer than what is written.
    let (at_once, later) = match step.written() {
        Written::Same(combine) => (combine, false),
        Written::Each(_) => (RATE, true),
    };
    let given = operator.apply(now, out, at_once);
    let take_on = |_: &mut (), step: &mut PartialStep<'_, O>, out: &mut [f64]| {
        if later {
            step.write_of_rates(out);
        }
        step.take_on(out, out.len(), 0.0);
    };
    given + step.take(1, enthalpy, out, || (), take_on)
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
