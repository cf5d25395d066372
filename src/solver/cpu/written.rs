//! What operators write, by curve.

use super::operator::Combine;

/// What is written at each place.
#[derive(Clone, Copy)]
pub(super) enum Written<'a> {
    /// The same everywhere.
    Same(Combine),
    /// By curve: where curves differ, each material is taken to have its own, numbered as the materials; where all have
    /// one, there is no other.
    Each(&'a [Combine]),
}

impl Written<'_> {
    /// What is written where there is a curve.
    #[inline(always)]
    pub(super) fn of(self, curve: usize) -> Combine {
        match self {
            Self::Same(combine) => combine,
            Self::Each(combines) => combines[curve],
        }
    }
}
