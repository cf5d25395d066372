//! Fronts in memory: the flows that melting particles have beside those of the operator.

mod add;
mod queue;

use std::ops::Range;
use std::sync::Arc;

use super::entries::Lines;
use super::latent::Latent;
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::Problem;
use crate::model::operator::{Front, Fronts, within};
use crate::model::wide::{self, Work};

use add::Add;
pub(super) use queue::Queue;

/// Enthalpies that are looked at together.
const FEW: usize = 16;

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

    /// Whether what has an `enthalpy` in a place melts.
    pub(super) fn is_latent(&self, place: usize, enthalpy: f64) -> bool {
        self.front(place).is_some_and(|front| front.is_in(enthalpy))
    }

    /// Finds what melts among the places of one material from `first` on, which have `enthalpies`.
    pub(super) fn find_latent(
        &self,
        first: usize,
        enthalpies: &[f64],
        mut found: impl FnMut(usize, f64),
    ) {
        if let Some(front) = self.front(first) {
            let found = |k: usize| found(first + k, enthalpies[k]);
            wide::run(Find { front, enthalpies, found });
        }
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

    /// Whether all that lines of so many places from `place` on go over is of the material and the capacity of what is
    /// in `place`, and is there.
    #[inline(always)]
    fn is_alike(&self, place: usize, count: usize, lines: &Lines) -> bool {
        let is_of_one = match &self.of {
            Which::Same(_) => true,
            Which::Each(materials) => lines.are_all(place, count, materials),
        };
        is_of_one
            && match &*self.capacities {
                Capacities::Same(_) => true,
                Capacities::Each(capacities) => lines.are_all(place, count, capacities),
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

/// Finds what melts: little as a rule.
struct Find<'a, F> {
    front: &'a Front,
    enthalpies: &'a [f64],
    found: F,
}

impl<F: FnMut(usize)> Work for Find<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(mut self) {
        let [begins, ends] = self.front.enthalpies();
        for (k, few) in self.enthalpies.chunks(FEW).enumerate() {
            // Bits of signs, since a processor puts them together for several at once.
            let mut any = 0;
            for enthalpy in few {
                any |= (begins - enthalpy).to_bits() & (enthalpy - ends).to_bits();
            }
            if any >> 63 != 0 {
                let places = (k * FEW..).zip(few);
                places.filter(|(_, x)| self.front.is_in(**x)).for_each(|(k, _)| (self.found)(k));
            }
        }
    }
}
