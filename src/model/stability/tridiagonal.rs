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
