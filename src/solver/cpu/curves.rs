//! Which curve each place follows, as its enthalpy changes.

use std::ops::Range;
use std::sync::Arc;

use super::change::Change;
use super::course::Course;
use super::operator::CpuOperator;
use crate::model::operator::seek;
use crate::model::wide;
use crate::model::{HeatCurve, Problem};

/// The curves of materials, by place.
pub(super) struct Curves {
    /// By place: which one; none where all have the first.
    of: Option<Arc<[u16]>>,
    /// Where one begins, and which: the first from 0 on, and at last where there is no place.
    starts: Vec<(u32, u16)>,
    curves: Vec<Option<Arc<HeatCurve>>>,
    /// How potentials go on with each, if they tell enthalpies with all.
    courses: Option<Vec<Course>>,
}

impl Curves {
    /// Those of `problem` in the order of `operator`.
    pub(super) fn of(problem: &Problem, operator: &dyn CpuOperator) -> Self {
        let material = &problem.particles.material;
        let (of, materials) = if problem.has_one_curve() {
            (None, &problem.materials[usize::from(material[0])..][..1])
        } else {
            let numbers: Vec<f64> = material.iter().map(|&m| f64::from(m)).collect();
            let of: Arc<[u16]> =
                operator.by_place(&numbers).into_iter().map(|m| m as u16).collect();
            (Some(of), &problem.materials[..])
        };
        let curves = materials.iter().map(|material| material.curve.clone()).collect();
        let courses = materials.iter().map(Course::of).collect();
        Self::by_place(of, curves, courses)
    }

    fn by_place(
        of: Option<Arc<[u16]>>,
        curves: Vec<Option<Arc<HeatCurve>>>,
        courses: Option<Vec<Course>>,
    ) -> Self {
        let mut starts: Vec<(u32, u16)> = Vec::new();
        for (place, &which) in (0..).zip(of.as_deref().unwrap_or(&[0])) {
            if starts.last().is_none_or(|&(_, before)| before != which) {
                starts.push((place, which));
            }
        }
        starts.push((u32::MAX, 0));
        starts.shrink_to_fit();
        Self { of, starts, curves, courses }
    }

    /// By place: which material it has, where curves differ.
    pub(super) fn materials(&self) -> Option<&Arc<[u16]>> {
        self.of.as_ref()
    }

    /// How potentials go on, by what [`Self::runs`] names, if they tell enthalpies.
    pub(super) fn courses(&self) -> Option<&[Course]> {
        self.courses.as_deref()
    }

    /// Which curve and course a place has.
    #[inline]
    pub(super) fn which(&self, place: usize) -> usize {
        self.of.as_ref().map_or(0, |of| usize::from(of[place]))
    }

    /// The curve of a place.
    pub(super) fn at(&self, place: usize) -> Option<&HeatCurve> {
        self.curves[self.which(place)].as_deref()
    }

    /// Parts of `places` that are of one material, with which curve and course that has; of no places none or an empty one.
    pub(super) fn runs(
        &self,
        places: Range<usize>,
    ) -> impl Iterator<Item = (Range<usize>, usize)> + '_ {
        self.runs_near(places, &mut 0)
    }

    /// The same, looked for from `near` on, which becomes how many begin before the end of the places.
    pub(super) fn runs_near(
        &self,
        places: Range<usize>,
        near: &mut usize,
    ) -> impl Iterator<Item = (Range<usize>, usize)> + use<'_> {
        let first = seek(&self.starts, *near, |&(start, _)| start as usize <= places.start) - 1;
        *near = seek(&self.starts, first, |&(start, _)| (start as usize) < places.end);
        self.starts[first..=*near].windows(2).map(move |ends| {
            let [(start, which), (end, _)] = [ends[0], ends[1]];
            let run = (start as usize).max(places.start)..(end as usize).min(places.end);
            (run, usize::from(which))
        })
    }

    /// Adds `dt` times changes, which are in `out`, to `values`, of places from `first` on, and writes their
    /// potentials there; calls `may_melt` with parts where some may melt at one temperature after it: where they
    /// begin, and their values.
    pub(super) fn change(
        &self,
        first: usize,
        values: &mut [f64],
        out: &mut [f64],
        dt: f64,
        mut may_melt: impl FnMut(usize, &[f64]),
    ) {
        for (run, which) in self.runs(first..first + out.len()) {
            let local = run.start - first..run.end - first;
            let (enthalpies, out) = (&mut values[local.clone()], &mut out[local]);
            let may_melt = |begins: usize, few: &[f64]| may_melt(run.start + begins, few);
            let curve = self.curves[which].as_deref();
            wide::run(Change { curve, enthalpies, out, dt, may_melt });
        }
    }

    /// Bytes that they hold.
    pub(super) fn memory_bytes(&self) -> usize {
        self.of.as_ref().map_or(0, |of| size_of_val(&**of)) + size_of_val(&*self.starts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_of_one_curve_each_and_all_of_the_places() {
        let of: Vec<u16> = [0, 0, 0, 2, 2, 1, 0, 0, 1, 1].repeat(3);
        let curves = Curves::by_place(Some(of.clone().into()), Vec::new(), None);
        for (start, end) in (0..=of.len()).flat_map(|end| (0..=end).map(move |start| (start, end)))
        {
            for mut near in [0, 1, 9, 50] {
                let runs: Vec<_> = curves.runs_near(start..end, &mut near).collect();
                let places: Vec<usize> = runs.iter().flat_map(|(run, _)| run.clone()).collect();
                assert_eq!(places, (start..end).collect::<Vec<_>>());
                assert!(runs.windows(2).all(|two| two[0].1 != two[1].1));
                for (run, which) in runs {
                    assert!(!run.is_empty() || start == end);
                    assert!(of[run].iter().all(|of| usize::from(*of) == which));
                }
            }
        }
        let one = Curves::by_place(None, Vec::new(), None);
        assert_eq!(one.runs(3..8).collect::<Vec<_>>(), [(3..8, 0)]);
    }
}
