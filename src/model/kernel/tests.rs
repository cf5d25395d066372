use super::*;

/// Dimensions in which `kind` is defined.
fn dimensions(kind: KernelKind) -> impl Iterator<Item = usize> {
    (1..=3).filter(move |&d| kind.is_defined_in(d))
}

fn shell(dimension: usize, r: f64) -> f64 {
    use std::f64::consts::PI;
    match dimension {
        1 => 2.0,
        2 => 2.0 * PI * r,
        _ => 4.0 * PI * r * r,
    }
}

/// Gauss-Legendre with 5 points on each of `pieces` equal pieces: exact to rounding for the
/// polynomial pieces of every kernel when breaks fall on piece ends.
fn integrate(upper: f64, pieces: usize, f: impl Fn(f64) -> f64) -> f64 {
    let nodes = [
        (0.0, 128.0 / 225.0),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = 0.5 * upper / pieces as f64;
    let mut sum = 0.0;
    for piece in 0..pieces {
        let middle = (2 * piece + 1) as f64 * half;
        for (node, weight) in nodes {
            let pair = f(middle - node * half) + f(middle + node * half);
            sum += half * weight * if node == 0.0 { 0.5 * pair } else { pair };
        }
    }
    sum
}

#[test]
fn integral_is_one_in_every_dimension_past_the_edge_too() {
    for kind in KernelKind::ALL {
        for dimension in dimensions(kind) {
            let kernel = Kernel::new(kind, dimension, 0.7).expect("defined");
            let integral = integrate(1.4, 600, |r| shell(dimension, r) * kernel.w(r));
            assert!((integral - 1.0).abs() < 1e-12, "{kind:?} in {dimension}-D: {integral}");
            let wrong = integrate(1.4, 600, |r| shell(dimension, r) * 1.001 * kernel.w(r));
            assert!((wrong - 1.0).abs() > 1e-4, "the check must notice a wrong factor");
        }
    }
}

#[test]
fn derivative_over_r_is_the_derivative_of_w() {
    for kind in KernelKind::ALL {
        for dimension in dimensions(kind) {
            let kernel = Kernel::new(kind, dimension, 1.3).expect("defined");
            for k in 1..130 {
                let r = 0.01 * f64::from(k) + 0.003;
                let step = 1e-5;
                let difference = (kernel.w(r + step) - kernel.w(r - step)) / (2.0 * step);
                let crosses_edge = (r - 1.3).abs() < 2.0 * step;
                let error = (kernel.dw_over_r(r) * r - difference).abs();
                assert!(crosses_edge || error < 1e-7 * kernel.w(0.0), "{kind:?} at {r}: {error:e}");
            }
        }
    }
}

#[test]
fn first_moment_identity_holds() {
    // integral of -r W'(r) over space is dim: by parts from integral W = 1.
    for kind in KernelKind::ALL {
        for dimension in dimensions(kind) {
            let kernel = Kernel::new(kind, dimension, 1.0).expect("defined");
            let moment =
                integrate(1.0, 600, |r| -shell(dimension, r) * r * r * kernel.dw_over_r(r));
            assert!((moment - dimension as f64).abs() < 1e-11, "{kind:?}: {moment}");
        }
    }
}

#[test]
fn vanishes_at_and_past_the_support_and_is_never_positive_in_dw_over_r() {
    for kind in KernelKind::ALL {
        let kernel = Kernel::new(kind, 1, 2.0).expect("every kernel is defined in 1-D");
        assert_eq!((kernel.w(2.0), kernel.dw_over_r(2.0)), (0.0, 0.0));
        assert_eq!((kernel.w(7.0), kernel.dw_over_r(7.0)), (0.0, 0.0));
        assert!((1..200).all(|k| kernel.dw_over_r(0.01 * f64::from(k)) <= 0.0));
        let at_zero = kernel.dw_over_r(0.0);
        assert_eq!(at_zero.is_finite(), kind.definition().finite_at_zero, "{kind:?}");
    }
}

#[test]
fn what_the_margin_leaves_out_is_negligible_but_for_the_hat() {
    for kind in KernelKind::ALL.into_iter().filter(|&kind| kind != KernelKind::Hat) {
        let kernel = Kernel::new(kind, 1, 1.0).expect("defined");
        let left_out = kernel.dw_over_r(SUPPORT_MARGIN) / kernel.dw_over_r(0.1);
        assert!(left_out < 1e-11, "{kind:?}: {left_out:e}");
    }
}

#[test]
fn names_are_distinct_and_hat_is_for_one_dimension() {
    let mut names: Vec<_> = KernelKind::ALL.iter().map(|k| k.name()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), KernelKind::ALL.len());
    assert!(Kernel::new(KernelKind::Hat, 2, 1.0).is_none());
}
