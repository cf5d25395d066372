//! The neighbours to which flows of fronts go where materials or capacities differ, in lines.

use rayon::prelude::*;

use crate::solver::cpu::entries::{Entries, Lines, Near};
use crate::solver::cpu::operator::CpuOperator;
use crate::solver::cpu::shared_lines::LinesFinder;

/// Places that one parallel task looks at.
const TASK: usize = 1 << 14;
/// Of a place that has none.
const NONE: u16 = u16::MAX;

/// The neighbours of particles that are of their materials, where all these are of their capacities.
pub(super) struct OwnLines {
    /// By place: which one, or [`NONE`].
    of: Vec<u16>,
    all: Vec<Lines>,
}

/// How another particle is beside one.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Beside {
    /// Of its material and its capacity.
    Alike,
    /// Of its material, of another capacity.
    OtherCapacity,
    /// Of another material.
    OtherMaterial,
}

impl OwnLines {
    /// Those of the first `count` places of an operator: `melts` tells where something may melt, `beside` what another
    /// place has beside one.
    pub(super) fn of(
        count: usize,
        operator: &dyn CpuOperator,
        melts: impl Fn(usize) -> bool + Sync,
        beside: impl Fn(usize, usize) -> Beside + Sync,
    ) -> Self {
        let of_part = |part: usize| {
            let places = part * TASK..count.min((part + 1) * TASK);
            let mut part = Part {
                operator,
                beside: &beside,
                near: Near::default(),
                finder: LinesFinder::of_part(),
                whole: None,
            };
            let which = |place: usize| match melts(place) {
                true => part.which(place).unwrap_or(NONE),
                false => NONE,
            };
            (places.map(which).collect::<Vec<_>>(), part.finder)
        };
        let parts: Vec<_> = (0..count.div_ceil(TASK)).into_par_iter().map(of_part).collect();
        let (mut all, mut of) = (LinesFinder::default(), Vec::with_capacity(count));
        for (of_part, finder) in parts {
            let here = all.take(finder);
            let which = |which: u16| here.get(usize::from(which)).copied().flatten();
            of.extend(of_part.into_iter().map(|of| which(of).unwrap_or(NONE)));
        }
        Self { of, all: all.lines() }
    }

    /// Which a place has.
    pub(super) fn which(&self, place: usize) -> u16 {
        self.of[place]
    }

    /// Those of what has such ones, if it has any.
    #[inline(always)]
    pub(super) fn lines(&self, which: u16) -> Option<&Lines> {
        self.all.get(usize::from(which))
    }

    /// Bytes that they hold.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.of) + Lines::all_bytes(&self.all)
    }
}

/// Some places that are looked at.
struct Part<'a, B> {
    operator: &'a dyn CpuOperator,
    beside: B,
    near: Near,
    finder: LinesFinder,
    /// Lines of the operator with their factor, if all that they go over was alike at a place, and which one this has.
    whole: Option<(&'a Lines, f64, Option<u16>)>,
}

impl<B: Fn(usize, usize) -> Beside> Part<'_, B> {
    /// Which lines a place has, if it has any.
    fn which(&mut self, place: usize) -> Option<u16> {
        let Self { operator, beside, near, finder, whole } = self;
        let entries = operator.entries(place, near);
        let all_are_alike =
            || entries.are_all(place, |other, _| beside(place, other) == Beside::Alike);
        let this = match entries {
            Entries::Lines(lines, factor) => Some((lines, factor)),
            Entries::Row(..) => None,
        };
        if let (Some((lines, factor)), Some((known, of_known, which))) = (this, *whole)
            && std::ptr::eq(lines, known)
            && factor == of_known
            && all_are_alike()
        {
            return which;
        }
        // Entries mean nothing where there is no particle.
        if !operator.has_particle(place) {
            return None;
        }
        let mut own = Vec::new();
        let has_lines = entries.are_all(place, |other, weight| {
            let other_is = beside(place, other);
            if other_is == Beside::Alike {
                own.push((other as isize - place as isize, weight));
            }
            other_is != Beside::OtherCapacity
        });
        let which = has_lines.then(|| finder.which(own.into_iter())).flatten();
        if let Some((lines, factor)) = this.filter(|_| all_are_alike()) {
            *whole = Some((lines, factor, which));
        }
        which
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::model::lattice::MixedScene;
    use crate::model::{KernelKind, Material, scenes};
    use crate::solver::cpu::lattice::{Lattice, Mixed};

    #[test]
    fn lines_are_those_to_all_neighbours_of_the_own_material() {
        let mut problem = scenes::lattice(KernelKind::CubicSpline, 3, [12, 11, 10], 0.1, 2.5);
        problem.materials.push(Material::diffusive("sand", 0.3, 1000.0));
        let count = problem.particles.len();
        let material = |place: usize| u16::from(place % 12 > 5 || place < 3 * 12 * 11);
        problem.particles.material = (0..count).map(material).collect();
        let scene = MixedScene::of(&problem).expect("a lattice");
        let (_, rows) = scene.assemble(&problem);
        let operator = Lattice::new(Mixed::new(&problem, Arc::new(scene), rows));
        // One that differs in its capacity.
        let odd = 700;
        let beside = |place: usize, other: usize| match (material(place), other) {
            (of, _) if of != material(other) => Beside::OtherMaterial,
            (_, other) if other == odd || place == odd => Beside::OtherCapacity,
            _ => Beside::Alike,
        };
        let melts = |place: usize| place != 5;
        let own = OwnLines::of(count, &operator, melts, beside);
        assert!(own.all.len() < count / 4, "{}", own.all.len());
        let mut without = 0;
        for place in 0..count {
            let (mut expected, mut is_beside_odd) = (Vec::new(), false);
            operator.entries(place, &mut Near::default()).are_all(place, |other, weight| {
                is_beside_odd |= beside(place, other) == Beside::OtherCapacity;
                if material(other) == material(place) {
                    expected.push((other, weight));
                }
                true
            });
            let Some(lines) = own.lines(own.which(place)) else {
                assert!(is_beside_odd || !melts(place), "{place}");
                without += 1;
                continue;
            };
            assert!(!is_beside_odd && melts(place), "{place}");
            expected.sort_by_key(|&(other, _)| other);
            let mut found = Vec::new();
            lines.for_each(place, |other, weight| found.push((other, weight)));
            assert_eq!(found, expected, "{place}");
        }
        assert!(without > 20 && without < 200, "{without}");
    }
}
