//! The axis of a plot: range, scale, and the text of its ticks.

use std::ops::Range;

/// An axis: its range, its scale, and how its ticks are written.
pub(super) struct Axis {
    low: f64,
    high: f64,
    /// Power of ten that is taken out of the ticks and named in the label instead.
    exponent: i32,
    /// Digits after the point that the ticks need to differ.
    decimals: usize,
    /// How many ticks, about.
    pub(super) labels: usize,
}

impl Axis {
    /// An axis over the finite ones of `values`, with about `labels` ticks.
    pub(super) fn over(values: impl Iterator<Item = f64>, labels: usize) -> Self {
        let (mut low, mut high) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let magnitude = low.abs().max(high.abs());
        let power = if magnitude > 0.0 { magnitude.log10().floor() as i32 } else { 0 };
        let exponent = if (-3..5).contains(&power) { 0 } else { power };
        let mut axis = Self { low, high, exponent, decimals: 0, labels };
        (axis.low, axis.high) = (axis.scaled(low), axis.scaled(high));
        let size = axis.low.abs().max(axis.high.abs());
        // Without an extent of its own (a constant, up to rounding) the axis shows 5 % either way.
        let narrow = axis.high - axis.low <= 1e-9 * size;
        let margin = match (narrow, size > 0.0) {
            (true, false) => 1.0,
            (true, true) => 0.05 * size,
            (false, _) => 0.04 * (axis.high - axis.low),
        };
        axis.low -= margin;
        axis.high += margin;
        axis.decimals = decimals((axis.high - axis.low) / labels as f64);
        axis
    }

    /// The ends, scaled.
    pub(super) fn range(&self) -> Range<f64> {
        self.low..self.high
    }

    /// A value with the axis' power of ten taken out.
    pub(super) fn scaled(&self, value: f64) -> f64 {
        // In two steps, since 10^300 and 10^-300 would leave the range of f64 in one.
        value / 10f64.powi(self.exponent / 2) / 10f64.powi(self.exponent - self.exponent / 2)
    }

    /// The text of a tick at a scaled value.
    pub(super) fn tick(&self, scaled: f64) -> String {
        let text = format!("{scaled:.*}", self.decimals);
        let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
        if is_zero { "0".to_owned() } else { text.replace('-', "−") }
    }

    /// The axis' label with its power of ten: `error (×10⁻⁵)`.
    pub(super) fn named(&self, label: &str) -> String {
        if self.exponent == 0 {
            return label.to_owned();
        }
        let raised = |c: char| match c.to_digit(10) {
            Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
            None => '⁻',
        };
        let power: String = self.exponent.to_string().chars().map(raised).collect();
        format!("{label} (×10{power})")
    }
}

/// Digits after the point of the first of 1, 2, 5, 10, ... times a power of ten from `step` up.
fn decimals(step: f64) -> usize {
    let power = step.log10().floor();
    let next = if step / 10f64.powf(power) > 5.0 { power + 1.0 } else { power };
    (-next).clamp(0.0, 12.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_suit_the_range() {
        let axis = |low: f64, high: f64| Axis::over([low, f64::NAN, high].into_iter(), 8);
        let wide = axis(0.0, 1000.0);
        assert_eq!((wide.tick(200.0), wide.named("T (K)")), ("200".into(), "T (K)".into()));
        let small = axis(-3e-5, 3e-5);
        assert_eq!(small.named("error"), "error (×10⁻⁵)");
        assert_eq!((small.tick(-1.0), small.tick(-1e-17)), ("−1".into(), "0".into()));
        let offset = axis(1000.0, 1000.004);
        assert_ne!(offset.tick(1000.001), offset.tick(1000.002));
        let constant = axis(1000.0, 1000.0).range();
        assert!((constant.start - 950.0).abs() < 1e-9 && (constant.end - 1050.0).abs() < 1e-9);
    }
}
