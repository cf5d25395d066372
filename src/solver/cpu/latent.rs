//! Particles whose potential does not tell their enthalpy.

use std::ops::Range;

use crate::model::operator::within;

/// What melts at one temperature, and what has left the temperatures for which its conductivity is known: few as a
/// rule. Of all others a step needs the potential alone.
#[derive(Clone, Debug, Default)]
pub(super) struct Latent {
    /// Ascending.
    places: Vec<u32>,
    enthalpies: Vec<f64>,
}

impl Latent {
    /// Puts parts together that follow each other.
    pub(super) fn of_parts(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        for part in parts {
            all.places.extend(part.places);
            all.enthalpies.extend(part.enthalpies);
        }
        all
    }

    /// Takes a particle behind all others.
    pub(super) fn push(&mut self, place: usize, enthalpy: f64) {
        self.places.push(place as u32);
        self.enthalpies.push(enthalpy);
    }

    /// Their places, ascending.
    pub(super) fn places(&self) -> &[u32] {
        &self.places
    }

    /// Their enthalpies, K.
    pub(super) fn enthalpies(&self) -> &[f64] {
        &self.enthalpies
    }

    /// The enthalpy of the one in a place, if there is one, K.
    pub(super) fn enthalpy(&self, place: usize) -> Option<f64> {
        let which = self.places.binary_search(&(place as u32)).ok()?;
        Some(self.enthalpies[which])
    }

    /// Place and enthalpy of those in some places.
    pub(super) fn within(
        &self,
        places: &Range<usize>,
    ) -> impl ExactSizeIterator<Item = (usize, f64)> + '_ {
        let range = within(&self.places, places);
        let places = self.places[range.clone()].iter().map(|&place| place as usize);
        places.zip(self.enthalpies[range].iter().copied())
    }

    /// Bytes that it holds.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.places) + size_of_val(&*self.enthalpies)
    }
}
