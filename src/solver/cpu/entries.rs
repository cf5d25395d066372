//! The neighbours of a particle, as operators have them.

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

    /// Whether all that the lines of the particle in a place go over has its value.
    #[inline(always)]
    pub(super) fn are_all<T: Copy + PartialEq>(&self, place: usize, values: &[T]) -> bool {
        let (start, own) = (self.start(place), values[place]);
        self.ahead.iter().all(|ahead| {
            let line = values.get(start + ahead..start + ahead + LANES);
            line.is_some_and(|line| line.iter().fold(true, |all, value| all & (*value == own)))
        })
    }

    /// Calls `visit(b, w_ab)` for the neighbours of the particle in a place.
    #[inline(always)]
    pub(super) fn for_each(&self, place: usize, mut visit: impl FnMut(usize, f64)) {
        let start = self.start(place);
        for (ahead, weights) in self.all() {
            let there = weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
            there.for_each(|(x, weight)| visit(start + ahead + x, *weight));
        }
    }
}

/// Where the neighbours of a particle were looked up last, which is near that of the next as a rule.
#[derive(Debug, Default)]
pub(super) struct Near {
    /// Among the rows of some places.
    pub(super) row: usize,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_tell_what_they_go_over() {
        let lines = Lines::of(&[(-11, 1.0), (-10, 2.0), (-1, 1.0), (1, 1.0), (10, 2.0)]);
        assert_eq!(lines.ahead, [0, 10, 21]);
        let mut values = vec![7; 60];
        assert!(lines.are_all(20, &values));
        // The last line ends with place 33.
        for (place, is_in) in [(8, false), (9, true), (33, true), (34, false)] {
            values[place] = 8;
            assert_eq!(lines.are_all(20, &values), !is_in, "{place}");
            values[place] = 7;
        }
        assert!(!lines.are_all(47, &values), "lines end past the last place");
    }
}
