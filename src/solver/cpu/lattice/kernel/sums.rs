//! The sums of a run, P_0 and Q_i, to which the lines around it are added one after the other.

use crate::model::lattice::WIDEST;
use crate::model::wide::multiply_add;

/// What the differences to lines are added to.
pub(super) struct Sums<'a, const REACH: usize> {
    pub(super) own: &'a [f64],
    /// P_0
    pub(super) here: &'a mut [f64],
    /// Q_1, Q_2, ...
    pub(super) steps: [&'a mut [f64]; REACH],
    /// K_1, K_2, ...
    pub(super) along: [f64; REACH],
    /// Whether nothing has been written.
    pub(super) is_new: bool,
}

impl<const REACH: usize> Sums<'_, REACH> {
    /// Adds some groups of N lines, each with its weights and the factor of its values.
    #[inline(always)]
    pub(super) fn add<const GROUPS: usize, const N: usize, const FUSED: bool>(
        &mut self,
        lines: &[[&[f64]; N]; GROUPS],
        factor: f64,
        weights: &[[f64; WIDEST + 1]; GROUPS],
    ) {
        match std::mem::take(&mut self.is_new) {
            true => self.write::<GROUPS, N, true, FUSED>(lines, factor, weights),
            false => self.write::<GROUPS, N, false, FUSED>(lines, factor, weights),
        }
    }

    #[inline(always)]
    fn write<const GROUPS: usize, const N: usize, const NEW: bool, const FUSED: bool>(
        &mut self,
        lines: &[[&[f64]; N]; GROUPS],
        factor: f64,
        weights: &[[f64; WIDEST + 1]; GROUPS],
    ) {
        // No closures where it counts: they would be compiled without the caller's instructions.
        let n = self.own.len();
        let (own, here, along) = (&self.own[..n], &mut self.here[..n], self.along);
        let steps = self.steps.each_mut().map(|sum| &mut sum[..n]);
        let lines = lines.map(|group| group.map(|line| &line[..n]));
        for x in 0..n {
            let own = own[x];
            let mut sums = [0.0; WIDEST + 1];
            if NEW {
                for k in 0..REACH {
                    sums[k + 1] = along[k] * own;
                }
            } else {
                sums[0] = here[x];
                for k in 0..REACH {
                    sums[k + 1] = steps[k][x];
                }
            }
            for group in 0..GROUPS {
                let sum = sum_of(&lines[group], x);
                // Some equal values have a sum whose difference to as many times one is 0.
                let difference = match N {
                    1 => multiply_add::<FUSED>(factor, sum, -own),
                    _ => multiply_add::<FUSED>(-(N as f64), own, sum),
                };
                for k in 0..REACH + 1 {
                    sums[k] = multiply_add::<FUSED>(weights[group][k], difference, sums[k]);
                }
            }
            here[x] = sums[0];
            for k in 0..REACH {
                steps[k][x] = sums[k + 1];
            }
        }
    }
}

/// The sum of one, two or four lines at a place: of equal values without a rounding error.
#[inline(always)]
fn sum_of<const N: usize>(lines: &[&[f64]; N], x: usize) -> f64 {
    match N {
        4 => (lines[0][x] + lines[1][x]) + (lines[2][x] + lines[3][x]),
        2 => lines[0][x] + lines[1][x],
        _ => lines[0][x],
    }
}
