//! One of Euler's steps of some places, while their rates come in.
//!
//! Rates are added to, and become potentials, as soon as nothing is missing: while they are in a fast cache.

use std::ops::Range;

use super::course::{Course, GoOn};
use super::enthalpy::{Enthalpy, HeatScene};
use super::fronts::Queue;
use super::latent::Latent;
use super::operator::CpuOperator;
use crate::model::operator::{take_below, within};
use crate::model::wide;

/// Values that are worked on together: parts are whole numbers of them but for the last.
const FEW: usize = 16;

/// A step of places that follow each other.
pub(super) struct PartialStep<'a, O: ?Sized> {
    all: &'a WholeStep<'a, O>,
    /// The places, and their enthalpies, which are up to date unless potentials tell them.
    places: Range<usize>,
    enthalpies: &'a mut [f64],
    /// So many have had their rates, and so many have been taken on.
    known: usize,
    done: usize,
    fronts: Queue,
    /// Whether any have been added.
    has_fronts: bool,
    /// Which of those that were latent before are among the places that are left, where steps go by potentials.
    melting: Range<usize>,
    latent: Latent,
    given: f64,
}

/// What steps of all places share.
pub(super) struct WholeStep<'a, O: ?Sized> {
    scene: &'a HeatScene,
    /// What is latent as the step begins.
    latent: &'a Latent,
    operator: &'a O,
    /// What the rates of the rows of seams are short of.
    of_seams: &'a [f64],
    /// Potentials as the step begins, of all places.
    now: &'a [f64],
    /// s
    dt: f64,
}

/// Takes `enthalpy`, whose potentials are `now`, a step of `dt` (s) on in parts that follow each other, which `parts`
/// [finishes](PartialStep::finish); returns what they gave together.
pub(super) fn in_parts<O: CpuOperator + ?Sized>(
    enthalpy: &mut Enthalpy,
    operator: &O,
    now: &[f64],
    dt: f64,
    parts: impl FnOnce(&WholeStep<'_, O>, &mut [f64]) -> Vec<(f64, Latent)>,
) -> f64 {
    let of_seams = &enthalpy.rates_of_seams()[..];
    let (scene, latent, enthalpies) = enthalpy.parts();
    let whole = WholeStep { scene, latent, operator, of_seams, now, dt };
    let (given, latent): (Vec<f64>, Vec<Latent>) = parts(&whole, enthalpies).into_iter().unzip();
    enthalpy.set_latent(Latent::of_parts(latent));
    given.iter().sum()
}

impl<'a, O: CpuOperator + ?Sized> PartialStep<'a, O> {
    /// A step of places from `first` on, which have `enthalpies`.
    pub(super) fn new(all: &'a WholeStep<'a, O>, first: usize, enthalpies: &'a mut [f64]) -> Self {
        let places = first..first + enthalpies.len();
        let fronts = match all.scene.fronts {
            Some(_) => Queue::new(all.latent, &places, all.operator.reach(), all.now.len()),
            None => Queue::default(),
        };
        let melting = within(all.latent.places(), &places);
        let (known, done, has_fronts, latent, given) = (0, 0, false, Latent::default(), 0.0);
        Self { all, places, enthalpies, known, done, fronts, has_fronts, melting, latent, given }
    }

    /// Takes on what nothing is missing of: of the first `known` places, rates are in `out`, where potentials
    /// after the step are written.
    pub(super) fn take_on(&mut self, out: &mut [f64], known: usize) {
        let first = self.places.start;
        let WholeStep { scene, latent, operator, of_seams, now, .. } = *self.all;
        if let Some(seams) = &scene.seams {
            let out = &mut out[self.known..known];
            self.given += seams.add(of_seams, 1.0, first + self.known, out);
        }
        self.known = known;
        let mut ready = known;
        if let Some(fronts) = &scene.fronts {
            let seen = first + known;
            for which in self.fronts.next(latent, seen, known == out.len()) {
                fronts.add(latent, which, operator, now, first, &mut out[..known]);
                self.has_fronts = true;
            }
            ready = self.fronts.untouched(latent, seen).saturating_sub(first).max(self.done);
        }
        if known < out.len() {
            // The rest with those that follow.
            ready -= (ready - self.done) % FEW;
        }
        if let Some(fronts) = scene.fronts.as_ref().filter(|_| self.has_fronts) {
            let held = first + self.done..first + ready;
            self.given += fronts.take_held(operator, held, first, out);
        }
        if ready > self.done {
            let part = self.done..ready;
            match &scene.course {
                Some(course) => self.go_on(course, first + self.done, &mut out[part]),
                None => self.change(first + self.done, &mut out[part]),
            }
            self.done = ready;
        }
    }

    /// What held particles among the places gave, value x capacity / s, and what is latent after the step.
    pub(super) fn finish(self) -> (f64, Latent) {
        debug_assert_eq!(self.done, self.places.len(), "all taken on");
        (self.given, self.latent)
    }

    /// Takes places from `first` on a step further by their potentials.
    fn go_on(&mut self, course: &Course, first: usize, out: &mut [f64]) {
        let WholeStep { latent, operator, now, dt, .. } = *self.all;
        let places = first..first + out.len();
        let now = &now[places.clone()];
        let melting = take_below(latent.places(), &mut self.melting, places.end);
        let take = |which: usize| {
            let (place, enthalpy) = latent.one(which);
            (place, enthalpy + dt * std::mem::take(&mut out[place - first]))
        };
        let mut changed: Vec<(usize, f64)> = melting.map(take).collect();
        let mut leaving = Vec::new();
        operator.for_each_present(places, &mut |places| {
            let local = places.start - first..places.end - first;
            let (now, out) = (&now[local.clone()], &mut out[local]);
            wide::run(GoOn { course, now, out, dt, leaving: &mut leaving, first: places.start });
        });
        if !leaving.is_empty() {
            let enthalpy = |place: usize| course.enthalpy(now[place - first]);
            let leaving = leaving.into_iter();
            changed.extend(leaving.map(|(place, change)| (place, enthalpy(place) + change)));
            changed.sort_unstable_by_key(|&(place, _)| place);
        }
        for (place, enthalpy) in changed {
            let potential = course.potential(enthalpy);
            out[place - first] = potential;
            if !course.tells(enthalpy, potential) {
                self.latent.push(place, enthalpy);
            }
        }
    }

    /// Takes places from `first` on a step further by their enthalpies.
    fn change(&mut self, first: usize, out: &mut [f64]) {
        let WholeStep { scene, operator, dt, .. } = *self.all;
        let (start, latent) = (self.places.start, &mut self.latent);
        let enthalpies = &mut self.enthalpies[first - start..first - start + out.len()];
        operator.for_each_present(first..first + out.len(), &mut |places| {
            let local = places.start - first..places.end - first;
            let (enthalpies, out) = (&mut enthalpies[local.clone()], &mut out[local]);
            scene.curves.change(places.start, enthalpies, out, dt, |first, enthalpies| {
                if let Some(fronts) = &scene.fronts {
                    fronts.find_latent(first, enthalpies, |place, enthalpy| {
                        if operator.has_particle(place) {
                            latent.push(place, enthalpy);
                        }
                    });
                }
            });
        });
        operator.clear_absent(first, out);
    }
}
