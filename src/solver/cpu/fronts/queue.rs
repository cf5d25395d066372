//! Of which melting particles flows are still to be added.

use std::ops::Range;

use crate::model::operator::{take_below, within};
use crate::solver::cpu::latent::Latent;

/// So many are added together at least, unless it is the last time.
const MANY: usize = 32;

/// The latent particles that are within reach of some places, and whose flows have not been added there.
#[derive(Debug, Default)]
pub(in crate::solver::cpu) struct Queue {
    reach: usize,
    /// Those before these places round the end of a periodic axis, those near, and those behind round its start.
    rest: [Range<usize>; 3],
    /// Whether both ends of a periodic axis are near the places, which are most of all.
    has_both_ends: bool,
}

impl Queue {
    /// Those of `latent` within `reach` of `places` among `count`.
    pub(in crate::solver::cpu) fn new(
        latent: &Latent,
        places: &Range<usize>,
        reach: usize,
        count: usize,
    ) -> Self {
        let (start, end) = (places.start, places.end);
        let near = start.saturating_sub(reach)..end.saturating_add(reach).min(count);
        let behind = (start + count).saturating_sub(reach).max(near.end)..count;
        let before = 0..(end.saturating_add(reach)).saturating_sub(count).min(near.start);
        let has_both_ends = near.end.saturating_add(reach) > start + count
            || near.start + count < end.saturating_add(reach);
        let rest = [before, near, behind].map(|places| within(latent.places(), &places));
        Self { reach, rest, has_both_ends }
    }

    /// How many are left.
    pub(in crate::solver::cpu) fn len(&self) -> usize {
        self.rest.iter().map(Range::len).sum()
    }

    /// Whether any that are left may be added to places round the ends of an axis.
    fn goes_round(&self) -> bool {
        let [before, near, behind] = self.rest.each_ref().map(|which| !which.is_empty());
        before || behind || (near && self.has_both_ends)
    }

    /// The next that may be added, where the operator has written what is before `seen`, or all.
    pub(in crate::solver::cpu) fn next(
        &mut self,
        latent: &Latent,
        seen: usize,
        is_all: bool,
    ) -> impl Iterator<Item = Range<usize>> + use<> {
        let next = match is_all {
            true => std::mem::take(&mut self.rest),
            false if self.goes_round() => Default::default(),
            false => {
                let end = seen.saturating_sub(self.reach);
                let last_of_many = latent.places()[self.rest[1].clone()].get(MANY - 1);
                match last_of_many {
                    Some(&place) if (place as usize) < end => {
                        [0..0, take_below(latent.places(), &mut self.rest[1], end), 0..0]
                    }
                    _ => Default::default(),
                }
            }
        };
        next.into_iter().filter(|which| !which.is_empty())
    }

    /// Before which place none that is left adds anything, up to `seen`.
    pub(in crate::solver::cpu) fn untouched(&self, latent: &Latent, seen: usize) -> usize {
        let [_, near, _] = &self.rest;
        match latent.places()[near.clone()].first() {
            _ if self.goes_round() => 0,
            Some(&place) => (place as usize).saturating_sub(self.reach).min(seen),
            None => seen,
        }
    }
}
