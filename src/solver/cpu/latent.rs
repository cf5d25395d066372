//! Particles that melt at one temperature: their potential does not tell their enthalpy.

use crate::model::operator::seek;

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
    /// None where all places are of one kind. They stand here since those of all places are far apart.
    kinds: Vec<CurveAndLines>,
}

impl Latent {
    /// None, with room for so many, which are of one kind or not.
    pub(super) fn with_room(count: usize, has_kinds: bool) -> Self {
        Self {
            places: Vec::with_capacity(count),
            enthalpies: Vec::with_capacity(count),
            kinds: Vec::with_capacity(if has_kinds { count } else { 0 }),
        }
    }

    /// Puts parts together that follow each other, in place of those that are there.
    pub(super) fn replace_by<'a>(&mut self, parts: impl Iterator<Item = &'a Self> + Clone) {
        self.truncate(0);
        let count = parts.clone().map(|part| part.places.len()).sum();
        self.places.reserve_exact(count);
        self.enthalpies.reserve_exact(count);
        self.kinds.reserve_exact(parts.clone().map(|part| part.kinds.len()).sum());
        for part in parts {
            self.places.extend_from_slice(&part.places);
            self.enthalpies.extend_from_slice(&part.enthalpies);
            self.kinds.extend_from_slice(&part.kinds);
        }
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

    /// Looks from `near` on for how many are before a place.
    pub(super) fn seek(&self, place: usize, near: &mut usize) {
        *near = seek(&self.places, *near, |&other| (other as usize) < place);
    }

    /// The enthalpy of what is in a place, if it is one of them, where `near` are before one that is not behind it: they
    /// become those before it.
    #[inline(always)]
    pub(super) fn next(&self, place: usize, near: &mut usize) -> Option<f64> {
        while self.places.get(*near).is_some_and(|&other| (other as usize) < place) {
            *near += 1;
        }
        let is_there = self.places.get(*near).is_some_and(|&other| other as usize == place);
        is_there.then(|| self.enthalpies[*near])
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
            let mut twice = Latent::default();
            twice.push(2, 1.0, kind(2));
            twice.replace_by([latent.clone(), latent].iter());
            for which in 0..10 {
                let place = [9, 3, 4, 6, 8][which % 5];
                assert_eq!(twice.one(which), (place, enthalpy(place), kind(place)));
            }
            assert_eq!(twice.memory_bytes(), 10 * if has_kinds { 16 } else { 12 });
        }
    }
}
