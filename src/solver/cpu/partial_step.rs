//! One of Euler's steps of some places, while their rates come in.
//!
//! Rates are added to, and become potentials, as soon as nothing is missing: while they are in a fast cache.

use std::ops::Range;

use super::course::GoOn;
use super::enthalpy::Enthalpy;
use super::fronts::Queue;
use super::latent::Latent;
use super::operator::CpuOperator;
use crate::model::wide;

/// A step of places that follow each other.
pub(super) struct PartialStep<'a, O: ?Sized> {
    enthalpy: &'a Enthalpy,
    operator: &'a O,
    /// What the rates of the rows of seams are short of.
    of_seams: &'a [f64],
    /// Potentials as the step begins, of all places.
    now: &'a [f64],
    dt: f64,
    /// The places.
    places: Range<usize>,
    /// So many have had their rates, and so many have been taken on.
    known: usize,
    done: usize,
    fronts: Queue,
    latent: Latent,
    given: f64,
}

impl<'a, O: CpuOperator + ?Sized> PartialStep<'a, O> {
    /// A step of `dt` (s) of `enthalpy` at `places`, where potentials are `now` and the rates of seams are short of
    /// `of_seams`.
    pub(super) fn new(
        enthalpy: &'a Enthalpy,
        operator: &'a O,
        of_seams: &'a [f64],
        now: &'a [f64],
        dt: f64,
        places: Range<usize>,
    ) -> Self {
        let fronts = match enthalpy.fronts {
            Some(_) => Queue::new(enthalpy.latent(), &places, operator.reach(), now.len()),
            None => Queue::default(),
        };
        let (known, done, latent, given) = (0, 0, Latent::default(), 0.0);
        Self { enthalpy, operator, of_seams, now, dt, places, known, done, fronts, latent, given }
    }

    /// Takes on what nothing is missing of: of the first `known` places, rates are in `out`, where potentials
    /// after the step are written.
    pub(super) fn take_on(&mut self, out: &mut [f64], known: usize) {
        let first = self.places.start;
        let enthalpy = self.enthalpy;
        if let Some(seams) = &enthalpy.seams {
            let out = &mut out[self.known..known];
            self.given += seams.add(self.of_seams, 1.0, first + self.known, out);
        }
        self.known = known;
        let mut ready = known;
        if let Some(fronts) = &enthalpy.fronts {
            let latent = enthalpy.latent();
            let seen = first + known;
            for which in self.fronts.next(latent, seen, known == out.len()) {
                fronts.add(latent, which, self.operator, self.now, first, &mut out[..known]);
            }
            ready = self.fronts.untouched(latent, seen).saturating_sub(first).max(self.done);
            let held = first + self.done..first + ready;
            self.given += fronts.take_held(self.operator, held, first, out);
        }
        if ready > self.done {
            let part = self.done..ready;
            self.go_on(first + self.done, &mut out[part]);
            self.done = ready;
        }
    }

    /// What held particles among the places gave, value x capacity / s, and what is latent after the step.
    pub(super) fn finish(self) -> (f64, Latent) {
        debug_assert_eq!(self.done, self.places.len(), "all taken on");
        (self.given, self.latent)
    }

    /// Takes places from `first` on a step further.
    fn go_on(&mut self, first: usize, out: &mut [f64]) {
        let Self { enthalpy, operator, dt, .. } = *self;
        let curves = &enthalpy.curves;
        let places = first..first + out.len();
        let now = &self.now[places.clone()];
        let take = |(place, enthalpy): (usize, f64)| {
            (place, enthalpy + dt * std::mem::take(&mut out[place - first]))
        };
        let mut changed: Vec<(usize, f64)> = enthalpy.latent().within(&places).map(take).collect();
        let mut leaving = Vec::new();
        operator.for_each_present(places, &mut |places| {
            for (run, course) in curves.runs(places) {
                let local = run.start - first..run.end - first;
                let (now, out) = (&now[local.clone()], &mut out[local]);
                wide::run(GoOn { course, now, out, dt, leaving: &mut leaving, first: run.start });
            }
        });
        if !leaving.is_empty() {
            let enthalpy = |place: usize| curves.course(place).enthalpy(now[place - first]);
            let leaving = leaving.into_iter();
            changed.extend(leaving.map(|(place, change)| (place, enthalpy(place) + change)));
            changed.sort_unstable_by_key(|&(place, _)| place);
        }
        for (place, enthalpy) in changed {
            let course = curves.course(place);
            let potential = course.potential(enthalpy);
            out[place - first] = potential;
            if !course.tells(enthalpy, potential) {
                self.latent.push(place, enthalpy);
            }
        }
    }
}
