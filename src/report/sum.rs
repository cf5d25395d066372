//! Sums over particles: accurate, parallel, and the same whatever the number of threads.

use rayon::prelude::*;

use crate::model::sum::CompensatedSum;

/// Terms that one thread adds before it hands its sum over. Fixed, so that the order of the
/// additions, and with it the last bit of the result, does not depend on the number of threads.
const CHUNK: usize = 1 << 15;

/// Sums `N` quantities over the indices `0..len` in one sweep; `terms` gives those of one index.
pub(crate) fn sum_over<const N: usize>(
    len: usize,
    terms: impl Fn(usize) -> [f64; N] + Sync,
) -> [f64; N] {
    let partial: Vec<[CompensatedSum; N]> = (0..len.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut sums = [CompensatedSum::default(); N];
            for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(len) {
                for (sum, term) in sums.iter_mut().zip(terms(i)) {
                    sum.add(term);
                }
            }
            sums
        })
        .collect();
    let mut whole = [CompensatedSum::default(); N];
    for sums in partial {
        for (total, part) in whole.iter_mut().zip(sums) {
            total.merge(part);
        }
    }
    whole.map(CompensatedSum::value)
}

/// The larger of two numbers, NaN if either is: `f64::max` would drop a NaN, and with it the one
/// particle that diverged.
pub(crate) fn max_or_nan(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// The smaller of two numbers, NaN if either is.
pub(crate) fn min_or_nan(a: f64, b: f64) -> f64 {
    -max_or_nan(-a, -b)
}

/// The conserved total of a field: sum of `value` x `volume` (the field's unit times m, m2 or m3).
///
/// Compensated, so that a drift of a few rounding errors is still seen over 1e8 particles.
///
/// # Panics
/// If the two slices differ in length.
pub fn total(value: &[f64], volume: &[f64]) -> f64 {
    assert_eq!(value.len(), volume.len(), "one volume for every value");
    let [sum] = sum_over(value.len(), |i| [value[i] * volume[i]]);
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_what_plain_addition_loses() {
        let terms = [1.0, 1e100, 1.0, -1e100];
        assert_eq!(terms.iter().sum::<f64>(), 0.0, "the control: plain addition loses both ones");
        assert_eq!(total(&terms, &[1.0; 4]), 2.0);
    }

    #[test]
    fn is_the_same_for_any_number_of_threads() {
        let value: Vec<f64> = (0..5 * CHUNK + 17).map(|i| (i as f64).sin() * 1e6).collect();
        let volume: Vec<f64> = (0..value.len()).map(|i| 1.0 / (1 + i % 7) as f64).collect();
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| total(&value, &volume))
        };
        assert_eq!(with(1).to_bits(), with(4).to_bits());
    }

    #[test]
    fn a_change_of_one_particle_is_seen_in_the_total() {
        let mut value = vec![0.1; 1_000_000];
        let volume = vec![0.125; value.len()];
        let before = total(&value, &volume);
        assert!((before - 12_500.0).abs() <= 12_500.0 * f64::EPSILON);
        value[777_777] += 1e-9;
        let gained = total(&value, &volume) - before;
        assert!((gained - 1.25e-10).abs() < 4e-12, "{gained:e}");
    }

    #[test]
    fn a_single_nan_is_not_swallowed() {
        assert!(max_or_nan(1.0, f64::NAN).is_nan());
        assert!(min_or_nan(f64::NAN, 1.0).is_nan());
        assert_eq!((max_or_nan(1.0, 2.0), min_or_nan(1.0, 2.0)), (2.0, 1.0));
        assert!(total(&[1.0, f64::NAN], &[1.0, 1.0]).is_nan());
    }
}
