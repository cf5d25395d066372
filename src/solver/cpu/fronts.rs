//! Fronts in memory: the flows that melting particles have beside those of the operator.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::CHUNK;
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::Problem;
use crate::model::operator::{Front, Fronts, within};
use crate::model::wide::{self, Work};

/// Values that are looked at together for one that melts.
const BLOCK: usize = 64;
/// Values of a part of such a block.
const PART: usize = 8;

/// What is needed of a scene where something melts at one temperature, by place.
pub(super) struct MeltingPlaces {
    fronts: Fronts,
    /// The material of each place, where fronts differ; else the front of all.
    of: Which,
    capacities: Arc<Capacities>,
    /// The places that melt, ascending; none where they have to be looked for.
    places: Option<Vec<u32>>,
}

enum Which {
    Same(Front),
    Each(Arc<[u16]>),
}

/// The particles that melt as a step begins.
pub(super) struct Melting {
    /// Their places, ascending.
    places: Vec<u32>,
    /// How much more than the operator has of it flows to a liquid and to a solid neighbour of each, in parts.
    excess: Vec<[f64; 2]>,
}

impl MeltingPlaces {
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
        Some(Self { fronts, of, capacities: Arc::clone(capacities), places: None })
    }

    /// The places that melt among those from `first` on, whose enthalpies are `values`.
    pub(super) fn among(&self, first: usize, values: &[f64]) -> Vec<u32> {
        let mut found = Vec::new();
        match &self.of {
            Which::Same(front) => wide::run(Search { front, first, values, found: &mut found }),
            Which::Each(_) => {
                let places = first..first + values.len();
                let melting = places.zip(values).filter(|(place, value)| {
                    self.front(*place).is_some_and(|front| front.is_in(**value))
                });
                found.extend(melting.map(|(place, _)| place as u32));
            }
        }
        found
    }

    /// Takes the places that melt after a step, ascending.
    pub(super) fn set(&mut self, places: Vec<u32>) {
        self.places = Some(places);
    }

    /// Has the places that melt looked for before the next step: something else has changed the state.
    pub(super) fn forget(&mut self) {
        self.places = None;
    }

    /// What melts as a step begins, where enthalpies are `values`. Held particles are none: at the melting point
    /// they are solid.
    pub(super) fn melting(&mut self, values: &[f64]) -> Melting {
        let places = self.places.take().unwrap_or_else(|| {
            let parts = values.par_chunks(CHUNK).enumerate();
            let parts: Vec<Vec<u32>> = parts.map(|(k, part)| self.among(k * CHUNK, part)).collect();
            parts.concat()
        });
        let excess = |&place: &u32| {
            let front = self.front(place as usize);
            front.map_or([0.0; 2], |front| self.fronts.excess(front, values[place as usize]))
        };
        Melting { excess: places.par_iter().with_min_len(CHUNK / 16).map(excess).collect(), places }
    }

    /// Adds what flows to and from what melts to the `rates` of places from `first` on, where the operator acts on
    /// `potentials`; returns what held particles give to those of these that melt, value x capacity / s.
    pub(super) fn add<O: CpuOperator + ?Sized>(
        &self,
        melting: &Melting,
        operator: &O,
        potentials: &[f64],
        first: usize,
        rates: &mut [f64],
    ) -> f64 {
        let (own, count) = (first..first + rates.len(), potentials.len());
        let mut given = 0.0;
        if melting.places.is_empty() {
            return given;
        }
        let reach = operator.reach();
        let near = own.start.saturating_sub(reach)..own.end.saturating_add(reach).min(count);
        // Round the ends of periodic axes.
        let behind = (own.start + count).saturating_sub(reach).max(near.end)..count;
        let before = 0..(own.end.saturating_add(reach)).saturating_sub(count).min(near.start);
        let is_plain = operator.held().is_empty()
            && matches!((&self.of, &*self.capacities), (Which::Same(_), Capacities::Same(_)));
        for places in [before, near, behind] {
            for k in within(&melting.places, &places) {
                given += match is_plain {
                    true => self.add_of::<true, O>(melting, k, operator, potentials, &own, rates),
                    false => self.add_of::<false, O>(melting, k, operator, potentials, &own, rates),
                };
            }
        }
        given
    }

    /// The same of one that melts. Of a `PLAIN` scene all particles are of one material and one size, and none is
    /// held.
    #[inline(always)]
    fn add_of<const PLAIN: bool, O: CpuOperator + ?Sized>(
        &self,
        melting: &Melting,
        k: usize,
        operator: &O,
        potentials: &[f64],
        own: &Range<usize>,
        rates: &mut [f64],
    ) -> f64 {
        let place = melting.places[k] as usize;
        let (Some(front), excess) = (self.front(place), melting.excess[k]) else {
            return 0.0;
        };
        let is_own = own.contains(&place);
        let held = operator.held();
        let mut given = 0.0;
        let mut gain = 0.0;
        let entries = operator.entries(place);
        let entries = if is_own { entries } else { entries.within(place, own) };
        entries.for_each(place, |other, weight| {
            let above = potentials[other] - front.potential;
            // What melts too is at the same potential; others may only happen to be.
            if above == 0.0 || !(PLAIN || self.is_alike(place, other)) {
                return;
            }
            let flow = weight * excess[usize::from(above < 0.0)] * above;
            gain += flow;
            if !PLAIN && held.binary_search(&(other as u32)).is_ok() {
                given += flow;
            } else if let Some(rate) = rates.get_mut(other.wrapping_sub(own.start)) {
                *rate -= if PLAIN { flow } else { flow * self.capacities.ratio(place, other) };
            }
        });
        if !is_own {
            return 0.0;
        }
        rates[place - own.start] += gain;
        self.capacities.at(place) * given
    }

    fn front(&self, place: usize) -> Option<&Front> {
        match &self.of {
            Which::Same(front) => Some(front),
            Which::Each(materials) => self.fronts.of_material(materials[place]),
        }
    }

    /// Whether two places are of the same material.
    fn is_alike(&self, one: usize, other: usize) -> bool {
        match &self.of {
            Which::Same(_) => true,
            Which::Each(materials) => materials[one] == materials[other],
        }
    }

    /// Bytes that it holds alone.
    pub(super) fn memory_bytes(&self) -> usize {
        self.places.as_ref().map_or(0, |places| size_of_val(&**places))
    }
}

/// Looks for places whose enthalpies are those of a front.
struct Search<'a> {
    front: &'a Front,
    first: usize,
    values: &'a [f64],
    found: &'a mut Vec<u32>,
}

impl Work for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { front, first, values, found } = self;
        // Most blocks have none, and are looked through without a branch.
        let any = |values: &[f64]| values.iter().fold(false, |any, &v| any | front.is_in(v));
        let blocks = values.chunks(BLOCK).zip((first..).step_by(BLOCK));
        for (block, first) in blocks.filter(|(block, _)| any(block)) {
            let parts = block.chunks(PART).zip((first..).step_by(PART));
            for (part, first) in parts.filter(|(part, _)| any(part)) {
                let melting = (first..).zip(part).filter(|(_, value)| front.is_in(**value));
                found.extend(melting.map(|(place, _)| place as u32));
            }
        }
    }
}
