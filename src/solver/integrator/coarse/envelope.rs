//! Small symmetric matrices that are solved with directly.

/// The lower triangle of a symmetric matrix, each row from its first entry that is not 0 on.
#[derive(Clone, Debug, Default)]
pub(super) struct Envelope {
    /// The first column of each row.
    first: Vec<usize>,
    /// Where each row starts in `entries`.
    start: Vec<usize>,
    entries: Vec<f64>,
}

/// Of the largest entry of a diagonal: below are no numbers, whatever the contrast.
const NOTHING: f64 = 1e-15;

impl Envelope {
    /// The matrix with `rows`, each its columns up to the diagonal with their entries, ascending.
    pub(super) fn new(rows: &[Vec<(usize, f64)>]) -> Self {
        let mut matrix = Self::default();
        for (row, entries) in rows.iter().enumerate() {
            let first = entries.first().map_or(row, |&(column, _)| column.min(row));
            let start = matrix.entries.len();
            matrix.first.push(first);
            matrix.start.push(start);
            matrix.entries.resize(start + row - first + 1, 0.0);
            for &(column, entry) in entries {
                matrix.entries[start + column - first] += entry;
            }
        }
        matrix
    }

    /// Row `row` from column `from` on, up to the diagonal.
    fn row(&self, row: usize, from: usize) -> &[f64] {
        let start = self.start[row];
        &self.entries[start + from - self.first[row]..=start + row - self.first[row]]
    }

    /// L with L L^T = `scale` x this + diag(`diagonal`), which is positive definite (Cholesky's method on the
    /// envelope: George and Liu 1981, chapter 4). Where a pivot is not above `least` of its own entry of the
    /// diagonal, the matrix is singular but for rounding: that unknown is 0.
    pub(super) fn factor(&self, scale: f64, diagonal: impl Fn(usize) -> f64, least: f64) -> Self {
        let mut l = self.clone();
        let own = |i: usize| scale * self.entries[self.start[i] + i - self.first[i]] + diagonal(i);
        let nothing = NOTHING * (0..self.first.len()).map(own).fold(0.0, f64::max);
        for i in 0..l.first.len() {
            let (first, start) = (l.first[i], l.start[i]);
            for j in first..i {
                let from = first.max(l.first[j]);
                let (of_i, of_j) = (l.row(i, from), l.row(j, from));
                let products = of_i.iter().zip(&of_j[..of_j.len() - 1]).map(|(a, b)| a * b);
                let known = scale * self.entries[start + j - first] - products.sum::<f64>();
                l.entries[start + j - first] = known / of_j[of_j.len() - 1];
            }
            let squares: f64 = l.entries[start..start + i - first].iter().map(|x| x * x).sum();
            let pivot = own(i) - squares;
            // What is divided by infinity is 0.
            l.entries[start + i - first] =
                if pivot > nothing.max(least * own(i)) { pivot.sqrt() } else { f64::INFINITY };
        }
        l
    }

    /// Solves L L^T x = b for this L, in place.
    pub(super) fn solve(&self, b: &mut [f64]) {
        for i in 0..self.first.len() {
            let (first, row) = (self.first[i], self.row(i, self.first[i]));
            let known: f64 = row.iter().zip(&b[first..i]).map(|(l, b)| l * b).sum();
            b[i] = (b[i] - known) / row[i - first];
        }
        for i in (0..self.first.len()).rev() {
            let (first, row) = (self.first[i], self.row(i, self.first[i]));
            b[i] /= row[i - first];
            let own = b[i];
            row.iter().zip(&mut b[first..i]).for_each(|(l, b)| *b -= l * own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nothing_determines_is_0() {
        // A difference of two, and one that nothing is coupled to.
        let rows = vec![vec![(0, 1.0)], vec![(0, -1.0), (1, 1.0)], vec![(2, 0.0)]];
        let factor = Envelope::new(&rows).factor(1.0, |_| 0.0, 1e-12);
        let mut b = [2.0, -2.0, 0.0];
        factor.solve(&mut b);
        assert_eq!(b, [2.0, 0.0, 0.0]);
    }

    #[test]
    fn a_system_with_a_gap_and_a_far_entry_is_solved() {
        // The second difference of five points, and one that couples the first and the last.
        let mut rows: Vec<Vec<(usize, f64)>> = vec![vec![(0, 2.0)]];
        rows.extend((1..5).map(|i| vec![(i - 1, -1.0), (i, 2.0)]));
        rows[4].insert(0, (0, -0.5));
        let matrix = Envelope::new(&rows);
        let factor = matrix.factor(3.0, |_| 1.0, 0.0);
        let exact = [1.0, -2.0, 0.5, 4.0, 3.0];
        let entry = |i: usize, j: usize| {
            let (i, j) = (i.max(j), i.min(j));
            let of_row: f64 = rows[i].iter().filter(|e| e.0 == j).map(|e| e.1).sum();
            3.0 * of_row + if i == j { 1.0 } else { 0.0 }
        };
        let mut b: Vec<f64> =
            (0..5).map(|i| (0..5).map(|j| entry(i, j) * exact[j]).sum()).collect();
        factor.solve(&mut b);
        assert!(b.iter().zip(&exact).all(|(x, e)| (x - e).abs() < 1e-12), "{b:?}");
    }
}
