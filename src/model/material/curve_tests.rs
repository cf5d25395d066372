//! Enthalpy, temperature and potential belong together.

use super::*;

/// Steel-like: k straight in T in both phases, a wide melting range.
fn alloy() -> HeatCurve {
    let solid = Conductivity::of_points(vec![[300.0, 40.0], [800.0, 30.0], [1000.0, 32.0]]);
    let melting = Melting {
        solidus: 1200.0,
        liquidus: 1300.0,
        latent: 2e9,
        conductivity: Conductivity::of_points(vec![[1300.0, 25.0], [2000.0, 35.0]]),
        capacity: 5e6,
    };
    HeatCurve::new(&solid, 4e6, Some(&melting))
}

/// The metal of the melting rod: sharp, constant in each phase.
fn metal() -> HeatCurve {
    let capacity = 19300.0 * 129.0;
    let melting = Melting {
        solidus: 400.0,
        liquidus: 400.0,
        latent: 19300.0 * 63.7e3,
        conductivity: Conductivity::constant(1.1e-4 * capacity),
        capacity,
    };
    HeatCurve::new(&Conductivity::constant(1.28e-4 * capacity), capacity, Some(&melting))
}

fn enthalpies() -> impl Iterator<Item = f64> {
    (0..4000).map(|k| 250.0 + 0.7 * f64::from(k))
}

#[test]
fn temperature_and_potential_never_fall_and_have_no_jump() {
    for curve in [alloy(), metal()] {
        for (a, b) in enthalpies().zip(enthalpies().skip(1)) {
            let [rise, flow] =
                [HeatCurve::temperature, HeatCurve::potential].map(|f| f(&curve, b) - f(&curve, a));
            assert!(
                (0.0..1.0).contains(&rise) && (0.0..1.2).contains(&flow),
                "{a} to {b}: {rise} {flow}"
            );
        }
        let mut wrong = curve;
        wrong.segments.iter_mut().skip(1).for_each(|segment| segment.potential -= 5.0);
        let falls = |(a, b): (f64, f64)| wrong.potential(b) < wrong.potential(a) - 1.0;
        assert!(enthalpies().zip(enthalpies().skip(1)).any(falls), "a wrong curve is noticed");
    }
}

#[test]
fn the_potential_is_the_integral_of_the_conductivity() {
    let curve = alloy();
    let mut integral = 0.0;
    let from = curve.enthalpy(250.0);
    for (a, b) in enthalpies().zip(enthalpies().skip(1)) {
        // Simpson's rule over pieces of k(T), which is straight: the only error is in kinks.
        let k = |enthalpy: f64| curve.conductivity(enthalpy);
        let dt = curve.temperature(b) - curve.temperature(a);
        integral += (k(a) + 4.0 * k(0.5 * (a + b)) + k(b)) / 6.0 * dt / curve.reference();
        let found = curve.potential(b) - curve.potential(from);
        assert!((found - integral).abs() < 2e-3, "at {b}: {found}, {integral}");
    }
    assert!(integral > 1500.0);
}

#[test]
fn a_melting_range_takes_its_heat() {
    let curve = alloy();
    let [begins, ends] = curve.melting().expect("it melts");
    assert_eq!([curve.temperature(begins), begins], [1200.0, 1200.0]);
    assert!((curve.temperature(ends) - 1300.0).abs() < 1e-9);
    // Latent heat and what warms solid and liquid in equal parts, over 4e6.
    assert!((ends - begins - (500.0 + 1.125 * 100.0)).abs() < 1e-9);
    assert!((curve.enthalpy(1400.0) - (ends + 125.0)).abs() < 1e-9, "the liquid's capacity");
    assert_eq!(curve.liquid_fraction(begins), 0.0);
    assert_eq!(curve.liquid_fraction(0.5 * (begins + ends)), 0.5);
    assert_eq!(curve.liquid_fraction(ends + 1.0), 1.0);
}

#[test]
fn at_a_sharp_point_all_heat_is_latent() {
    let curve = metal();
    let [begins, ends] = curve.melting().expect("it melts");
    assert!((ends - begins - 63.7e3 / 129.0).abs() < 1e-9);
    for fraction in [0.0, 0.25, 1.0] {
        let enthalpy = begins + fraction * (ends - begins);
        assert!((curve.temperature(enthalpy) - 400.0).abs() < 1e-9);
        assert!((curve.potential(enthalpy) - 400.0).abs() < 1e-9);
    }
    assert_eq!(curve.slope(0.5 * (begins + ends)), 0.0);
    assert_eq!(curve.enthalpy(400.0), begins, "the solid's");
    assert!((curve.largest_slope() - 1.0).abs() < 1e-12);
    assert!((curve.potential(ends + 10.0) - (400.0 + 10.0 * 1.1 / 1.28)).abs() < 1e-9);
    assert_eq!(curve.potential(300.0), 300.0, "below melting all three are one");
}

#[test]
fn enthalpy_is_the_inverse_of_temperature() {
    for curve in [alloy(), metal()] {
        for t in [250.0, 300.0, 399.0, 850.0, 1000.0, 1250.0, 1301.0, 2500.0] {
            assert!((curve.temperature(curve.enthalpy(t)) - t).abs() < 1e-9, "{t}");
        }
    }
    let plain = HeatCurve::new(&Conductivity::constant(7.0), 3.0, None);
    for t in [-5.0, 0.0, 300.0] {
        assert_eq!([plain.enthalpy(t), plain.potential(t), plain.temperature(t)], [t; 3]);
    }
}
