use std::f64::consts::FRAC_PI_2;

use super::super::modes::SHORT;
use super::*;

/// With D = 0.3 and R = 0.6 the Biot number is twice the coefficient: 0.002, 0.8, 1, just above 1,
/// 6 and 800.
const SIDES: [Side; 8] = [
    Side::Value(3.0),
    Side::Flux(0.7),
    Side::Convection { coefficient: 1e-3, ambient: 40.0 },
    Side::Convection { coefficient: 0.4, ambient: -2.0 },
    Side::Convection { coefficient: 0.5, ambient: -2.0 },
    Side::Convection { coefficient: 0.500_000_001, ambient: -2.0 },
    Side::Convection { coefficient: 3.0, ambient: -2.0 },
    Side::Convection { coefficient: 400.0, ambient: 2.5 },
];

const CENTER: DVec3 = DVec3::new(0.1, -0.4, 0.3);

fn sphere(surface: Side) -> Sphere {
    let (radius, initial, diffusivity) = (0.6, 1.0, 0.3);
    Sphere::new(SphereSetup { center: CENTER, radius, surface, initial, diffusivity })
}

fn out() -> DVec3 {
    DVec3::new(0.6, -0.3, 0.5).normalize()
}

fn at(place: f64) -> DVec3 {
    CENTER + 0.6 * place * out()
}

#[test]
fn every_side_satisfies_its_condition_and_the_equation() {
    let points = [0.0, 1e-5, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97].map(at);
    for side in SIDES {
        let solution = Solution::Sphere(sphere(side));
        let scale = side_scale(side);
        for t in [0.005, 0.009, 0.11, 0.5] {
            let found = residual(&solution, 3, 0.3, &points, (t, 1e-2 * t));
            assert!(found < 2e-5, "{side:?} t = {t}: {found}");
            let wrong = residual(&solution, 3, 0.33, &points, (t, 1e-2 * t));
            assert!(wrong > 1e-2, "{side:?} t = {t}: {wrong}");
            let found = broken(&solution, side, 0.3, (at(1.0), out()), t);
            assert!(found < 1e-8 * scale, "{side:?} t = {t}: {found}");
        }
    }
    // Negative control: a coefficient 1% off.
    let solution = Solution::Sphere(sphere(SIDES[3]));
    let other = Side::Convection { coefficient: 0.404, ambient: -2.0 };
    assert!(broken(&solution, other, 0.3, (at(1.0), out()), 0.11) > 1e-3);
}

#[test]
fn the_two_forms_agree() {
    for side in SIDES {
        let sphere = sphere(side);
        for time in [0.9 * SHORT, SHORT] {
            for place in [0.0, 1e-4, 0.02, 0.1, 0.5, 0.93, 1.0] {
                let (short, long) = (sphere.half_space(place, time), sphere.waves(place, time));
                let difference = (short - long).abs();
                assert!(difference < 1e-12, "{side:?} {place} {time}: {short} {long}");
            }
        }
    }
}

#[test]
fn a_given_flux_is_taken_up() {
    let sphere = sphere(Side::Flux(0.7));
    for t in [0.002, 0.02, 0.7, 30.0] {
        let shell = |place: f64| 3.0 * place * place * (sphere.at(at(place), t) - 1.0);
        close(integral(shell, 0.0, 1.0) / (3.0 * 0.7 * t / 0.6), 1.0, 1e-9);
    }
}

/// First roots and amplitudes (Incropera and DeWitt 2002, table 5.1), and the first root of
/// tan b = b (Carslaw and Jaeger 1959, appendix 4, table 3).
#[test]
fn first_waves_of_the_tables() {
    for (biot, root, amplitude) in
        [(0.1, 0.5423, 1.0298), (1.0, FRAC_PI_2, 1.2732), (10.0, 2.8363, 1.9249)]
    {
        let surface = Side::Convection { coefficient: biot * 0.3 / 0.6, ambient: 0.0 };
        let mode = &sphere(surface).modes[0];
        close(mode.root, root, 5.1e-5);
        close(mode.root * mode.amplitude, amplitude, 5.1e-5);
        close(mode.root / mode.root.tan(), 1.0 - biot, 1e-13);
    }
    let modes = sphere(Side::Flux(0.7)).modes;
    close(modes[0].root, 4.493_409_457_909_064, 1e-14);
    close(modes[1].root, 7.725_251_836_937_707, 1e-14);
}

/// A sphere cooling from 1 to 0, at its centre: 2 sum (-1)^(n+1) exp(-n^2 pi^2 T).
#[test]
fn known_values_at_the_centre() {
    let sphere = Sphere::new(SphereSetup {
        center: CENTER,
        radius: 1.0,
        surface: Side::Value(0.0),
        initial: 1.0,
        diffusivity: 1.0,
    });
    let (first, second) = ((-0.986_960_440_108_935_8f64).exp(), (-3.947_841_760_435_743f64).exp());
    let third = (-8.882_643_960_980_423f64).exp() - (-15.791_367_041_742_973f64).exp();
    let fifth = (-24.674_011_002_723_396f64).exp();
    let expected = 2.0 * (first - second + third + fifth);
    close(sphere.at(CENTER, 0.1), expected, 1e-14);
}

#[test]
fn ends_of_time_and_space() {
    for side in SIDES {
        let sphere = sphere(side);
        for place in [0.0, 0.5, 0.9] {
            assert_eq!(sphere.at(at(place), 0.0), 1.0);
            close(sphere.at(at(place), 1e-5), 1.0, 1e-12);
        }
        assert_eq!(sphere.at(at(1.01), 0.0), side.held().unwrap_or(1.0));
        close(sphere.at(at(1.5), 0.2), sphere.at(at(1.0), 0.2), 1e-14);
        for t in [1e-3, 0.3] {
            close(sphere.at(at(0.0), t), sphere.at(at(1e-9), t), 1e-14);
        }
        if let Side::Convection { ambient, .. } = side {
            close(sphere.at(at(0.4), 1e6), ambient, 1e-12);
        }
    }
    // The plane Biot number rounds to that of an insulated surface.
    let still = sphere(Side::Convection { coefficient: 1e-18, ambient: 9.0 });
    for t in [0.001, 7.0] {
        close(still.at(at(0.3), t), 1.0, 1e-15);
    }
}
