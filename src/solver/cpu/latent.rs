//! Particles that melt at one temperature: their potential does not tell their enthalpy.

use crate::model::operator::seek;

/// Those of a scene: few as a rule.
#[derive(Clone, Debug, Default)]
pub(super) struct Latent {
    /// Ascending.
    places: Vec<u32>,
    enthalpies: Vec<f64>,
}

impl Latent {
    /// None, with room for so many.
    pub(super) fn with_room(count: usize) -> Self {
        Self { places: Vec::with_capacity(count), enthalpies: Vec::with_capacity(count) }
    }

    /// Puts parts together that follow each other.
    pub(super) fn of_parts(parts: &[Self]) -> Self {
        let mut all = Self::with_room(parts.iter().map(|part| part.places.len()).sum());
        for part in parts {
            all.places.extend_from_slice(&part.places);
            all.enthalpies.extend_from_slice(&part.enthalpies);
        }
        all
    }

    /// Takes a particle: behind all others, or [`Self::sort`] has to follow.
    pub(super) fn push(&mut self, place: usize, enthalpy: f64) {
        self.places.push(place as u32);
        self.enthalpies.push(enthalpy);
    }

    /// Puts those from the one that is `from` in the list on in order of place.
    pub(super) fn sort(&mut self, from: usize) {
        let places = self.places.drain(from..);
        let mut rest: Vec<(u32, f64)> = places.zip(self.enthalpies.drain(from..)).collect();
        rest.sort_by_key(|&(place, _)| place);
        for (place, enthalpy) in rest {
            self.places.push(place);
            self.enthalpies.push(enthalpy);
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

    /// The enthalpy of what is in a place, if it is one of them; looked up from `near` on.
    pub(super) fn find(&self, place: usize, near: &mut usize) -> Option<f64> {
        *near = seek(&self.places, *near, |&other| (other as usize) < place);
        let is_there = self.places.get(*near).is_some_and(|&other| other as usize == place);
        is_there.then(|| self.enthalpies[*near])
    }

    /// Place and enthalpy of one.
    pub(super) fn one(&self, which: usize) -> (usize, f64) {
        (self.places[which] as usize, self.enthalpies[which])
    }

    /// Bytes that it holds.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.places) + size_of_val(&*self.enthalpies)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_behind_are_put_in_order_with_their_enthalpies() {
        let mut latent = Latent::default();
        for place in [9, 3, 8, 4, 6] {
            latent.push(place, 10.0 * place as f64);
        }
        latent.sort(1);
        assert_eq!(latent.places(), [9, 3, 4, 6, 8]);
        assert_eq!(latent.enthalpies(), [90.0, 30.0, 40.0, 60.0, 80.0]);
    }
}
