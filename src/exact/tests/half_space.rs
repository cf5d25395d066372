use std::f64::consts::PI;

use errorfunctions::{ComplexErrorFunctions, RealErrorFunctions};
use num_complex::Complex64;

use super::super::half_space::{SMALL_STEP, mean_descent};
use super::*;

const SIDES: [Side; 5] = [
    Side::Value(3.0),
    Side::Flux(-0.7),
    Side::Convection { coefficient: 0.9, ambient: -2.0 },
    Side::Convection { coefficient: 1e-3, ambient: 40.0 },
    Side::Convection { coefficient: 400.0, ambient: 2.5 },
];

fn body(surface: Side) -> HalfSpace {
    HalfSpace { axis: 0, from: 0.2, surface, initial: 1.0, diffusivity: 0.3 }
}

fn at(depth: f64) -> DVec3 {
    DVec3::new(0.2 + depth, 0.7, -0.3)
}

/// Known to all digits (DLMF 7.2, 7.10; the Faddeeva package's own checks).
#[test]
fn scaled_error_functions() {
    for (x, expected) in [
        (0.0, 1.0),
        (1.0, 0.427_583_576_155_807),
        (10.0, 0.056_140_992_743_822_59),
        (-1.0, 5.008_980_080_762_283),
    ] {
        close(x.erfcx() / expected, 1.0, 1e-14);
    }
    let found = Complex64::new(1.0, -1.0).erfcx();
    close(found.re, 0.304_744_205_256_912_6, 1e-15);
    close(found.im, 0.208_218_938_202_831_6, 1e-15);
    for start in [0.0, 0.3, 2.0, 9.0] {
        for step in [SMALL_STEP, -SMALL_STEP] {
            let divided = (start.erfcx() - (start + step).erfcx()) / step;
            close(mean_descent(start, step), divided, 2e-14);
        }
    }
}

#[test]
fn every_side_satisfies_its_condition_and_the_equation() {
    let points = [0.01, 0.03, 0.1, 0.2, 0.5].map(at);
    for side in SIDES {
        let solution = Solution::HalfSpace(body(side));
        for t in [0.008, 0.11, 0.9, 40.0] {
            let found = residual(&solution, 1, 0.3, &points, (t, 1e-2 * t));
            assert!(found < 1e-5, "{side:?} t = {t}: {found}");
            assert!(residual(&solution, 1, 0.33, &points, (t, 1e-2 * t)) > 1e-2);
            let scale = side_scale(side);
            let found = broken(&solution, side, 0.3, (at(0.0), -DVec3::X), t);
            assert!(found < 1e-8 * scale, "{side:?} t = {t}: {found}");
            if side.held().is_none() {
                // Negative control: the opposite face.
                let wrong = broken(&solution, side, 0.3, (at(0.0), DVec3::X), t);
                assert!(wrong > 1e-3, "{side:?} t = {t}: {wrong}");
            }
        }
    }
}

#[test]
fn known_surface_values() {
    let close =
        |side: Side, t: f64, expected: f64| close(body(side).at(at(0.0), t), expected, 2e-15);
    close(Side::Flux(0.7), 0.5, 1.0 + 1.4 * (0.5 / (PI * 0.3)).sqrt());
    // h s = 1: 1 - e erfc(1).
    let convection = Side::Convection { coefficient: 0.3, ambient: 2.0 };
    close(convection, 1.0 / 0.3, 1.572_416_423_844_193);
    close(Side::Value(3.0), 0.5, 3.0);
}

#[test]
fn a_given_flux_is_taken_up() {
    for t in [1e-3, 0.02, 0.7] {
        let depth = 16.0 * (0.3f64 * t).sqrt();
        let taken = |x: f64| body(Side::Flux(-0.7)).at(at(x), t) - 1.0;
        close(integral(taken, 0.0, depth) / (-0.7 * t), 1.0, 1e-10);
    }
}

#[test]
fn ends_of_time_and_space() {
    for side in SIDES {
        let body = body(side);
        assert_eq!(body.at(at(0.5), 0.0), 1.0);
        assert_eq!(body.at(at(0.5), 1e-300), 1.0);
        close(body.at(at(0.1), 1e-5), 1.0, 1e-15);
        assert_eq!(body.at(at(-0.1), 0.4), body.at(at(0.0), 0.4));
        assert_eq!(body.at(at(0.0), 0.0), if side.held().is_some() { 3.0 } else { 1.0 });
        assert!(body.at(at(0.1), 1e200).is_finite(), "{side:?}");
    }
    close(body(SIDES[2]).at(at(0.1), 1e30), -2.0, 1e-12);
}
