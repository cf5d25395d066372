//! Particles that melt at one temperature: their potential does not tell their enthalpy.

use std::ops::Range;

use crate::model::operator::{seek, within};

/// What one has of what differs among the places of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CurveAndLines {
    /// Which curve: where curves differ, as a material, else the first.
    pub(super) curve: u16,
    /// Which [lines](super::fronts::FrontFlows::lines).
    pub(super) lines: u16,
}

/// Those of a scene: few as a rule.
#[derive(Clone, Debug, Default)]
pub(super) struct Latent {
    /// Ascending.
    places: Vec<u32>,
    enthalpies: Vec<f64>,
    /// None where all places are of one kind. They stand here since to look them up by place takes longer.
    kinds: Vec<CurveAndLines>,
}

impl Latent {
    /// None, with room for so many, which are of one kind or not.
    fn with_room(count: usize, has_kinds: bool) -> Self {
        Self {
            places: Vec::with_capacity(count),
            enthalpies: Vec::with_capacity(count),
            kinds: Vec::with_capacity(if has_kinds { count } else { 0 }),
        }
    }

    /// Puts parts together that follow each other.
    pub(super) fn of_parts(parts: &[LatentPart<'_>]) -> Self {
        let count = parts.iter().map(|part| part.of.places.len()).sum();
        let mut all = Self::with_room(count, parts.iter().any(|part| !part.kinds.is_empty()));
        for LatentPart { of, kinds } in parts {
            all.places.extend_from_slice(of.places);
            all.enthalpies.extend_from_slice(of.enthalpies);
            all.kinds.extend_from_slice(kinds);
        }
        all
    }

    /// Their places and enthalpies.
    pub(super) fn known(&self) -> LatentEnthalpies<'_> {
        self.all().of
    }

    /// All of them.
    pub(super) fn all(&self) -> LatentPart<'_> {
        self.part(0..self.places.len(), &self.enthalpies)
    }

    /// Some of them with other enthalpies (K).
    fn part<'a>(&'a self, which: Range<usize>, enthalpies: &'a [f64]) -> LatentPart<'a> {
        let kinds = if self.kinds.is_empty() { &[] } else { &self.kinds[which.clone()] };
        LatentPart { of: LatentEnthalpies { places: &self.places[which], enthalpies }, kinds }
    }

    /// Takes a step: those of all `parts` of the places, which follow each other, where `enthalpies` (K) are of those that
    /// are the same. There is room in these then for what the next step writes.
    pub(super) fn go_on(&mut self, enthalpies: &mut Vec<f64>, parts: &[PartAfter]) {
        if parts.iter().all(|part| part.others.is_none()) {
            std::mem::swap(&mut self.enthalpies, enthalpies);
            return;
        }
        let parts = parts.iter().map(|PartAfter { before, others }| match others {
            Some(others) => others.all(),
            None => self.part(before.clone(), &enthalpies[before.clone()]),
        });
        *self = Self::of_parts(&parts.collect::<Vec<_>>());
        enthalpies.resize(self.places.len(), 0.0);
    }

    fn truncate(&mut self, count: usize) {
        self.places.truncate(count);
        self.enthalpies.truncate(count);
        self.kinds.truncate(count);
    }

    /// Takes a particle, with its kind unless all are of one: behind all others, or [`Self::sort`] has to follow.
    #[inline]
    pub(super) fn push(&mut self, place: usize, enthalpy: f64, kind: Option<CurveAndLines>) {
        self.places.push(place as u32);
        self.enthalpies.push(enthalpy);
        self.kinds.extend(kind);
    }

    /// Puts those from the one that is `from` in the list on in order of place.
    pub(super) fn sort(&mut self, from: usize) {
        let rest = (from..self.places.len()).map(|which| self.one(which));
        let mut rest: Vec<(usize, f64, Option<CurveAndLines>)> = rest.collect();
        rest.sort_by_key(|&(place, ..)| place);
        self.truncate(from);
        for (place, enthalpy, kind) in rest {
            self.push(place, enthalpy, kind);
        }
    }

    /// Their places, ascending.
    pub(super) fn places(&self) -> &[u32] {
        &self.places
    }

    /// Their enthalpies, K.
    pub(super) fn enthalpies(&self) -> &[f64] {
        &self.enthalpies
    }

    /// The kind of one, unless all are of one.
    #[inline(always)]
    pub(super) fn kind(&self, which: usize) -> Option<CurveAndLines> {
        self.kinds.get(which).copied()
    }

    /// Place, enthalpy (K) and kind of one.
    #[inline]
    pub(super) fn one(&self, which: usize) -> (usize, f64, Option<CurveAndLines>) {
        (self.places[which] as usize, self.enthalpies[which], self.kind(which))
    }

    /// Bytes that it holds.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.places) + size_of_val(&*self.enthalpies) + size_of_val(&*self.kinds)
    }
}

