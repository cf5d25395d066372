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
    /// Where one begins, and which, if they differ.
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
        let changes = |of: &Arc<[u16]>| {
            let mut starts: Vec<(u32, u16)> = Vec::new();
            for (place, &which) in (0..).zip(of.iter()) {
                if starts.last().is_none_or(|&(_, before)| before != which) {
                    starts.push((place, which));
                }
            }
            starts.shrink_to_fit();
            starts
        };
        let starts = of.as_ref().map_or_else(Vec::new, changes);
        let curves = materials.iter().map(|material| material.curve.clone()).collect();
        let courses = materials.iter().map(Course::of).collect();
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

    /// Parts of `places` that are of one material, with which curve and course that has.
    pub(super) fn runs(
        &self,
        places: Range<usize>,
    ) -> impl Iterator<Item = (Range<usize>, usize)> + '_ {
        self.runs_near(places, &mut 0)
    }

    /// The same, looked for from `near` on, which becomes how many begin up to the first place.
    pub(super) fn runs_near(
        &self,
        places: Range<usize>,
        near: &mut usize,
    ) -> impl Iterator<Item = (Range<usize>, usize)> + use<'_> {
        *near = seek(&self.starts, *near, |&(start, _)| start as usize <= places.start);
        let begun = *near;
        let mut starts = self.starts[begun..].iter();
        // Which it is stands beside where it begins, since places are looked up in another part of memory.
        let first = begun.checked_sub(1).map_or(0, |last| self.starts[last].1);
        let mut next = Some((places.start, first));
        std::iter::from_fn(move || {
            let (start, which) = next.take().filter(|&(start, _)| start < places.end)?;
            next = starts.next().map(|&(start, which)| (start as usize, which));
            let end = next.map_or(places.end, |(next, _)| places.end.min(next));
            Some((start..end, usize::from(which)))
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
