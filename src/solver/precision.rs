//! The precision of a run.

use crate::gpu::Real;

/// The precision of state, weights and arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Precision {
    /// 32 bits.
    F32,
    /// Weights and arithmetic in 32 bits, values in two words of 32 bits each, so that a step keeps
    /// what rounding would take.
    Compensated,
    /// 64 bits.
    F64,
}

impl Precision {
    /// Every precision.
    pub const ALL: [Self; 3] = [Self::F32, Self::Compensated, Self::F64];

    /// What `real` means in the shaders.
    pub(super) fn real(self) -> Real {
        match self {
            Self::F32 | Self::Compensated => Real::F32,
            Self::F64 => Real::F64,
        }
    }

    /// Bytes of a weight.
    pub fn bytes(self) -> u64 {
        self.real().size() as u64
    }

    /// Bytes of a value of the state.
    pub fn state_bytes(self) -> u64 {
        self.words() as u64 * self.bytes()
    }

    /// Numbers that a value of the state is the sum of.
    pub(super) fn words(self) -> usize {
        match self {
            Self::F32 | Self::F64 => 1,
            Self::Compensated => 2,
        }
    }

    /// The finest relative tolerance that an integrator can follow: a few hundred roundings of a change of
    /// the state, since these add up over its steps and stages.
    pub fn finest(self) -> f64 {
        match self {
            Self::F32 => 1e-5,
            Self::Compensated => 1e-6,
            Self::F64 => 1e-12,
        }
    }

    /// The name in flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::Compensated => "compensated",
            Self::F64 => "f64",
        }
    }

    /// Values as a device holds a state of them.
    pub(super) fn state_to_bytes(self, values: &[f64]) -> Vec<u8> {
        if self.words() == 1 {
            return self.real().to_bytes(values);
        }
        let words = values.iter().flat_map(|&value| self.state_words(value));
        self.real().to_bytes(&words.collect::<Vec<f64>>())
    }

    /// The words of a state's value.
    pub(super) fn state_words(self, value: f64) -> impl Iterator<Item = f64> {
        self.in_words(value).into_iter().take(self.words())
    }

    /// A number as the sum of two that shaders compute with: the first is as near as one comes to it.
    pub(super) fn in_words(self, number: f64) -> [f64; 2] {
        if self.words() == 1 { [number, 0.0] } else { two_words(number) }
    }

    /// Values as a device comes to hold them.
    pub(super) fn on_device(self, values: &[f64]) -> Vec<f64> {
        self.state_from_bytes(&self.state_to_bytes(values))
    }

    /// The inverse of [`Precision::state_to_bytes`].
    pub(super) fn state_from_bytes(self, bytes: &[u8]) -> Vec<f64> {
        let numbers = self.real().from_bytes(bytes);
        match self.words() {
            1 => numbers,
            words => numbers.chunks_exact(words).map(|words| words.iter().sum()).collect(),
        }
    }
}

/// A number as the sum of one of f32 and of what that leaves.
pub(super) fn two_words(number: f64) -> [f64; 2] {
    let first = f64::from(number as f32);
    [first, number - first]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_words_keep_twice_the_digits() {
        let values = [0.0, 1.0 / 3.0, 999.999_740_757, -1e-7, f64::from(f32::MAX)];
        for precision in Precision::ALL {
            let bytes = precision.state_to_bytes(&values);
            assert_eq!(bytes.len() as u64, 5 * precision.state_bytes());
            let back = precision.state_from_bytes(&bytes);
            let off = |(a, b): (&f64, &f64)| (a - b).abs() / a.abs().max(1e-300);
            let worst = values.iter().zip(&back).map(off).fold(0.0, f64::max);
            let (least, most) = match precision {
                Precision::F32 => (1e-9, 6e-8),
                Precision::Compensated => (1e-18, 4e-15),
                Precision::F64 => (-1.0, 0.0),
            };
            assert!(least < worst && worst <= most, "{precision:?}: {worst:e}");
        }
        assert!(Precision::Compensated.state_from_bytes(&[0xff; 8])[0].is_nan());
    }
}
