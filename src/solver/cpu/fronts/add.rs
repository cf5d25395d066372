//! The flows of melting particles, in loops that a processor runs on several values at once.

use std::ops::Range;

use super::FrontFlows;
use crate::model::wide::{Work, choose};
use crate::solver::cpu::entries::{Entries, LANES, Lines, Near};
use crate::solver::cpu::latent::Latent;
use crate::solver::cpu::operator::CpuOperator;

/// Adds the flows of some latent particles.
pub(super) struct Add<'a, O: ?Sized> {
    pub(super) of: &'a FrontFlows,
    pub(super) latent: &'a Latent,
    pub(super) which: Range<usize>,
    pub(super) operator: &'a O,
    pub(super) potentials: &'a [f64],
    /// The places whose rates are here.
    pub(super) own: Range<usize>,
    pub(super) rates: &'a mut [f64],
}

/// Potential of a melting particle, and how much more than the operator has of it flows to a liquid and to a solid
/// neighbour, in parts.
#[derive(Clone, Copy, Default)]
struct Flow {
    potential: f64,
    to_liquid: f64,
    to_solid: f64,
}

impl Flow {
    /// That of a particle with an enthalpy (K) in a place: nothing if it does not melt.
    #[inline(always)]
    fn of(fronts: &FrontFlows, place: usize, enthalpy: f64) -> Self {
        match fronts.front(place) {
            Some(front) if front.is_in(enthalpy) => {
                let [to_liquid, to_solid] = fronts.fronts.excess(front, enthalpy);
                Self { potential: front.potential, to_liquid, to_solid }
            }
            _ => Self::default(),
        }
    }

    #[inline(always)]
    fn is_none(self) -> bool {
        self.to_liquid == 0.0 && self.to_solid == 0.0
    }

    /// That where all weights are to be multiplied by a factor.
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        let Self { potential, to_liquid, to_solid } = self;
        Self { potential, to_liquid: factor * to_liquid, to_solid: factor * to_solid }
    }

    /// From a neighbour of some potential and weight. What melts too has the same potential, and gives nothing.
    #[inline(always)]
    fn from(self, other: f64, weight: f64) -> f64 {
        let above = other - self.potential;
        weight * choose(above < 0.0, self.to_solid, self.to_liquid) * above
    }
}

impl<O: CpuOperator + ?Sized> Work for Add<'_, O> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { of, latent, which, operator, potentials, own, rates } = self;
        let (places, enthalpies) = (&latent.places()[which.clone()], &latent.enthalpies()[which]);
        // All before any is needed, since a processor divides several at once.
        let mut flows = vec![Flow::default(); places.len()];
        for ((flow, &place), &enthalpy) in flows.iter_mut().zip(places).zip(enthalpies) {
            *flow = Flow::of(of, place as usize, enthalpy);
        }
        // What they gain, in parts that are added together at last.
        let mut gains = vec![[0.0; LANES]; places.len()];
        let mut near = Near::default();
        for ((&place, &flow), gain) in places.iter().zip(&flows).zip(&mut gains) {
            if flow.is_none() {
                continue;
            }
            let place = place as usize;
            let mut add = |other: usize, weight: f64| {
                let Some(ratio) = of.ratio(place, other) else {
                    return;
                };
                let flow = flow.from(potentials[other], weight);
                gain[0] += flow;
                if let Some(rate) = rates.get_mut(other.wrapping_sub(own.start)) {
                    *rate -= flow * ratio;
                }
            };
            match operator.entries(place, &mut near) {
                Entries::Lines(lines, factor) => {
                    let start = lines.start(place);
                    match potentials.get(start..start + lines.span()) {
                        Some(around) if of.is_alike(place) => {
                            let first = start.wrapping_sub(own.start);
                            let is_own = own.contains(&place);
                            *gain = along(lines, flow.times(factor), around, first, is_own, rates);
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
        for (&place, gain) in places.iter().zip(&gains) {
            if let Some(rate) = rates.get_mut((place as usize).wrapping_sub(own.start)) {
                *rate += (gain[0] + gain[1]) + (gain[2] + gain[3]);
            }
        }
    }
}

/// Takes the flows from all of `lines`, whose potentials are in `around` from the first to the last, from the `rates`
/// of these as far as they are there, where the first line begins at `first`; returns what they are together, in
/// parts, if the particle `is_own`: there, what lies beyond counts too.
#[inline(always)]
fn along(
    lines: &Lines,
    flow: Flow,
    around: &[f64],
    first: usize,
    is_own: bool,
    rates: &mut [f64],
) -> [f64; LANES] {
    let mut gains = [0.0; LANES];
    let count = rates.len();
    for (ahead, weights) in lines.all() {
        let to = first.wrapping_add(*ahead);
        let rates_there = rates.get_mut(to..to.wrapping_add(LANES));
        if rates_there.is_none() && !is_own && is_beyond(to, count) {
            continue;
        }
        let others: &[f64; LANES] =
            around[*ahead..*ahead + LANES].try_into().expect("a line's length");
        let mut flows = [0.0; LANES];
        for x in 0..LANES {
            flows[x] = flow.from(others[x], weights[x]);
        }
        match rates_there {
            Some(rates) => {
                for x in 0..LANES {
                    rates[x] -= flows[x];
                }
            }
            None if is_beyond(to, count) => {}
            None => take_some(&flows, to, rates),
        }
        for x in 0..LANES {
            gains[x] += flows[x];
        }
    }
    gains
}

/// Whether a line that begins at `first` of so many rates has nothing in common with them.
#[inline(always)]
fn is_beyond(first: usize, count: usize) -> bool {
    // What begins before the first has wrapped around.
    first >= count && first.wrapping_add(LANES - 1) >= count
}

/// Takes the flows of a line that begins at `first` of `rates` from these, as far as they are there.
#[inline(always)]
fn take_some(flows: &[f64; LANES], first: usize, rates: &mut [f64]) {
    for (x, flow) in flows.iter().enumerate() {
        if let Some(rate) = rates.get_mut(first.wrapping_add(x)) {
            *rate -= flow;
        }
    }
}
