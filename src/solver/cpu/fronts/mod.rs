//! Fronts in memory: the flows that melting particles have beside those of the operator.

mod add;
mod queue;

use std::sync::Arc;

use rayon::prelude::*;

use super::entries::{Entries, Lines, Near};
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::Problem;
use crate::model::operator::{Front, Fronts};

pub(super) use add::Add;
pub(super) use queue::Queue;

/// Of a word.
const BITS: usize = u64::BITS as usize;
/// Words that one parallel task finds, at least.
const WORDS_OF_A_TASK: usize = 1 << 6;

/// What is needed of a scene where something melts at one temperature, by place.
pub(super) struct FrontFlows {
    fronts: Fronts,
    /// The material of each place, where fronts differ; else the front of all.
    of: Which,
    capacities: Arc<Capacities>,
    /// By place, a bit each: whether all that its [`Lines`] go over is of its material and its capacity, and is there;
    /// `None` where all is.
    alike: Option<Vec<u64>>,
}

enum Which {
    Same(Front),
    Each(Arc<[u16]>),
}

impl FrontFlows {
    /// Those of `problem`, whose particles have `capacities` and, where curves differ, `materials`, by place, as
    /// `operator` has them.
    pub(super) fn new(
        problem: &Problem,
        capacities: &Arc<Capacities>,
        materials: Option<&Arc<[u16]>>,
        operator: &dyn CpuOperator,
    ) -> Option<Self> {
        let fronts = Fronts::of(problem)?;
        let of = match materials {
            None => Which::Same(*fronts.of_material(problem.particles.material[0])?),
            Some(materials) => Which::Each(Arc::clone(materials)),
        };
        let mut flows = Self { fronts, of, capacities: Arc::clone(capacities), alike: None };
        flows.alike = flows.find_alike(operator);
        Some(flows)
    }

    /// Whether what has an `enthalpy` in a place melts.
    pub(super) fn is_latent(&self, place: usize, enthalpy: f64) -> bool {
        self.front(place).is_some_and(|front| front.is_in(enthalpy))
    }

    /// Calls `found` with what melts among the places of one material from `first` on, which have `enthalpies`.
    pub(super) fn find_latent(
        &self,
        first: usize,
        enthalpies: &[f64],
        mut found: impl FnMut(usize, f64),
    ) {
        let Some(front) = self.front(first) else {
            return;
        };
        for (place, &enthalpy) in (first..).zip(enthalpies) {
            if front.is_in(enthalpy) {
                found(place, enthalpy);
            }
        }
    }

    /// Capacity of what is in a place.
    pub(super) fn capacity(&self, place: usize) -> f64 {
        self.capacities.at(place)
    }

    #[inline(always)]
    fn front(&self, place: usize) -> Option<&Front> {
        match &self.of {
            Which::Same(front) => Some(front),
            Which::Each(materials) => self.fronts.of_material(materials[place]),
        }
    }

    fn find_alike(&self, operator: &dyn CpuOperator) -> Option<Vec<u64>> {
        let materials = match &self.of {
            Which::Same(_) => None,
            Which::Each(materials) => Some(&**materials),
        };
        let capacities = match &*self.capacities {
            Capacities::Same(_) => None,
            Capacities::Each(capacities) => Some(&**capacities),
        };
        let count = materials.map(<[u16]>::len).or(capacities.map(<[f64]>::len))?;
        let is_alike = |place: usize, lines: &Lines| {
            materials.is_none_or(|materials| lines.are_all(place, materials))
                && capacities.is_none_or(|capacities| lines.are_all(place, capacities))
        };
        let bits = |word: usize| {
            let (first, mut near) = (word * BITS, Near::default());
            let places = first..count.min(first + BITS);
            places.rev().fold(0, |bits, place| {
                let entries = self.front(place).map(|_| operator.entries(place, &mut near));
                let is_alike =
                    matches!(entries, Some(Entries::Lines(lines, _)) if is_alike(place, lines));
                bits << 1 | u64::from(is_alike)
            })
        };
        let words = (0..count.div_ceil(BITS)).into_par_iter().with_min_len(WORDS_OF_A_TASK);
        Some(words.map(bits).collect())
    }

    /// Whether all that the lines of a place go over is of the material and the capacity of what is there, and is
    /// there.
    #[inline(always)]
    fn is_alike(&self, place: usize) -> bool {
        self.alike.as_ref().is_none_or(|bits| bits[place / BITS] >> (place % BITS) & 1 != 0)
    }

    /// Bytes that they hold, but for materials and capacities.
    pub(super) fn memory_bytes(&self) -> usize {
        self.alike.as_ref().map_or(0, |bits| size_of_val(&**bits))
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
