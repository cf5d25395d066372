use std::f64::consts::PI;

use super::*;

const CENTER: DVec3 = DVec3::new(0.1, -0.4, 0.3);

fn annulus(inner_radius: f64, outer_radius: f64) -> Annulus {
    Annulus::new(AnnulusSetup {
        center: CENTER,
        inner_radius,
        outer_radius,
        inner: 3.0,
        outer: -1.0,
        initial: 1.0,
        diffusivity: 0.3,
    })
}

/// At `radius` from the axis; z is nowhere near the centre's.
fn at(radius: f64) -> DVec3 {
    CENTER + radius * DVec3::new(0.6, -0.8, 0.0) + 7.0 * DVec3::Z
}

#[test]
fn the_equation_is_satisfied() {
    for (a, b) in [(0.5, 1.2), (0.05, 0.9), (0.9, 1.5)] {
        let points = [0.1, 0.3, 0.5, 0.7, 0.9].map(|share| at(a + share * (b - a)));
        let solution = Solution::Annulus(annulus(a, b));
        for t in [0.009, 0.02, 0.11, 0.6] {
            let found = residual(&solution, 2, 0.3, &points, (t, 1e-2 * t));
            assert!(found < 1e-5, "{a} {b} t = {t}: {found}");
            assert!(residual(&solution, 2, 0.33, &points, (t, 1e-2 * t)) > 1e-2);
        }
    }
}

#[test]
fn it_starts_from_the_initial_value_and_comes_to_rest() {
    for (a, b) in [(0.5, 1.2), (0.05, 0.9), (0.9, 1.5)] {
        let annulus = annulus(a, b);
        let unit = (b - a) * (b - a) / 0.3;
        // The shortest time that the series is meant for: 15 reaches from either circle.
        for share in [0.15, 0.3, 0.5, 0.8, 0.85] {
            close(annulus.at(at(a + share * (b - a)), 1e-4 * unit), 1.0, 1e-12);
        }
        assert_eq!(annulus.at(at(0.5 * (a + b)), 0.0), 1.0);
        let middle = (a * b).sqrt();
        close(annulus.at(at(middle), 30.0 * unit), 1.0, 1e-14);
        let quarter = a * (b / a).powf(0.25);
        close(annulus.at(at(quarter), 30.0 * unit), 2.0, 1e-14);
    }
}

#[test]
fn the_circles_are_held() {
    let annulus = annulus(0.5, 1.2);
    for t in [0.0, 1e-3, 0.1, 50.0] {
        for (radius, value) in [(0.0, 3.0), (0.3, 3.0), (0.4999, 3.0), (1.2001, -1.0), (9.0, -1.0)]
        {
            assert_eq!(annulus.at(at(radius), t), value);
        }
    }
    // Continuous at the circles: the series meets the values by itself.
    for t in [1e-3, 0.1, 50.0] {
        close(annulus.at(at(0.5 + 1e-13), t), 3.0, 1e-10);
        close(annulus.at(at(1.2 - 1e-13), t), -1.0, 1e-10);
    }
}

/// Roots of J0(x) Y0(2 x) - J0(2 x) Y0(x) (Abramowitz and Stegun 1964, table 9.7).
#[test]
fn roots_of_the_tables() {
    let modes = annulus(0.7, 1.4).modes;
    for (mode, expected) in modes.iter().zip([3.12303, 6.27344, 9.41821]) {
        close(0.7 * mode.root, expected, 5.1e-6);
    }
    for pair in modes.windows(2) {
        close(0.7 * (pair[1].root - pair[0].root) / PI, 1.0, 4e-3);
    }
}

/// A thin ring is a slab, up to (b - a) / a.
#[test]
fn a_thin_ring_is_a_slab() {
    let gap = |radius: f64| {
        let ring = annulus(radius, radius + 1.0);
        let slab = Slab::new(SlabSetup {
            axis: 0,
            from: 0.0,
            to: 1.0,
            left: Side::Value(3.0),
            right: Side::Value(-1.0),
            initial: 1.0,
            diffusivity: 0.3,
        });
        let difference = |x: f64, t: f64| ring.at(at(radius + x), t) - slab.at(DVec3::X * x, t);
        [(0.1, 0.02), (0.3, 0.1), (0.6, 0.4), (0.5, 20.0)]
            .map(|(x, t)| difference(x, t).abs())
            .into_iter()
            .fold(0.0, f64::max)
    };
    let (near, far) = (gap(50.0), gap(500.0));
    assert!(near < 0.02 && near / far > 9.0 && near / far < 11.0, "{near} {far}");
}
