//! The flows of melting particles, in loops that a processor runs on several values at once.

use std::ops::Range;

use super::FrontFlows;
use crate::model::wide::{Work, multiply_add, sum_of};
use crate::solver::cpu::entries::{Entries, LANES, Lines, Near};
use crate::solver::cpu::latent::Latent;
use crate::solver::cpu::operator::{Combine, CpuOperator};

/// Particles that are worked on together.
const FEW: usize = 16;

/// Adds what flows to and from some latent particles beside what the operator has of it. Held particles do not melt:
/// at the melting point they are solid.
pub(in crate::solver::cpu) struct Add<'a, O: ?Sized> {
    pub(in crate::solver::cpu) of: &'a FrontFlows,
    pub(in crate::solver::cpu) latent: &'a Latent,
    pub(in crate::solver::cpu) which: Range<usize>,
    pub(in crate::solver::cpu) operator: &'a O,
    pub(in crate::solver::cpu) potentials: &'a [f64],
    /// What is made of rates.
    pub(in crate::solver::cpu) written: Combine,
    /// The places where that is here.
    pub(in crate::solver::cpu) own: Range<usize>,
    pub(in crate::solver::cpu) out: &'a mut [f64],
}

/// What flows to a melting particle beside what the operator has of it, as what is made of rates changes.
#[derive(Clone, Copy, Default)]
struct Flow {
    /// Of the particle, K.
    potential: f64,
    /// From a solid neighbour, and from a liquid one: how many times weight and difference are taken from what is
    /// written of it.
    solid: f64,
    liquid: f64,
    /// How many times more the particle gains of the latter.
    more: f64,
}

impl Flow {
    /// That of a particle with an enthalpy (K) in a place: nothing if it does not melt.
    #[inline(always)]
    fn of(fronts: &FrontFlows, written: Combine, place: usize, enthalpy: f64) -> Self {
        match fronts.front(place) {
            Some(front) if front.is_in(enthalpy) => {
                let [liquid, solid] = fronts.fronts.excess(front, enthalpy);
                let [of_solid, of_liquid] = written.factors;
                // What melts is not above where it does.
                let more = (of_solid - of_liquid) * liquid;
                let (solid, liquid) = (of_solid * solid, of_liquid * liquid);
                Self { potential: front.potential, solid, liquid, more }
            }
            _ => Self::default(),
        }
    }

    #[inline(always)]
    fn is_none(self) -> bool {
        self.solid == 0.0 && self.liquid == 0.0
    }

    /// That where all weights are to be multiplied by a factor.
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        let Self { potential, solid, liquid, more } = self;
        Self { potential, solid: factor * solid, liquid: factor * liquid, more: factor * more }
    }

    /// What is taken from a neighbour of some potential and weight, and how much of that is liquid, times weight and
    /// difference. What melts too has the same potential, and gives nothing.
    #[inline(always)]
    fn from<const FUSED: bool>(self, other: f64, weight: f64) -> [f64; 2] {
        let above = other - self.potential;
        let of_solid = weight * if above < 0.0 { above } else { 0.0 };
        let of_liquid = weight * if above > 0.0 { above } else { 0.0 };
        [multiply_add::<FUSED>(self.solid, of_solid, self.liquid * of_liquid), of_liquid]
    }
}

/// What a particle gains, in parts that are added together at last.
#[derive(Clone, Copy, Default)]
struct Gain {
    taken: [f64; LANES],
    of_liquid: [f64; LANES],
}

impl Gain {
    /// All of it.
    #[inline(always)]
    fn sum(&self, flow: Flow) -> f64 {
        sum_of(self.taken) + flow.more * sum_of(self.of_liquid)
    }
}

