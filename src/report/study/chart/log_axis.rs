//! A logarithmic axis: its range, its ticks and their texts.

/// Room beyond the values, as a part of the range.
const MARGIN: f64 = 0.06;

/// The least range, in decades.
const LEAST: f64 = 0.4;

/// A logarithmic axis over positive values.
pub(in crate::report::study) struct LogAxis {
    name: String,
    /// How a value is written.
    text: fn(f64) -> String,
    /// The ends, as logarithms to the base 10.
    low: f64,
    high: f64,
    /// How many labels it has room for.
    most: usize,
}

/// A line across the plot, with a label or without.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) labelled: bool,
}

impl LogAxis {
    /// An axis over the positive and finite ones of `values`, with room for about `most` labels.
    pub(in crate::report::study) fn over(
        name: impl Into<String>,
        text: fn(f64) -> String,
        values: impl Iterator<Item = f64>,
        most: usize,
    ) -> Self {
        let (mut low, mut high) = values
            .filter(|value| is_drawable(*value))
            .map(f64::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (-1.0, 0.0);
        }
        let margin = (MARGIN * (high - low)).max(0.5 * (LEAST - (high - low))).max(0.04);
        Self { name: name.into(), text, low: low - margin, high: high + margin, most }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn low(&self) -> f64 {
        10f64.powf(self.low)
    }

    pub(super) fn text(&self, value: f64) -> String {
        (self.text)(value)
    }

    /// How far along the axis a value is, 0 to 1.
    pub(super) fn part(&self, value: f64) -> f64 {
        ((value.log10() - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// The ticks: as many multiples of powers of ten as there is room for.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        const FINEST: [&[f64]; 4] =
            [&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]];
        let fits = |multiples: &&&[f64]| self.values(multiples, 1).len() <= self.most;
        if let Some(multiples) = FINEST.iter().find(fits) {
            let labelled = |value| Tick { value, labelled: true };
            return self.values(multiples, 1).into_iter().map(labelled).collect();
        }
        let every = (2..).find(|every| self.values(&[1.0], *every).len() <= self.most);
        let labelled = self.values(&[1.0], every.unwrap_or(1));
        let all = self.values(&[1.0], 1);
        all.into_iter().map(|value| Tick { value, labelled: labelled.contains(&value) }).collect()
    }

    /// The multiples of every `every`-th power of ten within the range.
    fn values(&self, multiples: &[f64], every: i32) -> Vec<f64> {
        let powers = self.low.floor() as i32..=self.high.ceil() as i32;
        let powers = powers.filter(|power| power.rem_euclid(every) == 0);
        let all = powers.flat_map(|power| multiples.iter().map(move |m| m * 10f64.powi(power)));
        all.filter(|value| (self.low..=self.high).contains(&value.log10())).collect()
    }
}

/// Whether a value has a place on a logarithmic axis.
pub(in crate::report::study) fn is_drawable(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(low: f64, high: f64) -> LogAxis {
        LogAxis::over("x", |x| format!("{x}"), [low, f64::NAN, 0.0, high].into_iter(), 9)
    }

    fn labels(axis: &LogAxis) -> Vec<f64> {
        axis.ticks().iter().filter(|tick| tick.labelled).map(|tick| tick.value).collect()
    }

    #[test]
    fn ticks_suit_the_range() {
        assert_eq!(labels(&axis(1.0, 9.0)), [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0]);
        assert_eq!(labels(&axis(1e-3, 9e-2)).len(), 7);
        assert_eq!(labels(&axis(1e-6, 1.0)).len(), 7);
        let wide = axis(1e-15, 1e9);
        assert!((5..=9).contains(&labels(&wide).len()) && wide.ticks().len() > 20);
        assert!(!labels(&axis(2.0, 2.0)).is_empty(), "one value has an axis too");
    }

    #[test]
    fn values_have_their_place() {
        let axis = axis(1e-2, 1.0);
        assert!((axis.part(0.1) - 0.5).abs() < 1e-12);
        assert!(axis.part(1e-2) > 0.0 && axis.part(1.0) < 1.0, "marks are not on the edge");
        assert_eq!(axis.part(0.0), 0.0);
    }
}
