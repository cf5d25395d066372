//! The neighbours of a particle, as operators have them.

use crate::model::wide::{multiply_add, sum_of};

/// Places of a line.
pub(super) const LANES: usize = 4;

/// Where the neighbours of a particle are from its own place, in lines: places that follow each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lines {
    /// How far the first line begins from the particle.
    first: isize,
    /// How far each begins from the first.
    ahead: Vec<usize>,
    /// Of each line, 1/s; 0 where there is no neighbour.
    weights: Vec<[f64; LANES]>,
}

impl Lines {
    /// Those of neighbours so many places away, which ascend, with their weights: the sum where one comes again.
    pub(super) fn of(entries: &[(isize, f64)]) -> Self {
        let first = entries.first().map_or(0, |&(step, _)| step);
        let mut lines = Self { first, ..Self::default() };
        for &(step, weight) in entries {
            let ahead = (step - first) as usize;
            if lines.ahead.last().is_none_or(|last| ahead >= last + LANES) {
                lines.ahead.push(ahead);
                lines.weights.push([0.0; LANES]);
            }
            let last = lines.ahead.len() - 1;
            lines.weights[last][ahead - lines.ahead[last]] += weight;
        }
        lines.ahead.shrink_to_fit();
        lines.weights.shrink_to_fit();
        lines
    }

    /// Where the first begins around a particle.
    #[inline(always)]
    pub(super) fn start(&self, place: usize) -> usize {
        place.wrapping_add_signed(self.first)
    }

    /// How far the last ends from where the first begins.
    #[inline(always)]
    pub(super) fn span(&self) -> usize {
        self.ahead.last().map_or(0, |last| last + LANES)
    }

    /// How far each begins from the first, and its weights.
    #[inline(always)]
    pub(super) fn all(&self) -> impl Iterator<Item = (&usize, &[f64; LANES])> {
        self.ahead.iter().zip(&self.weights)
    }

    /// sum_b w_ab (C_b - C_a) of the particle in a place, of a constant field exactly 0; all that the lines go over has
    /// a value.
    #[inline(always)]
    pub(super) fn rate<const FUSED: bool>(&self, place: usize, values: &[f64]) -> f64 {
        let (start, own) = (self.start(place), values[place]);
        let (around, mut sum) = (&values[start..start + self.span()], [0.0; LANES]);
        for (&ahead, weights) in self.all() {
            let line: &[f64; LANES] =
                around[ahead..ahead + LANES].try_into().expect("a line's length");
            for x in 0..LANES {
                sum[x] = multiply_add::<FUSED>(weights[x], line[x] - own, sum[x]);
            }
        }
        sum_of(sum)
    }

    /// A_aa where they are all neighbours, 1/s.
    pub(super) fn diagonal(&self) -> f64 {
        -self.weights.iter().flatten().sum::<f64>()
    }

    /// Calls `visit(b, w_ab)` for the neighbours of the particle in a place.
    #[inline(always)]
    pub(super) fn for_each(&self, place: usize, mut visit: impl FnMut(usize, f64)) {
        self.are_all(place, |other, weight| {
            visit(other, weight);
            true
        });
    }

    /// Whether `is_so(b, w_ab)` for all of them: those behind one of which it is not are not asked for.
    #[inline(always)]
    fn are_all(&self, place: usize, mut is_so: impl FnMut(usize, f64) -> bool) -> bool {
        let start = self.start(place);
        self.all().all(|(ahead, weights)| {
            let mut there = weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
            there.all(|(x, weight)| is_so(start + ahead + x, *weight))
        })
    }

    /// Bytes that some of them hold.
    pub(super) fn all_bytes(all: &[Self]) -> usize {
        let held = |one: &Self| size_of_val(&*one.ahead) + size_of_val(&*one.weights);
        size_of_val(all) + all.iter().map(held).sum::<usize>()
    }
}

/// Where the neighbours of a particle were looked up last, which is near that of the next as a rule.
#[derive(Debug, Default)]
pub(super) struct Near {
    /// Among the rows of some places.
    pub(super) row: usize,
    /// Among rows that share lines, and those of them beside seams.
    pub(super) shared: usize,
    pub(super) beside_seams: usize,
    /// Among parts of different factors.
    pub(super) part: usize,
}

/// The neighbours of a particle with their weights, 1/s; what walls add to weights is part of them.
pub(super) enum Entries<'a> {
    /// In lines, and all weights times a factor.
    Lines(&'a Lines, f64),
    /// Places and weights.
    Row(&'a [u32], &'a [f64]),
}

impl Entries<'_> {
    /// The neighbours of the particle in a place, and their weights, 1/s.
    pub(super) fn to_vec(&self, place: usize) -> Vec<(usize, f64)> {
        let mut all = Vec::new();
        self.are_all(place, |other, weight| {
            all.push((other, weight));
            true
        });
        all
    }

    /// Whether `is_so(b, w_ab)` for all neighbours of the particle in a place: those behind one of which it is not are
    /// not asked for.
    pub(super) fn are_all(&self, place: usize, mut is_so: impl FnMut(usize, f64) -> bool) -> bool {
        match self {
            Self::Lines(lines, factor) => {
                lines.are_all(place, |other, weight| is_so(other, factor * weight))
            }
            Self::Row(others, weights) => {
                let mut entries = others.iter().zip(*weights);
                entries.all(|(&other, &weight)| is_so(other as usize, weight))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_less_than_a_line_apart_are_in_one() {
        let entries = [(-11, 1.0), (-10, 2.0), (-1, 1.0), (1, 1.5), (1, 0.5), (10, 2.0)];
        let lines = Lines::of(&entries);
        assert_eq!(lines.ahead, [0, 10, 21]);
        assert_eq!((lines.start(20), lines.span()), (9, 25));
        let mut found = Vec::new();
        lines.for_each(20, |other, weight| found.push((other, weight)));
        assert_eq!(found, [(9, 1.0), (10, 2.0), (19, 1.0), (21, 2.0), (30, 2.0)]);
        let values: Vec<f64> = (0..40).map(|place| f64::from(place * place)).collect();
        let expected: f64 = found.iter().map(|&(b, w)| w * (values[b] - values[20])).sum();
        assert_eq!(lines.rate::<false>(20, &values), expected);
        assert_eq!(lines.rate::<false>(20, &[7.0; 40]), 0.0);
        assert_eq!(lines.diagonal(), -8.0);
    }
}
