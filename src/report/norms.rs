//! Error norms of a field against its exact values, and the observed order of accuracy.

use rayon::prelude::*;

use super::sum::{max_or_nan, sum_over};

/// The distance between a numerical field and the exact one, in the field's unit unless noted.
///
/// With e = numerical - exact and V the volume of each particle. A field that is not finite gives
/// norms that are not finite: no particle is skipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Norms {
    /// sum V |e| / sum V.
    pub l1: f64,
    /// sqrt(sum V e^2 / sum V).
    pub l2: f64,
    /// max |e|.
    pub linf: f64,
    /// `l2` of the error over `l2` of the exact field, dimensionless; not finite where the exact
    /// field is zero everywhere.
    pub l2_relative: f64,
    /// (1/N) sum e^2: the French report's (123) as printed, without root and without volumes.
    pub mean_square: f64,
    /// The square root of [`Self::mean_square`].
    pub root_mean_square: f64,
}

impl Norms {
    /// The norms of `numerical - exact` over particles of the given volumes (m, m2 or m3).
    /// NaN where there is no particle.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn new(numerical: &[f64], exact: &[f64], volume: &[f64]) -> Self {
        let count = numerical.len();
        assert_eq!(count, exact.len(), "one exact value for every particle");
        assert_eq!(count, volume.len(), "one volume for every particle");
        let [whole, absolute, square, exact_square, plain_square] = sum_over(count, |i| {
            let (e, v) = (numerical[i] - exact[i], volume[i]);
            [v, v * e.abs(), v * e * e, v * exact[i] * exact[i], e * e]
        });
        let linf = (numerical, exact)
            .into_par_iter()
            .map(|(a, b)| (a - b).abs())
            .reduce(|| 0.0, max_or_nan);
        let mean_square = plain_square / count as f64;
        Self {
            l1: absolute / whole,
            l2: (square / whole).sqrt(),
            linf: if count == 0 { f64::NAN } else { linf },
            l2_relative: (square / exact_square).sqrt(),
            mean_square,
            root_mean_square: mean_square.sqrt(),
        }
    }
}

/// The observed order of accuracy: the least-squares slope of log(error) over log(spacing).
///
/// `None` where no slope exists: fewer than two different spacings, or an error (or spacing) that
/// is not positive and finite, such as one that vanished.
///
/// # Panics
/// If the slices differ in length.
pub fn observed_order(spacing: &[f64], error: &[f64]) -> Option<f64> {
    assert_eq!(spacing.len(), error.len(), "one error for every spacing");
    let usable = |x: &f64| x.is_finite() && *x > 0.0;
    if !spacing.iter().chain(error).all(usable) {
        return None;
    }
    let count = spacing.len() as f64;
    let mean = |x: &[f64]| x.iter().map(|x| x.ln()).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(spacing), mean(error));
    let (mut xy, mut xx) = (0.0, 0.0);
    for (s, e) in spacing.iter().zip(error) {
        let dx = s.ln() - mean_x;
        xy += dx * (e.ln() - mean_y);
        xx += dx * dx;
    }
    // Spacings that differ by rounding alone are one spacing.
    (xx > 1e-20 * count).then(|| xy / xx)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 4.0 * f64::EPSILON * b.abs()
    }

    #[test]
    fn norms_are_those_worked_out_by_hand() {
        // e = (1, -2, 0), V = (1, 2, 5): sum V = 8, sum V|e| = 5, sum V e^2 = 9,
        // sum V exact^2 = 1*4 + 2*25 + 5*9 = 99, sum e^2 = 5.
        let n = Norms::new(&[3.0, 3.0, 3.0], &[2.0, 5.0, 3.0], &[1.0, 2.0, 5.0]);
        assert!(close(n.l1, 0.625));
        assert!(close(n.l2, 1.125f64.sqrt()));
        assert_eq!(n.linf, 2.0);
        assert!(close(n.l2_relative, (9.0f64 / 99.0).sqrt()));
        assert!(close(n.mean_square, 5.0 / 3.0));
        assert!(close(n.root_mean_square, (5.0f64 / 3.0).sqrt()));
    }

    #[test]
    fn one_perturbed_particle_of_many_is_noticed_by_every_norm() {
        let exact: Vec<f64> = (0..100_000).map(|i| 1.0 + (i as f64 * 1e-3).cos()).collect();
        let volume = vec![0.125; exact.len()];
        let same = Norms::new(&exact, &exact, &volume);
        let Norms { l1, l2, linf, l2_relative, mean_square, root_mean_square } = same;
        assert_eq!([l1, l2, linf, l2_relative, mean_square, root_mean_square], [0.0; 6]);
        let mut off = exact.clone();
        off[54_321] += 0.5;
        let n = Norms::new(&off, &exact, &volume);
        assert!(close(n.linf, 0.5));
        assert!(close(n.l1, 0.5e-5) && close(n.mean_square, 0.25e-5));
        assert!(close(n.l2, n.root_mean_square) && n.l2_relative > 0.0);
    }

    #[test]
    fn volumes_weigh_all_norms_but_the_mean_square() {
        let (a, b) = ([1.0, 1.0], [0.0, 1.0]);
        let even = Norms::new(&a, &b, &[1.0, 1.0]);
        let uneven = Norms::new(&a, &b, &[1.0, 3.0]);
        assert_eq!((even.l1, uneven.l1), (0.5, 0.25));
        assert_eq!(even.mean_square, uneven.mean_square);
    }

    #[test]
    fn a_diverged_particle_is_never_hidden() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut field = vec![1.0; 70_000];
            field[3] = bad;
            let n = Norms::new(&field, &vec![1.0; 70_000], &vec![1.0; 70_000]);
            for norm in [n.l1, n.l2, n.linf, n.l2_relative, n.mean_square, n.root_mean_square] {
                assert!(!norm.is_finite());
            }
        }
        assert!(Norms::new(&[], &[], &[]).linf.is_nan());
    }

    #[test]
    fn the_order_is_the_slope() {
        let spacing = [0.1, 0.05, 0.025, 0.0125];
        let error = spacing.map(|s: f64| 3.0 * s.powi(2));
        assert!((observed_order(&spacing, &error).unwrap() - 2.0).abs() < 1e-12);
        // Control: an error that stops falling lowers the slope.
        let floor = spacing.map(|s: f64| 3.0 * s.powi(2) + 1e-3);
        assert!(observed_order(&spacing, &floor).unwrap() < 1.9);
    }

    #[test]
    fn no_order_where_there_is_no_slope() {
        assert_eq!(observed_order(&[], &[]), None);
        assert_eq!(observed_order(&[0.1], &[1.0]), None);
        assert_eq!(observed_order(&[0.1, 0.1], &[1.0, 2.0]), None);
        assert_eq!(observed_order(&[0.1, 0.2], &[0.0, 2.0]), None);
        assert_eq!(observed_order(&[0.1, 0.2], &[f64::NAN, 2.0]), None);
    }
}
