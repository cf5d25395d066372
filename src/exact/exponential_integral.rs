//! The exponential integral.

/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;

/// E1(x) = int_x^inf exp(-s) / s ds for x >= 0, to a few units in the last place: the power series up to 1
/// (Abramowitz and Stegun 1964, 5.1.11), the continued fraction above (5.1.22, contracted), from its end.
pub(super) fn exponential_integral(x: f64) -> f64 {
    if x == 0.0 {
        return f64::INFINITY;
    }
    if x > 1.0 {
        // How many levels 1e-17 takes: 120 at x = 1, fewer the larger x.
        let levels = 20 + (100.0 / x) as u32;
        let below = |tail: f64, level: u32| {
            let level = f64::from(level);
            x + 2.0 * level - 1.0 - level * level / tail
        };
        let start = x + 2.0 * f64::from(levels) + 1.0;
        return (-x).exp() / (1..=levels).rev().fold(start, below);
    }
    let (mut sum, mut power) = (0.0, 1.0);
    for order in 1..=SERIES {
        let order = f64::from(order);
        power *= -x / order;
        sum -= power / order;
    }
    sum - EULER - x.ln()
}

/// Terms of the series: the first one left out is below 1e-20.
const SERIES: u32 = 19;
