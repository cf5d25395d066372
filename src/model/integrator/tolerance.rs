//! What a result may be off.

/// What an integrator's steps may leave as an error at the end of a run: `absolute` + `relative` x the
/// largest magnitude of the field, the largest over all particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// In the unit of the field.
    pub absolute: f64,
    /// Of the largest magnitude of the field.
    pub relative: f64,
}

impl Tolerance {
    /// What is taken where the case gives none.
    pub const DEFAULT: Self = Self { absolute: 0.0, relative: 1e-4 };

    /// The tolerance of a field whose values are up to `scale`.
    pub fn of(self, scale: f64) -> f64 {
        self.absolute + self.relative * scale
    }
}
