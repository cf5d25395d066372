use approx::assert_abs_diff_eq;

use super::*;
use crate::model::KernelKind::{
    self, CubicSpline, Lucy, QuinticSpline, WendlandC2, WendlandC4, WendlandC6,
};

fn ratio(kind: KernelKind, dimension: usize, support_ratio: f64) -> f64 {
    let kernel = Kernel::new(kind, dimension, 0.5 * support_ratio).expect("defined");
    effective_diffusivity_ratio(&kernel, 0.5)
}

#[test]
fn effective_diffusivity_has_the_published_values() {
    assert_abs_diff_eq!(ratio(CubicSpline, 3, 2.0), 1.020_041_673_8, epsilon = 5e-11);
    assert_abs_diff_eq!(ratio(CubicSpline, 2, 2.0), 1.01310, epsilon = 5e-6);
    assert_abs_diff_eq!(ratio(CubicSpline, 1, 2.0), 1.0, epsilon = 1e-15);
    let table = [
        (CubicSpline, [0.98169, 0.99348, 1.01012, 0.99995]),
        (QuinticSpline, [0.98534, 0.99726, 1.00100, 1.00015]),
        (WendlandC2, [0.98523, 0.97890, 1.00062, 0.99941]),
        (WendlandC4, [0.98441, 0.99303, 0.99324, 0.99937]),
        (WendlandC6, [0.92221, 0.96880, 0.99413, 0.99964]),
        (Lucy, [0.96292, 0.98811, 1.00648, 1.00362]),
    ];
    for (kind, expected) in table {
        for (support_ratio, value) in [2.4, 2.6, 3.0, 4.0].into_iter().zip(expected) {
            let found = ratio(kind, 3, support_ratio);
            assert!((found - value).abs() < 6e-6, "{kind:?} at {support_ratio}: {found}");
        }
    }
}

#[test]
fn it_does_not_change_under_refinement() {
    let coarse = Kernel::new(CubicSpline, 3, 2.0).expect("defined");
    let fine = Kernel::new(CubicSpline, 3, 0.02).expect("defined");
    let change =
        effective_diffusivity_ratio(&coarse, 1.0) - effective_diffusivity_ratio(&fine, 0.01);
    assert_abs_diff_eq!(change, 0.0, epsilon = 1e-14);
}
