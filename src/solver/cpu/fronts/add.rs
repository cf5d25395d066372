//! The flows of melting particles, in loops that a processor runs on several values at once.

use std::ops::Range;

use super::FrontFlows;
use crate::model::wide::{Work, choose};
use crate::solver::cpu::entries::{Entries, LANES, Lines};
use crate::solver::cpu::latent::Latent;
use crate::solver::cpu::operator::CpuOperator;

/// So many melting particles that follow each other are worked on together: at least, and at most.
const LEAST: usize = 4;
const MOST: usize = 64;

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
#[derive(Clone, Copy)]
struct Flow {
    potential: f64,
    to_liquid: f64,
    to_solid: f64,
}

impl Flow {
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
        let (mut flows, mut together) = (Vec::new(), Together::default());
        let (mut alone, mut rest) = (which.start, which);
        while let Some(k) = rest.next() {
            let place = latent.places()[k] as usize;
            let enthalpy = latent.enthalpies()[k];
            let Some(front) = of.front(place).filter(|front| front.is_in(enthalpy)) else {
                continue;
            };
            let found = match k >= alone {
                true => together.find(of, latent, k..rest.end, operator),
                false => None,
            };
            if let Some((lines, factor)) = found {
                let next = k + together.count();
                if of.is_alike(place, together.count(), lines)
                    && together.add(lines, factor, place, potentials, own.start, rates)
                {
                    rest.start = next;
                    continue;
                }
                alone = next;
            }
            let [to_liquid, to_solid] = of.fronts.excess(front, enthalpy);
            let flow = Flow { potential: front.potential, to_liquid, to_solid };
            let mut gain = 0.0;
            let mut add = |other: usize, weight: f64| {
                let Some(ratio) = of.ratio(place, other) else {
                    return;
                };
                let flow = flow.from(potentials[other], weight);
                gain += flow;
                if let Some(rate) = rates.get_mut(other.wrapping_sub(own.start)) {
                    *rate -= flow * ratio;
                }
            };
            match operator.entries(place) {
                Entries::Lines(lines, factor) => {
                    let start = lines.start(place);
                    match potentials.get(start..start + lines.span()) {
                        Some(around) if of.is_alike(place, 1, lines) => {
                            flows.resize(lines.weights.len(), 0.0);
                            all_from(flow, lines, factor, around, &mut flows);
                            gain = give(lines, &flows, start.wrapping_sub(own.start), rates);
                        }
                        _ => lines.for_each(place, |other, weight| add(other, factor * weight)),
                    }
                }
                Entries::Row(others, weights) => {
                    let entries = others.iter().zip(weights);
                    entries.for_each(|(&other, &weight)| add(other as usize, weight));
                }
                Entries::Site(scene, site, factor) => {
                    scene.entries(site, |other, weight| add(other, factor * weight));
                }
            }
            if let Some(rate) = rates.get_mut(place.wrapping_sub(own.start)) {
                *rate += gain;
            }
        }
    }
}

/// Writes the flows from all of `lines`, whose weights are to be multiplied by a factor, and whose potentials are
/// in `around` from the first to the last. In loops that the processor runs on several values at once.
#[inline(always)]
fn all_from(flow: Flow, lines: &Lines, factor: f64, around: &[f64], flows: &mut [f64]) {
    for (potentials, ahead) in flows.chunks_exact_mut(LANES).zip(&lines.ahead) {
        potentials.copy_from_slice(&around[*ahead..ahead + LANES]);
    }
    for (x, weight) in flows.iter_mut().zip(&lines.weights) {
        *x = flow.from(*x, factor * weight);
    }
}

/// Takes the `flows` from all of `lines`, the first of which begins at `start` of `rates`, from these as far as
/// they are there; returns what they are together.
#[inline(always)]
fn give(lines: &Lines, flows: &[f64], start: usize, rates: &mut [f64]) -> f64 {
    let mut gains = [0.0; LANES];
    for (flows, ahead) in flows.chunks_exact(LANES).zip(&lines.ahead) {
        for x in 0..LANES {
            gains[x] += flows[x];
        }
        let first = start.wrapping_add(*ahead);
        match rates.get_mut(first..first.wrapping_add(LANES)) {
            Some(rates) => {
                for x in 0..LANES {
                    rates[x] -= flows[x];
                }
            }
            None => {
                for (x, flow) in flows.iter().enumerate() {
                    if let Some(rate) = rates.get_mut(first.wrapping_add(x)) {
                        *rate -= flow;
                    }
                }
            }
        }
    }
    (gains[0] + gains[1]) + (gains[2] + gains[3])
}

