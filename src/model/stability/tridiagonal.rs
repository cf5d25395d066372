//! Eigenvalues of the small matrices that a Lanczos iteration makes.

/// A symmetric tridiagonal matrix.
#[derive(Clone, Debug, Default)]
pub struct Tridiagonal {
    diagonal: Vec<f64>,
    off_diagonal: Vec<f64>,
}

impl Tridiagonal {
    /// Adds a row with `diagonal`, and `beside` between it and the one before.
    pub fn extend(&mut self, beside: f64, diagonal: f64) {
        if !self.diagonal.is_empty() {
            self.off_diagonal.push(beside);
        }
        self.diagonal.push(diagonal);
    }

    /// The largest eigenvalue and the last component of its normalised eigenvector.
    pub fn largest(&self) -> (f64, f64) {
        let (diagonal, off_diagonal) = (&self.diagonal[..], &self.off_diagonal[..]);
        let beta = |i: usize| off_diagonal.get(i).copied().unwrap_or(0.0);
        let radius = |i: usize| beta(i) + if i > 0 { beta(i - 1) } else { 0.0 };
        let mut high =
            (0..diagonal.len()).map(|i| diagonal[i] + radius(i)).fold(f64::MIN, f64::max);
        let mut low = diagonal.iter().copied().fold(f64::MIN, f64::max);
        while high - low > 1e-13 * high.abs() {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if is_above_all(diagonal, off_diagonal, middle) { high = middle } else { low = middle }
        }
        // The eigenvector by the three-term recurrence, scaled as it goes so that it stays finite.
        let (mut before, mut here, mut squares) = (0.0_f64, 1.0_f64, 1.0_f64);
        for (i, alpha) in diagonal[..diagonal.len() - 1].iter().enumerate() {
            let back = if i > 0 { beta(i - 1) * before } else { 0.0 };
            let next = ((high - alpha) * here - back) / beta(i);
            (before, here) = (here, next);
            squares += next * next;
            if squares > 1e200 {
                (before, here, squares) = (before * 1e-100, here * 1e-100, squares * 1e-200);
            }
        }
        (high, here / squares.sqrt())
    }

    /// The normalised eigenvector of the largest eigenvalue, by inverse iteration: that stays accurate
    /// where components span many orders of magnitude. What is beside the diagonal has to be positive, as a
    /// Lanczos iteration makes it: then all components have one sign, and any positive start will do.
    pub fn largest_vector(&self) -> Vec<f64> {
        let (value, _) = self.largest();
        let scale = self.diagonal.iter().fold(f64::MIN_POSITIVE, |most, x| x.abs().max(most));
        // Just above every eigenvalue, where all pivots of T - x I are negative.
        let above = value + 1e-13 * scale;
        let mut vector = vec![1.0; self.diagonal.len()];
        for _ in 0..4 {
            self.solve_shifted(above, &mut vector);
            let norm = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|x| *x /= norm);
        }
        vector
    }

    /// Solves (x I - T) y = `right` in place, for x = `above` every eigenvalue (Thomas' elimination).
    fn solve_shifted(&self, above: f64, right: &mut [f64]) {
        let n = right.len();
        let mut pivot = vec![above - self.diagonal[0]; n];
        for i in 1..n {
            let factor = self.off_diagonal[i - 1] / pivot[i - 1];
            pivot[i] = above - self.diagonal[i] - factor * self.off_diagonal[i - 1];
            right[i] += factor * right[i - 1];
        }
        right[n - 1] /= pivot[n - 1];
        for i in (0..n - 1).rev() {
            right[i] = (right[i] + self.off_diagonal[i] * right[i + 1]) / pivot[i];
        }
    }
}

/// Whether `x` is above every eigenvalue (Sturm: all pivots of T - x I are negative).
fn is_above_all(diagonal: &[f64], off_diagonal: &[f64], x: f64) -> bool {
    let mut pivot = diagonal[0] - x;
    for i in 1..diagonal.len() {
        if pivot >= 0.0 {
            return false;
        }
        pivot = diagonal[i] - x - off_diagonal[i - 1] * off_diagonal[i - 1] / pivot;
    }
    pivot < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_vector_is_an_eigenvector() {
        // Eigenvalues 2 + 2 cos(k pi / (n + 1)).
        let mut matrix = Tridiagonal::default();
        (0..40).for_each(|_| matrix.extend(1.0, 2.0));
        let (value, _) = matrix.largest();
        let vector = matrix.largest_vector();
        let last = (2.0_f64 / 41.0).sqrt() * (std::f64::consts::PI / 41.0).sin();
        assert!((vector[39].abs() - last).abs() < 1e-9);
        for i in 0..40 {
            let beside = |j: Option<usize>| j.and_then(|j| vector.get(j)).copied().unwrap_or(0.0);
            let product = 2.0 * vector[i] + beside(i.checked_sub(1)) + beside(Some(i + 1));
            assert!((product - value * vector[i]).abs() < 1e-9, "{i}");
        }
    }
}
