//! How the diffusivities of a pair are joined.

/// The pair coefficient kbar(D_a, D_b); 2 D where both are D.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PairMean {
    /// 4 D_a D_b / (D_a + D_b), the report's (109) after Cleary and Monaghan 1999: the flux stays
    /// continuous across a jump of D.
    Harmonic,
    /// D_a + D_b, the report's (107).
    Arithmetic,
}

impl PairMean {
    /// Every pair mean.
    pub const ALL: [Self; 2] = [Self::Harmonic, Self::Arithmetic];

    /// The name in case files, and the stem of the shader file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Harmonic => "harmonic",
            Self::Arithmetic => "arithmetic",
        }
    }

    /// The coefficient of a pair, in the unit of its arguments (positive). Exactly symmetric, so
    /// that what one particle loses the other gains to the last bit; the harmonic form neither
    /// overflows nor underflows where the product D_a D_b would.
    pub fn of(self, diffusivity_a: f64, diffusivity_b: f64) -> f64 {
        self.of_terms(self.term(diffusivity_a), self.term(diffusivity_b))
    }

    /// What [`Self::of_terms`] needs of one diffusivity: where it is in many pairs, it is divided by once.
    #[inline(always)]
    pub fn term(self, diffusivity: f64) -> f64 {
        match self {
            Self::Harmonic => 1.0 / diffusivity,
            Self::Arithmetic => diffusivity,
        }
    }

    /// As [`Self::of`], of the terms of two diffusivities.
    #[inline(always)]
    pub fn of_terms(self, term_a: f64, term_b: f64) -> f64 {
        match self {
            Self::Harmonic => 4.0 / (term_a + term_b),
            Self::Arithmetic => term_a + term_b,
        }
    }
}