/// Some of those of a scene that follow each other.
#[derive(Clone, Copy)]
pub(super) struct LatentPart<'a> {
    of: LatentEnthalpies<'a>,
    kinds: &'a [CurveAndLines],
}

/// Places of some, ascending, and their enthalpies, K.
#[derive(Clone, Copy)]
pub(super) struct LatentEnthalpies<'a> {
    places: &'a [u32],
    enthalpies: &'a [f64],
}

impl LatentEnthalpies<'_> {
    /// Looks from `near` on for how many are before a place.
    pub(super) fn seek(self, place: usize, near: &mut usize) {
        *near = seek(self.places, *near, |&other| (other as usize) < place);
    }

    /// The enthalpy of what is in a place, if it is one of them, where `near` are before one that is not behind it: they
    /// become those before it.
    #[inline(always)]
    pub(super) fn next(self, place: usize, near: &mut usize) -> Option<f64> {
        while self.places.get(*near).is_some_and(|&other| (other as usize) < place) {
            *near += 1;
        }
        let is_there = self.places.get(*near).is_some_and(|&other| other as usize == place);
        is_there.then(|| self.enthalpies[*near])
    }
}

/// Which particles of some places are latent after a step: as a rule those that were before it, which keep their place
/// among all.
pub(super) struct NextLatent<'a> {
    before: &'a Latent,
    /// Which of those before were in these places.
    which: Range<usize>,
    /// What they have after the step, K, which is written of as many as are known to be the same.
    enthalpies: &'a mut [f64],
    same: usize,
    /// All from the first place on, once others are among them.
    others: Option<Latent>,
}

impl<'a> NextLatent<'a> {
    /// Takes those of the next `places` out of what all are `before` a step and what is to be written of them.
    pub(super) fn take(
        before: &'a Latent,
        enthalpies: &mut &'a mut [f64],
        places: &Range<usize>,
    ) -> Self {
        let which = within(&before.places, places);
        let enthalpies = enthalpies.split_off_mut(..which.len()).expect("one of each");
        Self { before, which, enthalpies, same: 0, others: None }
    }

    /// Which of those before were in these places.
    pub(super) fn before(&self) -> Range<usize> {
        self.which.clone()
    }

    /// How many there are so far.
    pub(super) fn len(&self) -> usize {
        self.others.as_ref().map_or(self.same, |others| others.places.len())
    }

    /// As [`Latent::push`], where `kind` is asked only for a kind that is not known.
    #[inline]
    pub(super) fn push(
        &mut self,
        place: usize,
        enthalpy: f64,
        kind: impl FnOnce() -> Option<CurveAndLines>,
    ) {
        let next = self.which.start + self.same;
        match &mut self.others {
            Some(others) => others.push(place, enthalpy, kind()),
            None if next < self.which.end && self.before.places[next] as usize == place => {
                self.keep(next, enthalpy);
            }
            None => self.others().push(place, enthalpy, kind()),
        }
    }

    /// Takes one of those before with another enthalpy (K).
    #[inline(always)]
    pub(super) fn keep(&mut self, which: usize, enthalpy: f64) {
        if self.others.is_none() && self.which.start + self.same == which {
            self.enthalpies[self.same] = enthalpy;
            self.same += 1;
        } else {
            let (place, _, kind) = self.before.one(which);
            self.others().push(place, enthalpy, kind);
        }
    }

    /// As [`Latent::sort`].
    pub(super) fn sort(&mut self, from: usize) {
        // Those that are the same are in order.
        if let Some(others) = &mut self.others {
            others.sort(from);
        }
    }

    /// All so far, apart from those before.
    #[cold]
    fn others(&mut self) -> &mut Latent {
        let Self { before, which, enthalpies, same, others } = self;
        others.get_or_insert_with(|| {
            let part = before.part(which.start..which.start + *same, &enthalpies[..*same]);
            Latent::of_parts(&[part])
        })
    }