/// Melting particles that follow each other, all with the neighbours of the first, so many places further: their
/// flows are found together.
#[derive(Default)]
struct Together {
    potential: f64,
    to_liquid: Vec<f64>,
    to_solid: Vec<f64>,
    gains: Vec<f64>,
    flows: Vec<f64>,
}

impl Together {
    /// Finds those that follow the first of `which`, and what is around each, if they are enough.
    #[inline(always)]
    fn find<'o, O: CpuOperator + ?Sized>(
        &mut self,
        of: &FrontFlows,
        latent: &Latent,
        which: Range<usize>,
        operator: &'o O,
    ) -> Option<(&'o Lines, f64)> {
        let places = &latent.places()[which.clone()];
        let first = places[0];
        if *places.get(LEAST - 1)? != first + (LEAST as u32 - 1) {
            return None;
        }
        let Entries::Lines(lines, factor) = operator.entries(first as usize) else {
            return None;
        };
        let front = of.front(first as usize)?;
        self.potential = front.potential;
        self.to_liquid.clear();
        self.to_solid.clear();
        for ((expected, place), k) in (first..).zip(places).zip(which).take(MOST) {
            let enthalpy = latent.enthalpies()[k];
            let entries = operator.entries(*place as usize);
            let has_lines = matches!(entries, Entries::Lines(_, own) if own == factor);
            if !(*place == expected && front.is_in(enthalpy) && has_lines) {
                break;
            }
            let [to_liquid, to_solid] = of.fronts.excess(front, enthalpy);
            self.to_liquid.push(to_liquid);
            self.to_solid.push(to_solid);
        }
        (self.to_liquid.len() >= LEAST).then_some((lines, factor))
    }

    /// How many they are.
    #[inline(always)]
    fn count(&self) -> usize {
        self.to_liquid.len()
    }

    /// Adds their flows, the first being in `place`, to the `rates` of places from `first` on; false where lines go
    /// beyond all places.
    #[inline(always)]
    fn add(
        &mut self,
        lines: &Lines,
        factor: f64,
        place: usize,
        potentials: &[f64],
        first: usize,
        rates: &mut [f64],
    ) -> bool {
        let Self { potential, to_liquid, to_solid, gains, flows } = self;
        let (count, start) = (to_liquid.len(), lines.start(place));
        let Some(around) = potentials.get(start..start + lines.span() + count - 1) else {
            return false;
        };
        gains.clear();
        gains.resize(count, 0.0);
        flows.resize(count, 0.0);
        let lanes = lines.ahead.iter().flat_map(|ahead| *ahead..ahead + LANES);
        for (ahead, weight) in lanes.zip(&lines.weights).filter(|(_, weight)| **weight != 0.0) {
            let weight = factor * weight;
            let others = &around[ahead..ahead + count];
            let excess = to_liquid.iter().zip(&*to_solid);
            let sums = flows.iter_mut().zip(gains.iter_mut());
            for ((other, (&to_liquid, &to_solid)), (flow, gain)) in
                others.iter().zip(excess).zip(sums)
            {
                let of = Flow { potential: *potential, to_liquid, to_solid };
                *flow = of.from(*other, weight);
                *gain += *flow;
            }
            add_to(rates, first, start + ahead, flows.iter().map(|flow| -flow));
        }
        add_to(rates, first, place, gains.iter().copied());
        true
    }
}

/// Adds to the `rates` of places from `first` on what places from `start` on get, as far as they are there.
#[inline(always)]
fn add_to(rates: &mut [f64], first: usize, start: usize, gains: impl Iterator<Item = f64>) {
    let skipped = first.saturating_sub(start);
    let rates = rates.get_mut(start.saturating_sub(first)..).unwrap_or_default();
    rates.iter_mut().zip(gains.skip(skipped)).for_each(|(rate, gain)| *rate += gain);
}
