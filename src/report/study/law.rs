//! Laws that an error is known to follow elsewhere.

use serde::{Deserialize, Serialize};

use super::StudyReport;

/// An error that falls with a power of the number n of particles along an axis: relative L2 =
/// factor x n^-order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, try_from = "Unchecked")]
pub struct ReferenceLaw {
    /// Whose it is, in short.
    pub label: String,
    /// The relative L2 at n = 1, positive.
    pub factor: f64,
    /// The order of accuracy.
    pub order: f64,
}

/// A law as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    label: String,
    factor: f64,
    order: f64,
}

impl TryFrom<Unchecked> for ReferenceLaw {
    type Error = String;

    fn try_from(Unchecked { label, factor, order }: Unchecked) -> Result<Self, String> {
        if !(factor.is_finite() && factor > 0.0) {
            return Err(format!("factor: is {factor}, must be positive"));
        }
        if !order.is_finite() {
            return Err(format!("order: is {order}, must be finite"));
        }
        Ok(Self { label, factor, order })
    }
}

impl ReferenceLaw {
    /// The relative L2 at `n` particles along an axis.
    pub fn at(&self, n: f64) -> f64 {
        self.factor * n.powf(-self.order)
    }

    /// What it is called in pictures: `label: 0.0715 n^-0.75`.
    pub(super) fn name(&self) -> String {
        format!("{}: {} n^{}", self.label, self.factor, -self.order)
    }
}

impl StudyReport {
    /// Particles along an axis of a body of `particles` of them, on average.
    pub(super) fn along_an_axis(&self, particles: u64) -> f64 {
        (particles as f64).powf(1.0 / self.dimension.max(1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: &str = r#"{"label": "theirs", "factor": 0.0715, "order": 0.75}"#;

    #[test]
    fn a_law_is_a_power_of_the_number_along_an_axis() {
        let law: ReferenceLaw = serde_json::from_str(LAW).expect("a law");
        assert!((law.at(16.0) - 0.0715 / 8.0).abs() < 1e-15);
        assert!((law.at(160.0) / law.at(16.0) - 10f64.powf(-0.75)).abs() < 1e-12);
        assert_eq!(law.name(), "theirs: 0.0715 n^-0.75");
    }

    #[test]
    fn a_law_that_makes_no_sense_is_refused() {
        for (from, to) in [("0.0715", "-1"), ("0.0715", "0"), ("order", "ordre")] {
            let broken = LAW.replacen(from, to, 1);
            assert!(serde_json::from_str::<ReferenceLaw>(&broken).is_err(), "{broken}");
        }
    }
}
