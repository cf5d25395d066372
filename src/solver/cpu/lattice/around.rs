//! What is around the sites of a lattice.

use crate::model::lattice::LatticeScene;
use crate::solver::cpu::entries::{Entries, Lines};

/// The neighbours of all sites: the same for those of one kind.
#[derive(Clone, Debug)]
pub(in crate::solver::cpu) struct Around {
    /// By kind.
    lines: Vec<Lines>,
    /// The sites that are no nearer to an end than the stencil reaches, along each axis: from the first on, so many.
    inner: [[usize; 2]; 3],
    /// The kind of these, if there are any.
    of_inner: usize,
    /// The counts along the first two axes.
    counts: [Divisor; 2],
}

impl Around {
    pub(super) fn of(scene: &LatticeScene) -> Self {
        let inner = [0, 1, 2].map(|axis| match axis < scene.dimension {
            true => [scene.reach, scene.counts[axis].saturating_sub(2 * scene.reach)],
            false => [0, 1],
        });
        let [nx, ny, _] = scene.counts;
        let lines = |[x, y, z]: [usize; 3]| {
            let (site, mut entries) = ((z * ny + y) * nx + x, Vec::new());
            let step = |other: usize| other as isize - site as isize;
            scene.entries(site, |other, weight| entries.push((step(other), weight)));
            entries.sort_unstable_by_key(|&(step, _)| step);
            Lines::of(&entries)
        };
        let lines = scene.kinds().map(lines).collect();
        let of_inner = scene.kind(inner.map(|[first, _]| first));
        Self { lines, inner, of_inner, counts: [nx, ny].map(Divisor::new) }
    }

    /// Which [`Self::lines`] go over the neighbours of a site of `scene`.
    #[inline(always)]
    pub(super) fn which(&self, scene: &LatticeScene, site: usize) -> usize {
        let [nx, ny] = self.counts;
        let line = nx.quotient(site);
        let z = ny.quotient(line);
        let at = [site - line * nx.by, line - z * ny.by, z];
        let is_within = |([first, count], at): ([usize; 2], usize)| at.wrapping_sub(first) < count;
        match self.inner.into_iter().zip(at).all(is_within) {
            true => self.of_inner,
            false => scene.kind(at),
        }
    }

    /// Those that sites share.
    #[inline(always)]
    pub(super) fn lines(&self) -> &[Lines] {
        &self.lines
    }

    /// The neighbours of a site of `scene`, with weights times a factor.
    #[inline(always)]
    pub(super) fn entries(&self, scene: &LatticeScene, site: usize, factor: f64) -> Entries<'_> {
        Entries::Lines(&self.lines[self.which(scene, site)], factor)
    }
}

/// A number below 2^32 that others below 2^32 are divided by: with a product, which is faster (Granlund and
/// Montgomery 1994, Proc. PLDI, 61).
#[derive(Clone, Copy, Debug)]
struct Divisor {
    by: usize,
    /// 2^64 / by, rounded up.
    inverse: u128,
}

impl Divisor {
    fn new(by: usize) -> Self {
        Self { by, inverse: (1_u128 << 64).div_ceil(by as u128) }
    }

    /// The quotient, rounded down.
    #[inline(always)]
    fn quotient(self, of: usize) -> usize {
        ((of as u128 * self.inverse) >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_are_exact() {
        let most = u32::MAX as usize;
        for by in [1, 2, 3, 7, 100, 641, 65_535, 65_536, 65_537, most - 1, most] {
            let divisor = Divisor::new(by);
            for near in [0, by, 2 * by, 99 * by, most / by * by, most] {
                for of in near.saturating_sub(2)..=(near + 2).min(most) {
                    assert_eq!(divisor.quotient(of), of / by, "{of} / {by}");
                }
            }
        }
    }
}
