//! Some rows of the matrix in compressed form, and their product with a state.

use super::source_rows::SourceCursor;
use crate::model::wide::{Work, multiply_add, prefetch};

/// How many entries ahead of the one at hand are fetched: 4 KiB of weights, which is as far as a page and
/// so beyond what processors fetch by themselves. Half and twice as much are as good.
const AHEAD: usize = 512;

/// Rows in compressed form: row i has the columns `index[start[i]..start[i + 1]]`.
#[derive(Clone, Debug)]
pub(super) struct RowBlock {
    start: Vec<u32>,
    /// Ranks of the neighbours, each below the number of rows of the matrix.
    index: Vec<u32>,
    /// Weights w_ab, 1/s: those of pairs are never negative, what walls add to them may be.
    weight: Vec<f64>,
}

impl Default for RowBlock {
    fn default() -> Self {
        Self::with_capacity(0, 0)
    }
}

impl RowBlock {
    pub(super) fn with_capacity(rows: usize, entries: usize) -> Self {
        let mut start = Vec::with_capacity(rows + 1);
        start.push(0);
        Self { start, index: Vec::with_capacity(entries), weight: Vec::with_capacity(entries) }
    }

    pub(super) fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Adds an entry to the row that is open.
    pub(super) fn push(&mut self, rank: u32, weight: f64) {
        self.index.push(rank);
        self.weight.push(weight);
    }

    /// Closes the row that entries have been pushed to.
    pub(super) fn end_row(&mut self) {
        self.start.push(self.index.len() as u32);
    }

    /// Ranks of the neighbours of a row, and their weights.
    #[inline(always)]
    pub(super) fn entries(&self, row: usize) -> (&[u32], &[f64]) {
        let range = self.start[row] as usize..self.start[row + 1] as usize;
        (&self.index[range.clone()], &self.weight[range])
    }

    /// The same of every row.
    pub(super) fn rows(&self) -> impl Iterator<Item = (&[u32], &[f64])> {
        (0..self.len()).map(|row| self.entries(row))
    }

    pub(super) fn append(&mut self, other: &Self) {
        let base = self.index.len() as u32;
        self.start.extend(other.start[1..].iter().map(|start| base + start));
        self.index.extend(&other.index);
        self.weight.extend(&other.weight);
    }

    /// Keeps some of its rows.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        let mut kept = Self::default();
        for (row, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
            let (index, weight) = self.entries(row);
            kept.index.extend(index);
            kept.weight.extend(weight);
            kept.end_row();
        }
        kept.shrink();
        *self = kept;
    }

    pub(super) fn shrink(&mut self) {
        self.index.shrink_to_fit();
        self.weight.shrink_to_fit();
    }

    /// sum_b w_ab (C_b - C_a) of a row whose own value is `own`; `FUSED` as in [`Work::run`].
    ///
    /// Differences, not a product with a stored diagonal: a constant field has rate 0 exactly.
    /// Four sums run side by side, so that the chain of additions does not set the speed.
    #[inline(always)]
    #[allow(
        unsafe_code,
        reason = "checking the bounds of every neighbour costs a tenth to a fifth of the speed"
    )]
    pub(super) fn rate<const FUSED: bool>(&self, row: usize, own: f64, state: &[f64]) -> f64 {
        let (index, weight) = self.entries(row);
        let mut sum = [0.0_f64; 4];
        let (index, weight) = (index.chunks_exact(4), weight.chunks_exact(4));
        // The rest comes last, though it is known first: reading the end of a row before its
        // beginning would stall on memory that the processor has not fetched ahead.
        let (last_index, last_weight) = (index.remainder(), weight.remainder());
        // SAFETY, here and below: only `Walk::note` fills `index`, with ranks that it has looked up in
        // the order of the particles (`retain` keeps some of these), and callers have compared the
        // length of that with the length of `state`.
        for (b, w) in index.zip(weight) {
            prefetch(w.as_ptr().wrapping_add(AHEAD));
            prefetch(b.as_ptr().wrapping_add(AHEAD));
            for lane in 0..4 {
                let value = unsafe { *state.get_unchecked(b[lane] as usize) };
                sum[lane] = multiply_add::<FUSED>(w[lane], value - own, sum[lane]);
            }
        }
        let mut rest = 0.0;
        for (&b, &w) in last_index.iter().zip(last_weight) {
            let value = unsafe { *state.get_unchecked(b as usize) };
            rest = multiply_add::<FUSED>(w, value - own, rest);
        }
        (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
    }

    /// -sum_b w_ab of each row, 1/s.
    pub(super) fn diagonals(&self) -> impl Iterator<Item = f64> + '_ {
        let rows = self.start.windows(2).map(|row| row[0] as usize..row[1] as usize);
        rows.map(|row| -self.weight[row].iter().sum::<f64>())
    }

    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.start) + size_of_val(&*self.index) + size_of_val(&*self.weight)
    }
}

/// Writes `out[row] = combine(state, rate)` for the rows of a block, whose first rank is `first`.
pub(super) struct Advance<'a, C> {
    pub(super) block: &'a RowBlock,
    pub(super) walls: SourceCursor<'a>,
    pub(super) first: usize,
    pub(super) state: &'a [f64],
    pub(super) out: &'a mut [f64],
    pub(super) combine: C,
}

impl<C: Fn(f64, f64) -> f64> Work for Advance<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { block, mut walls, first, state, out, combine } = self;
        let mut done = 0;
        // Rows with walls are few: the others run without a look at them.
        while done < out.len() {
            let next = walls.next_rank().saturating_sub(first).min(out.len());
            for row in done..next {
                let own = state[first + row];
                out[row] = combine(own, block.rate::<FUSED>(row, own, state));
            }
            if next < out.len() {
                let own = state[first + next];
                out[next] = combine(own, block.rate::<FUSED>(next, own, state) + walls.take(own));
            }
            done = next + 1;
        }
    }
}
