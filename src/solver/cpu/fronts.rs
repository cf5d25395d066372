//! Fronts in memory: the flows that melting particles have beside those of the operator.

use std::ops::Range;
use std::sync::Arc;

use super::entries::{Entries, LANES, Lines};
use super::latent::Latent;
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::Problem;
use crate::model::operator::{Front, Fronts, within};
use crate::model::wide::{self, Work, choose};

/// What is needed of a scene where something melts at one temperature, by place.
pub(super) struct FrontFlows {
    fronts: Fronts,
    /// The material of each place, where fronts differ; else the front of all.
    of: Which,
    capacities: Arc<Capacities>,
}

enum Which {
    Same(Front),
    Each(Arc<[u16]>),
}

/// The latent particles that are within reach of some places, and have not been added to their rates.
#[derive(Debug, Default)]
pub(super) struct Queue {
    reach: usize,
    /// Those before these places round the end of a periodic axis, those near, and those behind round its start.
    rest: [Range<usize>; 3],
}

impl Queue {
    /// Those of `latent` within `reach` of `places` among `count`.
    pub(super) fn new(latent: &Latent, places: &Range<usize>, reach: usize, count: usize) -> Self {
        let (start, end) = (places.start, places.end);
        let near = start.saturating_sub(reach)..end.saturating_add(reach).min(count);
        let behind = (start + count).saturating_sub(reach).max(near.end)..count;
        let before = 0..(end.saturating_add(reach)).saturating_sub(count).min(near.start);
        Self { reach, rest: [before, near, behind].map(|places| within(latent.places(), &places)) }
    }

    fn goes_round(&self) -> bool {
        !(self.rest[0].is_empty() && self.rest[2].is_empty())
    }

    /// The next that may be added, where rates are known before `seen`, or all are.
    pub(super) fn next(
        &mut self,
        latent: &Latent,
        seen: usize,
        is_all: bool,
    ) -> impl Iterator<Item = Range<usize>> + use<> {
        let next = match is_all {
            true => std::mem::take(&mut self.rest),
            false if self.goes_round() => Default::default(),
            false => {
                let near = &mut self.rest[1];
                let places = &latent.places()[near.clone()];
                let ready = |place: &u32| *place as usize + self.reach < seen;
                let split = near.start + places.partition_point(ready);
                let next = near.start..split;
                near.start = split;
                [0..0, next, 0..0]
            }
        };
        next.into_iter().filter(|which| !which.is_empty())
    }

    /// Before which place none that is left adds anything, up to `seen`.
    pub(super) fn untouched(&self, latent: &Latent, seen: usize) -> usize {
        let [_, near, _] = &self.rest;
        match latent.places()[near.clone()].first() {
            _ if self.goes_round() => 0,
            Some(&place) => (place as usize).saturating_sub(self.reach).min(seen),
            None => seen,
        }
    }
}

impl FrontFlows {
    /// Those of `problem`, whose particles have `capacities` and, where curves differ, `materials`, by place.
    pub(super) fn new(
        problem: &Problem,
        capacities: &Arc<Capacities>,
        materials: Option<&Arc<[u16]>>,
    ) -> Option<Self> {
        let fronts = Fronts::of(problem)?;
        let of = match materials {
            None => Which::Same(*fronts.of_material(problem.particles.material[0])?),
            Some(materials) => Which::Each(Arc::clone(materials)),
        };
        Some(Self { fronts, of, capacities: Arc::clone(capacities) })
    }

    /// Adds what flows to and from some of those that melt to the `rates` of places from `first` on, where the
    /// operator acts on `potentials`. Held particles do not melt: at the melting point they are solid.
    pub(super) fn add<O: CpuOperator + ?Sized>(
        &self,
        latent: &Latent,
        which: Range<usize>,
        operator: &O,
        potentials: &[f64],
        first: usize,
        rates: &mut [f64],
    ) {
        let own = first..first + rates.len();
        wide::run(Add { of: self, latent, which, operator, potentials, own, rates });
    }

    /// Takes back what has been added to the `rates`, from place `first` on, of held particles in `places`, which
    /// were 0; returns what they give, value x capacity / s.
    pub(super) fn take_held<O: CpuOperator + ?Sized>(
        &self,
        operator: &O,
        places: Range<usize>,
        first: usize,
        rates: &mut [f64],
    ) -> f64 {
        let held = operator.held()[within(operator.held(), &places)].iter().map(|&k| k as usize);
        let taken =
            |held: usize| std::mem::take(&mut rates[held - first]) * self.capacities.at(held);
        -held.map(taken).sum::<f64>()
    }

    #[inline(always)]
    fn front(&self, place: usize) -> Option<&Front> {
        match &self.of {
            Which::Same(front) => Some(front),
            Which::Each(materials) => self.fronts.of_material(materials[place]),
        }
    }

    /// How much the rate of `other` changes for one of `place`, with which it exchanges heat; `None` where it is of
    /// another material.
    #[inline(always)]
    fn ratio(&self, place: usize, other: usize) -> Option<f64> {
        match &self.of {
            Which::Each(materials) if materials[place] != materials[other] => None,
            _ => Some(self.capacities.ratio(place, other)),
        }
    }
}

/// Adds the flows of some latent particles.
struct Add<'a, O: ?Sized> {
    of: &'a FrontFlows,
    latent: &'a Latent,
    which: Range<usize>,
    operator: &'a O,
    potentials: &'a [f64],
    /// The places whose rates are here.
    own: Range<usize>,
    rates: &'a mut [f64],
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
        // Of a plain scene all particles are of one material and one size.
        let is_plain = matches!((&of.of, &*of.capacities), (Which::Same(_), Capacities::Same(_)));
        let mut flows = Vec::new();
        for k in which {
            let place = latent.places()[k] as usize;
            let enthalpy = latent.enthalpies()[k];
            let Some(front) = of.front(place).filter(|front| front.is_in(enthalpy)) else {
                continue;
            };
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
                        Some(around) if is_plain => {
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
    let Flow { potential, to_liquid, to_solid } = flow;
    let flow = Flow { potential, to_liquid: factor * to_liquid, to_solid: factor * to_solid };
    for (potentials, ahead) in flows.chunks_exact_mut(LANES).zip(&lines.ahead) {
        potentials.copy_from_slice(&around[*ahead..ahead + LANES]);
    }
    for (x, weight) in flows.iter_mut().zip(&lines.weights) {
        *x = flow.from(*x, *weight);
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