impl<O: CpuOperator + ?Sized> Work for Add<'_, O> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { of, latent, which, operator, potentials, written, own, out } = self;
        let (places, enthalpies) = (&latent.places()[which.clone()], &latent.enthalpies()[which]);
        let mut near = Near::default();
        for (places, enthalpies) in places.chunks(FEW).zip(enthalpies.chunks(FEW)) {
            // All before any is needed, since a processor divides several at once.
            let mut flows = [Flow::default(); FEW];
            for ((flow, &place), &enthalpy) in flows.iter_mut().zip(places).zip(enthalpies) {
                *flow = Flow::of(of, written, place as usize, enthalpy);
            }
            let mut gains = [Gain::default(); FEW];
            for ((&place, flow), gain) in places.iter().zip(&mut flows).zip(&mut gains) {
                if flow.is_none() {
                    continue;
                }
                let place = place as usize;
                let mut add = |other: usize, weight: f64| {
                    let Some(ratio) = of.ratio(place, other) else {
                        return;
                    };
                    let [taken, of_liquid] = flow.from::<FUSED>(potentials[other], weight);
                    gain.taken[0] += taken;
                    gain.of_liquid[0] += of_liquid;
                    if let Some(out) = out.get_mut(other.wrapping_sub(own.start)) {
                        *out -= taken * ratio;
                    }
                };
                let (entries, are_alike) = of.entries(place, operator, &mut near);
                match entries {
                    Entries::Lines(lines, factor) => {
                        let start = lines.start(place);
                        match potentials.get(start..start + lines.span()) {
                            Some(around) if are_alike => {
                                *flow = flow.times(factor);
                                let first = start.wrapping_sub(own.start);
                                let is_own = own.contains(&place);
                                *gain = along::<FUSED>(lines, *flow, around, first, is_own, out);
                            }
                            _ => lines.for_each(place, |other, weight| add(other, factor * weight)),
                        }
                    }
                    Entries::Row(others, weights) => {
                        let entries = others.iter().zip(weights);
                        entries.for_each(|(&other, &weight)| add(other as usize, weight));
                    }
                }
            }
            for ((&place, flow), gain) in places.iter().zip(&flows).zip(&gains) {
                if let Some(out) = out.get_mut((place as usize).wrapping_sub(own.start)) {
                    *out += gain.sum(*flow);
                }
            }
        }
    }
}

/// Takes the flows from all of `lines`, whose potentials are in `around` from the first to the last, from what is in
/// `out` of these as far as they are there, where the first line begins at `first`; returns what the particle gains if
/// it `is_own`: there, what lies beyond counts too.
#[inline(always)]
fn along<const FUSED: bool>(
    lines: &Lines,
    flow: Flow,
    around: &[f64],
    first: usize,
    is_own: bool,
    out: &mut [f64],
) -> Gain {
    let mut gain = Gain::default();
    let count = out.len();
    for (ahead, weights) in lines.all() {
        let to = first.wrapping_add(*ahead);
        let there = out.get_mut(to..to.wrapping_add(LANES));
        if there.is_none() && !is_own && is_beyond(to, count) {
            continue;
        }
        let others: &[f64; LANES] =
            around[*ahead..*ahead + LANES].try_into().expect("a line's length");
        let (mut taken, mut of_liquid) = ([0.0; LANES], [0.0; LANES]);
        for x in 0..LANES {
            [taken[x], of_liquid[x]] = flow.from::<FUSED>(others[x], weights[x]);
        }
        match there {
            Some(out) => {
                for x in 0..LANES {
                    out[x] -= taken[x];
                }
            }
            None if is_beyond(to, count) => {}
            None => take_some(&taken, to, out),
        }
        for x in 0..LANES {
            gain.taken[x] += taken[x];
            gain.of_liquid[x] += of_liquid[x];
        }
    }
    gain
}

/// Whether a line that begins at `first` of so many places has nothing in common with them.
#[inline(always)]
fn is_beyond(first: usize, count: usize) -> bool {
    // What begins before the first has wrapped around.
    first >= count && first.wrapping_add(LANES - 1) >= count
}

/// Takes what is `taken` along a line that begins at `first` of `out` from this, as far as it is there.
#[inline(always)]
fn take_some(taken: &[f64; LANES], first: usize, out: &mut [f64]) {
    for (x, taken) in taken.iter().enumerate() {
        if let Some(out) = out.get_mut(first.wrapping_add(x)) {
            *out -= taken;
        }
    }
}
