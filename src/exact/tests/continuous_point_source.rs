use std::f64::consts::PI;

use super::super::exponential_integral::exponential_integral;
use super::*;

fn source(dimension: usize) -> ContinuousPointSource {
    let at = point(dimension, [0.3, 0.6, 0.5]);
    ContinuousPointSource { dimension, power: 2.0, at, initial: 1.5, diffusivity: 0.3 }
}

/// The power series summed with 80 digits; up to 10 also in Abramowitz and Stegun (1964), table 5.1.
#[test]
fn values_of_the_exponential_integral() {
    for (x, expected) in [
        (1e-8, 17.843_465_089_050_833),
        (0.01, 4.037_929_576_538_114),
        (0.5, 0.559_773_594_776_160_8),
        (1.0, 0.219_383_934_395_520_27),
        (1.000_000_1, 0.219_383_897_607_579_84),
        (1.5, 0.100_019_582_406_632_65),
        (2.0, 0.048_900_510_708_061_12),
        (5.0, 0.001_148_295_591_275_325_8),
        (10.0, 4.156_968_929_685_324e-6),
        (30.0, 3.021_552_010_688_812_5e-15),
    ] {
        close(exponential_integral(x) / expected, 1.0, 2e-15);
    }
    assert_eq!(exponential_integral(0.0), f64::INFINITY);
    assert_eq!([1e4, f64::MAX, f64::INFINITY].map(exponential_integral), [0.0; 3]);
}

#[test]
fn it_satisfies_the_equation() {
    for dimension in 1..=3 {
        let points = [[0.42, 0.71, 0.37], [0.2, 0.4, 0.9]].map(|x| point(dimension, x));
        let solution = Solution::ContinuousPointSource(source(dimension));
        assert!(solution.allows_sources());
        for t in [0.02, 0.11, 0.9] {
            let found = residual(&solution, dimension, 0.3, &points, (t, 1e-2 * t));
            assert!(found < 1e-5, "{dimension}-D t = {t}: {found}");
            assert!(residual(&solution, dimension, 0.33, &points, (t, 1e-2 * t)) > 1e-2);
        }
    }
}

#[test]
fn it_is_the_sum_of_instantaneous_sources() {
    for dimension in 1..=3 {
        let lasting = source(dimension);
        let ContinuousPointSource { at, diffusivity, .. } = lasting;
        let sudden = PointSource { dimension, amount: 2.0, at, diffusivity, porosity: 1.0 };
        let x = at + point(dimension, [0.2, 0.3, -0.1]);
        for t in [0.02f64, 0.2, 3.0] {
            // In the square root of time since the release, which smooths the start.
            let released = |root: f64| 2.0 * root * sudden.at(x, root * root);
            let expected = integral(released, 0.0, t.sqrt());
            close((lasting.at(x, t) - 1.5) / expected, 1.0, 1e-9);
        }
    }
}

#[test]
fn what_entered_is_there() {
    for dimension in 1..=3 {
        let source = ContinuousPointSource { at: DVec3::ZERO, ..source(dimension) };
        for t in [0.02, 0.7] {
            let surface = |r: f64| [2.0, 2.0 * PI * r, 4.0 * PI * r * r][dimension - 1];
            // In the square root of the radius, near which the logarithm is smooth enough.
            let shell = |root: f64| {
                let radius = root * root;
                let rise = source.at(radius * DVec3::X, t) - 1.5;
                2.0 * root * surface(radius) * rise
            };
            let end = 16.0 * (0.3f64 * t).sqrt();
            let found = integral(shell, 1e-9, end.sqrt());
            close(found / (2.0 * t), 1.0, 1e-8);
            // Negative control: of twice the power.
            assert!((found / (4.0 * t) - 1.0).abs() > 0.4);
        }
    }
}

#[test]
fn ends_of_time_and_space() {
    for dimension in 1..=3 {
        let source = source(dimension);
        let x = source.at + 0.2 * DVec3::X;
        assert_eq!([-1.0, 0.0, 1e-300].map(|t| source.at(x, t)), [1.5; 3]);
        assert_eq!(source.at(source.at, 0.0), 1.5);
        let idle = ContinuousPointSource { power: 0.0, ..source.clone() };
        assert_eq!([0.0, 0.4].map(|t| idle.at(idle.at, t)), [1.5; 2]);
        let sink = ContinuousPointSource { power: -2.0, ..source.clone() };
        close(source.at(x, 0.4) + sink.at(x, 0.4), 3.0, 1e-15);
        let (at_source, at_sink) = (source.at(source.at, 0.4), sink.at(sink.at, 0.4));
        if dimension == 1 {
            close(at_source, 1.5 + 2.0 * (0.4 / (0.3 * PI)).sqrt(), 1e-15);
        } else {
            assert_eq!((at_source, at_sink), (f64::INFINITY, -f64::INFINITY));
        }
    }
    // In 3-D it comes to rest.
    let (source, x) = (source(3), DVec3::new(0.3, 0.6, 0.7));
    close(source.at(x, 1e30), 1.5 + 2.0 / (4.0 * PI * 0.3 * 0.2), 1e-12);
}
