use super::super::modes::SHORT;
use super::super::oscillating_slab::{fading, lasting, starting};
use super::*;

fn setup(amplitude: f64, angular_frequency: f64) -> OscillatingSlabSetup {
    OscillatingSlabSetup {
        axis: 2,
        from: 0.2,
        to: 1.1,
        mean: 3.0,
        amplitude,
        angular_frequency,
        right: -1.0,
        initial: 1.0,
        diffusivity: 0.3,
    }
}

fn slab(angular_frequency: f64) -> OscillatingSlab {
    OscillatingSlab::new(setup(0.8, angular_frequency))
}

fn at(place: f64) -> DVec3 {
    DVec3::new(0.4, -0.3, 0.2 + 0.9 * place)
}

#[test]
fn the_equation_is_satisfied() {
    let points = [0.03, 0.1, 0.3, 0.5, 0.7, 0.9].map(at);
    for frequency in [0.01, 1.0, 30.0, 300.0] {
        let solution = Solution::OscillatingSlab(slab(frequency));
        for t in [0.01f64, 0.02, 0.11, 0.9, 5.3] {
            let step = (1e-2 * t).min(0.05 / frequency);
            let found = residual(&solution, 3, 0.3, &points, (t, step));
            assert!(found < 2e-5, "{frequency} t = {t}: {found}");
            assert!(residual(&solution, 3, 0.33, &points, (t, step)) > 1e-2);
        }
    }
}

#[test]
fn the_faces_are_held() {
    for frequency in [0.01, 1.0, 30.0, 300.0] {
        let slab = slab(frequency);
        for t in [0.001, 0.02, 0.4, 7.0] {
            let left = 3.0 + 0.8 * (frequency * t).sin();
            assert_eq!(slab.at(at(0.0), t), left);
            assert_eq!(slab.at(at(-0.4), t), left);
            assert_eq!(slab.at(at(1.4), t), -1.0);
            // The formulas meet the values by themselves.
            close(slab.at(at(1e-13), t), left, 1e-10);
            close(slab.at(at(1.0 - 1e-13), t), -1.0, 1e-10);
        }
    }
}

#[test]
fn the_two_forms_agree() {
    for frequency in [1e-6, 0.01, 1.9, 2.1, 40.0, 1e3, 1e5, -40.0] {
        for time in [0.9 * SHORT, SHORT] {
            for place in [1e-3, 0.1, 0.4, 0.93] {
                let short = starting(place, time, frequency);
                let long = lasting(place, time, frequency) + fading(place, time, frequency);
                assert!((short - long).abs() < 1e-12, "{frequency} {place}: {short} {long}");
            }
        }
    }
}

#[test]
fn it_starts_from_the_initial_value() {
    for frequency in [0.01, 30.0, 3000.0] {
        for place in [0.1, 0.5, 0.9] {
            assert_eq!(slab(frequency).at(at(place), 0.0), 1.0);
            assert_eq!(slab(frequency).at(at(place), 1e-300), 1.0);
            close(slab(frequency).at(at(place), 1e-5), 1.0, 1e-12);
        }
        assert_eq!(slab(frequency).at(at(0.0), 0.0), 3.0);
    }
}

/// A fast swing runs in like exp(-k x) sin(w t - k x), k = sqrt(w / 2 D) (Carslaw and Jaeger 1959,
/// 2.6); a slow one bends the steady line.
#[test]
fn fast_and_slow_swings() {
    let (t, line) = (40.0, |place: f64| 3.0 - 4.0 * place);
    for place in [0.05, 0.2] {
        let depth = (600.0f64 / 0.6).sqrt() * 0.9 * place;
        let expected = line(place) + 0.8 * (-depth).exp() * (600.0 * t - depth).sin();
        close(slab(600.0).at(at(place), t), expected, 1e-11);
    }
    let slow = line(0.3) + 0.8 * 0.7 * (1e-4f64 * 9e3).sin();
    close(slab(1e-4).at(at(0.3), 9e3), slow, 1e-4);
    // Frequencies without end do not overflow.
    close(slab(1e12).at(at(0.3), 40.0), line(0.3), 1e-12);
}

#[test]
fn without_a_swing_it_is_the_slab() {
    let still = Slab::new(SlabSetup {
        axis: 2,
        from: 0.2,
        to: 1.1,
        left: Side::Value(3.0),
        right: Side::Value(-1.0),
        initial: 1.0,
        diffusivity: 0.3,
    });
    for setup in [setup(0.0, 30.0), setup(0.8, 0.0)] {
        let slab = OscillatingSlab::new(setup);
        for (place, t) in [(0.0, 0.3), (0.2, 0.003), (0.5, 0.3), (1.0, 4.0)] {
            assert_eq!(slab.at(at(place), t), still.at(at(place), t));
        }
    }
}