    /// Those so far.
    pub(super) fn known(&self) -> LatentEnthalpies<'_> {
        match &self.others {
            Some(others) => others.known(),
            None => {
                let which = self.which.start..self.which.start + self.same;
                self.before.part(which, &self.enthalpies[..self.same]).of
            }
        }
    }

    /// All that there are after the step.
    pub(super) fn finish(mut self) -> PartAfter {
        if self.same < self.which.len() {
            self.others();
        }
        debug_assert!(self.known().places.is_sorted(), "looked up by place");
        PartAfter { before: self.which, others: self.others }
    }
}

/// What is latent of some places after a step.
pub(super) struct PartAfter {
    /// Which of those before the step were in these places.
    before: Range<usize>,
    /// All that there are, unless they are the same.
    others: Option<Latent>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_behind_are_put_in_order_with_what_is_known_of_them() {
        for has_kinds in [false, true] {
            let enthalpy = |place: usize| 10.0 * place as f64;
            let kind = |place: usize| {
                has_kinds
                    .then_some(CurveAndLines { curve: place as u16, lines: 100 + place as u16 })
            };
            let mut latent = Latent::default();
            for place in [9, 3, 8, 4, 6] {
                latent.push(place, enthalpy(place), kind(place));
            }
            latent.sort(1);
            assert_eq!(latent.places(), [9, 3, 4, 6, 8]);
            assert_eq!(latent.enthalpies(), [90.0, 30.0, 40.0, 60.0, 80.0]);
            let twice = Latent::of_parts(&[latent.all(), latent.all()]);
            for which in 0..10 {
                let place = [9, 3, 4, 6, 8][which % 5];
                assert_eq!(twice.one(which), (place, enthalpy(place), kind(place)));
            }
            assert_eq!(twice.memory_bytes(), 10 * if has_kinds { 16 } else { 12 });
        }
    }

    #[test]
    fn a_step_keeps_those_that_are_the_same_and_takes_others_in() {
        let kind = |place: usize| Some(CurveAndLines { curve: place as u16, lines: 0 });
        let mut before = Latent::default();
        for place in [2, 5, 11, 14, 17, 25] {
            before.push(place, 1.0, kind(place));
        }
        // By parts of ten places: which are latent after a step, in the order in which they are found.
        let steps: [[&[usize]; 3]; 6] = [
            [&[2, 5], &[11, 14, 17], &[25]],
            [&[2], &[11, 14, 17], &[25]],
            [&[5], &[11, 17], &[25, 27]],
            [&[2, 5, 3], &[], &[25]],
            [&[2, 5], &[14], &[]],
            [&[7], &[11, 14, 17, 12], &[25]],
        ];
        let all = steps.into_iter().enumerate();
        for ((which, step), keeps) in all.flat_map(|step| [(step, false), (step, true)]) {
            let (mut after, mut enthalpies) = (before.clone(), vec![0.0; 6]);
            let mut rest = &mut enthalpies[..];
            let parts: Vec<PartAfter> = (0..)
                .zip(step)
                .map(|(part, places)| {
                    let all = 10 * part..10 * (part + 1);
                    let mut next = NextLatent::take(&before, &mut rest, &all);
                    for (count, &place) in places.iter().enumerate() {
                        assert_eq!(next.len(), count);
                        match before.places().binary_search(&(place as u32)) {
                            Ok(which) if keeps => next.keep(which, place as f64),
                            _ => next.push(place, place as f64, || kind(place)),
                        }
                    }
                    if !places.is_sorted() {
                        next.sort(0);
                    }
                    let (known, mut near) = (next.known(), 0);
                    for place in all {
                        let expected = places.contains(&place).then_some(place as f64);
                        assert_eq!(known.next(place, &mut near), expected);
                    }
                    next.finish()
                })
                .collect();
            let are_the_same = parts.iter().all(|part| part.others.is_none());
            assert_eq!(are_the_same, which == 0);
            after.go_on(&mut enthalpies, &parts);
            let mut expected: Vec<usize> = step.into_iter().flatten().copied().collect();
            expected.sort_unstable();
            let found: Vec<_> = (0..after.places().len()).map(|which| after.one(which)).collect();
            let expected = expected.iter().map(|&place| (place, place as f64, kind(place)));
            assert_eq!(found, expected.collect::<Vec<_>>());
            assert_eq!(enthalpies.len(), found.len(), "one for each of the next step");
        }
    }
}
