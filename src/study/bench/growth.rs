//! How the time of a step grows with the number of particles.

use crate::report::bench::{Growth, Measurement};

/// Smaller sizes say more of starting threads and passes than of the work.
const FROM: u64 = 100_000;

/// What the rate at the largest size is compared with.
const REFERENCE: u64 = 1_000_000;

/// The growth over the sizes of one series.
pub(super) fn growth(series: &[Measurement]) -> Growth {
    let large = series.iter().filter(|measurement| measurement.size >= FROM);
    let points: Vec<(f64, f64)> =
        large.map(|m| (m.particles as f64, m.particles as f64 / m.updates_per_s)).collect();
    let reference = series.iter().find(|measurement| measurement.size == REFERENCE);
    let largest = series.iter().max_by_key(|measurement| measurement.size);
    let beyond =
        reference.zip(largest).filter(|(reference, largest)| largest.size > reference.size);
    Growth {
        exponent: exponent(&points),
        from_size: FROM,
        sizes: points.len(),
        largest_over_million: beyond.map(|(a, b)| b.updates_per_s / a.updates_per_s),
    }
}

/// The exponent p of the power law c x^p that fits `points` (x, y) best, by least squares of the
/// logarithms; none of fewer than two different x.
fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logarithms: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logarithms.len() as f64;
    let (sum_x, sum_y) = logarithms.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let (mean_x, mean_y) = (sum_x / n, sum_y / n);
    let (mut along, mut across) = (0.0, 0.0);
    for (x, y) in logarithms {
        along += (x - mean_x) * (x - mean_x);
        across += (x - mean_x) * (y - mean_y);
    }
    (along > 0.0).then(|| across / along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_a_power_law_is_found() {
        for power in [0.9, 1.0, 1.25] {
            let law = |x: f64| (x, 3e-9 * x.powf(power));
            let points = [1e5, 1e6, 1e7, 1e8].map(law);
            let found = exponent(&points).expect("four points");
            assert!((found - power).abs() < 1e-12, "{found}");
            let mut bent = points;
            bent[3].1 *= 2.0;
            assert!(exponent(&bent).expect("four points") > power + 0.05, "a bend is noticed");
        }
    }

    #[test]
    fn one_size_has_no_growth() {
        assert_eq!(exponent(&[]), None);
        assert_eq!(exponent(&[(1e6, 1.0)]), None);
        assert_eq!(exponent(&[(1e6, 1.0), (1e6, 2.0)]), None);
    }

    #[test]
    fn small_sizes_do_not_count_and_the_largest_is_compared_with_a_million() {
        let at = |size: u64, updates_per_s| Measurement {
            size,
            particles: size,
            updates_per_s,
            ..Measurement::default()
        };
        let all = [at(10_000, 1.0), at(100_000, 8.0), at(1_000_000, 8.0), at(10_000_000, 4.0)];
        let of = |range: std::ops::Range<usize>| growth(&all[range]);
        assert_eq!((of(0..3).exponent, of(0..3).sizes), (Some(1.0), 2));
        assert_eq!(of(0..3).largest_over_million, None, "a million is the largest");
        assert_eq!(of(0..4).largest_over_million, Some(0.5));
        assert!(of(0..4).exponent.is_some_and(|exponent| exponent > 1.1));
        assert_eq!(of(0..2).exponent, None);
    }
}
