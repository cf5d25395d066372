//! Lines that many places share.

use std::collections::HashMap;

use super::entries::Lines;

/// Different ones at most, which bounds their memory.
const MOST: usize = 1 << 12;
/// The same of a part, of which there are many at once.
const MOST_OF_PART: usize = 1 << 9;

/// Tells which of a few different [`Lines`] each of many places has.
pub(super) struct LinesFinder {
    most: usize,
    /// By how far neighbours are away, ascending, with the bits of their weights.
    found: HashMap<Vec<(isize, u64)>, u16>,
}

impl Default for LinesFinder {
    fn default() -> Self {
        Self { most: MOST, found: HashMap::new() }
    }
}

impl LinesFinder {
    /// One for a part of the places, which another [takes](Self::take).
    pub(super) fn of_part() -> Self {
        Self { most: MOST_OF_PART, ..Self::default() }
    }

    /// Which one goes over neighbours so many places away, with weights of these (1/s); `None` if there are too many
    /// different ones.
    pub(super) fn which(&mut self, neighbors: impl Iterator<Item = (isize, f64)>) -> Option<u16> {
        let mut key: Vec<_> = neighbors.map(|(step, weight)| (step, weight.to_bits())).collect();
        key.sort_unstable();
        self.add(key)
    }

    fn add(&mut self, key: Vec<(isize, u64)>) -> Option<u16> {
        if let Some(which) = self.found.get(&key) {
            return Some(*which);
        }
        let next = self.found.len();
        (next < self.most).then(|| *self.found.entry(key).or_insert(next as u16))
    }

    /// Adds those of another; tells which one each of them is here.
    pub(super) fn take(&mut self, other: Self) -> Vec<Option<u16>> {
        let mut here = vec![None; other.found.len()];
        for (key, which) in other.in_order() {
            here[which] = self.add(key);
        }
        here
    }

    /// All of them.
    pub(super) fn lines(self) -> Vec<Lines> {
        let lines = |(key, _): (Vec<(isize, u64)>, usize)| {
            let entry = |(step, weight)| (step, f64::from_bits(weight));
            Lines::of(&key.into_iter().map(entry).collect::<Vec<_>>())
        };
        self.in_order().map(lines).collect()
    }

    /// In the order in which they were found.
    fn in_order(self) -> impl Iterator<Item = (Vec<(isize, u64)>, usize)> {
        let found = self.found.into_iter().map(|(key, which)| (key, usize::from(which)));
        let mut found: Vec<_> = found.collect();
        found.sort_unstable_by_key(|&(_, which)| which);
        found.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_that_are_as_far_and_weigh_as_much_share_lines() {
        let mut all = LinesFinder::default();
        let row = [(-1, 2.0), (7, 0.1), (1, 2.0)];
        assert_eq!(all.which(row.into_iter()), Some(0));
        assert_eq!(all.which(row.into_iter().rev()), Some(0));
        assert_eq!(all.which([(-1, 2.0), (7, 0.1_f64.next_up()), (1, 2.0)].into_iter()), Some(1));
        let mut others = LinesFinder::default();
        others.which(row[..2].iter().copied());
        others.which(row.into_iter());
        assert_eq!(all.take(others), [Some(2), Some(0)]);
        let lines = all.lines();
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[0], Lines::of(&[(-1, 2.0), (1, 2.0), (7, 0.1)]));
        assert_eq!(lines[2], Lines::of(&[(-1, 2.0), (7, 0.1)]));
    }

    #[test]
    fn too_many_are_none() {
        let mut all = LinesFinder::default();
        for step in 0..MOST {
            assert!(all.which([(step as isize, 1.0)].into_iter()).is_some());
        }
        assert_eq!(all.which([(-1, 1.0)].into_iter()), None);
        assert_eq!(all.which([(3, 1.0)].into_iter()), Some(3));
        let mut part = LinesFinder::of_part();
        for step in 0..MOST_OF_PART as isize {
            assert!(part.which([(step - 1, 1.0)].into_iter()).is_some());
        }
        assert_eq!(part.which([(-2, 1.0)].into_iter()), None);
        assert_eq!(all.take(part)[..3], [None, Some(0), Some(1)]);
    }
}
