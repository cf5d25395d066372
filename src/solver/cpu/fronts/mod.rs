//! Fronts in memory: the flows that melting particles have beside those of the operator.

mod add;
mod own_lines;
mod queue;

use std::sync::Arc;

use super::entries::{Entries, Near};
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::Problem;
use crate::model::operator::{Front, Fronts};

pub(super) use add::Add;
pub(super) use queue::Queue;

use own_lines::{Beside, OwnLines};

/// What is needed of a scene where something melts at one temperature, by place.
pub(super) struct FrontFlows {
    fronts: Fronts,
    /// The material of each place, where fronts differ; else the front of all.
    of: Which,
    capacities: Arc<Capacities>,
    lines: KnownLines,
}

/// What is known of the lines that go over the neighbours of what melts.
enum KnownLines {
    /// There are none, or they are looked up by place.
    Nothing,
    /// The operator has them, and all is of one material and one capacity.
    OfOperator,
    Own(OwnLines),
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
        let lines = KnownLines::Nothing;
        let mut flows = Self { fronts, of, capacities: Arc::clone(capacities), lines };
        flows.lines = flows.known_lines(operator);
        Some(flows)
    }

    /// Whether what has an `enthalpy` in a place melts.
    pub(super) fn is_latent(&self, place: usize, enthalpy: f64) -> bool {
        self.front(place).is_some_and(|front| front.is_in(enthalpy))
    }

    /// Calls `found` with place and enthalpy of what melts among the places of one material from `first` on, which have
    /// `enthalpies`.
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

    fn front(&self, place: usize) -> Option<&Front> {
        self.front_of(match &self.of {
            Which::Same(_) => 0,
            Which::Each(materials) => materials[place],
        })
    }

    /// The front of what has a curve.
    #[inline(always)]
    fn front_of(&self, curve: u16) -> Option<&Front> {
        match &self.of {
            Which::Same(front) => Some(front),
            Which::Each(_) => self.fronts.of_material(curve),
        }
    }

    /// Whether lines are known by place.
    pub(super) fn has_lines(&self) -> bool {
        !matches!(self.lines, KnownLines::Nothing)
    }

    /// Which lines lead from a place of `operator` to the neighbours of the own material, where these are known.
    pub(super) fn lines<O: CpuOperator + ?Sized>(&self, place: usize, operator: &O) -> u16 {
        match &self.lines {
            KnownLines::Nothing => 0,
            KnownLines::OfOperator => operator.which_lines(place).unwrap_or_default(),
            KnownLines::Own(own) => own.which(place),
        }
    }

    fn known_lines(&self, operator: &dyn CpuOperator) -> KnownLines {
        if !operator.has_lines() {
            return KnownLines::Nothing;
        }
        let materials = match &self.of {
            Which::Same(_) => None,
            Which::Each(materials) => Some(materials.len()),
        };
        let capacities = match &*self.capacities {
            Capacities::Same(_) => None,
            Capacities::Each(capacities) => Some(capacities.len()),
        };
        let beside = |place: usize, other: usize| match self.ratio(place, other) {
            Some(1.0) => Beside::Alike,
            Some(_) => Beside::OtherCapacity,
            None => Beside::OtherMaterial,
        };
        match materials.or(capacities) {
            Some(count) => {
                let melts = |place: usize| self.front(place).is_some();
                KnownLines::Own(OwnLines::of(count, operator, melts, beside))
            }
            None if operator.which_lines(0).is_some() => KnownLines::OfOperator,
            None => KnownLines::Nothing,
        }
    }

    /// Neighbours of the particle in a place that has such [`Self::lines`], but perhaps for those of other materials, and
    /// whether all are of its material and its capacity if they are in lines.
    #[inline(always)]
    fn entries<'a, O: CpuOperator + ?Sized>(
        &'a self,
        place: usize,
        lines: u16,
        operator: &'a O,
        near: &mut Near,
    ) -> (Entries<'a>, bool) {
        let (known, are_alike) = match &self.lines {
            KnownLines::Nothing => (None, true),
            KnownLines::OfOperator => (operator.shared_lines(lines), true),
            KnownLines::Own(own) => (own.lines(lines), false),
        };
        match known {
            Some(lines) => (Entries::Lines(lines, 1.0), true),
            None => (operator.entries(place, near), are_alike),
        }
    }

    /// Bytes that they hold, but for materials and capacities.
    pub(super) fn memory_bytes(&self) -> usize {
        match &self.lines {
            KnownLines::Own(own) => own.memory_bytes(),
            _ => 0,
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
