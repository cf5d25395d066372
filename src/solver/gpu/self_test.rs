//! Whether a device keeps what rounding takes.
//!
//! No specification says that a shader's compiler leaves compensated sums alone: taken for exact, the
//! compensation is 0, and compilers delete it. So a device shows what it does before it is trusted:
//! it adds increments to values in two words and takes differences of such values, and every bit has
//! to be that of the same operations on the CPU.

use super::passes::STEP_SIZE;
use crate::gpu::{Device, GpuError, PassSource};
use crate::solver::Precision;

/// Values that are tried.
const COUNT: usize = 4096;

/// What came of a self-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SelfTest {
    /// How many values were tried.
    pub tried: usize,
    /// Sums in two words with another bit than on the CPU.
    pub wrong_sums: usize,
    /// Differences of values in two words with another bit than on the CPU.
    pub wrong_differences: usize,
}

impl SelfTest {
    /// Tries the sums and differences of `source` on `device`: those of
    /// [`self_test`](super::passes::self_test) but in a test.
    ///
    /// # Errors
    /// A device that fails.
    pub fn run(device: &Device, source: &PassSource) -> Result<Self, GpuError> {
        let samples: Vec<Sample> = (0..COUNT).map(Sample::new).collect();
        let precision = Precision::Compensated;
        let flat =
            |value: fn(&Sample) -> [f32; 2]| samples.iter().flat_map(value).collect::<Vec<f32>>();
        let rates: Vec<f32> = samples.iter().map(|sample| sample.rate).collect();
        let step_size = STEP_SIZE.contents(precision.real(), [0], [1.0]);
        let step_size = device.block("step size", &step_size)?;
        let bytes = COUNT as u64 * precision.state_bytes();
        let input = |values: &[f32]| device.storage_with("samples", bytemuck::cast_slice(values));
        let after = device.storage("sums", bytes)?;
        let difference = device.storage("differences", bytes / 2)?;
        let pass = device.pass(
            source,
            &[
                &step_size,
                &input(&flat(|sample| sample.value))?,
                &input(&flat(|sample| sample.other))?,
                &input(&rates)?,
                &after,
                &difference,
            ],
            COUNT as u64,
        )?;
        device.submit(&[pass])?;
        let after: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&device.read(&after)?);
        let difference: Vec<u32> = bytemuck::pod_collect_to_vec(&device.read(&difference)?);
        let wrong_sum = |(sample, after): &(&Sample, &[u32; 2])| {
            accumulated(sample.value, sample.rate).map(f32::to_bits) != **after
        };
        let wrong_difference = |&(k, difference): &(usize, &u32)| {
            // As for neighbours on opposite sides: word by word, and only then as one number.
            let own = samples[k].value;
            let word = |word: usize| {
                let to = |other: usize| samples[other].other[word] - own[word];
                to(k) + to(k ^ 1)
            };
            (word(0) + word(1)).to_bits() != *difference
        };
        Ok(Self {
            tried: COUNT,
            wrong_sums: samples.iter().zip(&after).filter(wrong_sum).count(),
            wrong_differences: difference.iter().enumerate().filter(wrong_difference).count(),
        })
    }

    /// Why the device is not to be trusted, if so.
    pub fn fault(self) -> Option<String> {
        let Self { tried, wrong_sums, wrong_differences } = self;
        (wrong_sums + wrong_differences > 0).then(|| {
            format!(
                "its compensated sums are wrong ({wrong_sums} sums and {wrong_differences} \
                 differences of {tried}): a compiler takes them for exact"
            )
        })
    }
}

/// The shader's function of this name.
fn accumulated(total: [f32; 2], increment: f32) -> [f32; 2] {
    let added = increment + total[1];
    let sum = total[0] + added;
    let taken = sum - total[0];
    [sum, (total[0] - (sum - taken)) + (added - taken)]
}

/// A value, one near it, and what is added to the first.
struct Sample {
    value: [f32; 2],
    other: [f32; 2],
    rate: f32,
}

impl Sample {
    /// Sample `k`: values between 1e-3 and 1e3 of either sign, some of them 0; increments down to a
    /// thousandth of what a single word would keep, and some far above the value.
    fn new(k: usize) -> Self {
        let mut seed = k as u64;
        // Steele, Lea and Flood 2014, Fast splittable pseudorandom number generators, figure 17.
        let mut unit = || {
            seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let two_words = |value: f64| {
            let first = value as f32;
            [first, (value - f64::from(first)) as f32]
        };
        let sign = if unit() < 0.5 { -1.0 } else { 1.0 };
        let value = sign * 10_f64.powf(6.0 * unit() - 3.0);
        let value = if k.is_multiple_of(17) { 0.0 } else { value };
        let other = value + (unit() - 0.5) * 10_f64.powf(-6.0 * unit()) * value.abs();
        let size = if k.is_multiple_of(13) { 1e3 } else { 10_f64.powf(-10.0 * unit()) };
        let rate = ((unit() - 0.5) * size * value.abs().max(1e-3)) as f32;
        Self { value: two_words(value), other: two_words(other), rate }
    }
}
