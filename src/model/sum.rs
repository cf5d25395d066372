//! Sums that keep what rounding loses.

/// A running sum with compensation (Neumaier 1974, Z. Angew. Math. Mech. 54, 39): the rounding error of every addition is kept and
/// added at the end, so the result of 1e8 terms is as good as that of a few.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    /// Adds one term.
    pub fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() {
            (self.sum - sum) + term
        } else {
            (term - sum) + self.sum
        };
        self.sum = sum;
    }

    /// Adds the terms of another sum.
    pub fn merge(&mut self, other: Self) {
        self.add(other.sum);
        self.add(other.lost);
    }

    /// The sum of the terms so far. Not finite as soon as one term was not.
    pub fn value(self) -> f64 {
        self.sum + self.lost
    }
}
