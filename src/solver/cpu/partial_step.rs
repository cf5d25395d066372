//! One of Euler's steps of some places, while an operator writes them.
//!
//! What it writes, potentials or rates, is added to, and potentials are what they should be, as soon as nothing is missing:
//! while it is in a fast cache.

use std::cmp::Reverse;
use std::ops::Range;

use rayon::prelude::*;

use super::course::{Course, CourseStep};
use super::crossings::{Crossings, FEW};
use super::enthalpy::{Begun, Enthalpy, HeatScene};
use super::fronts::{Add, Queue};
use super::latent::{Latent, NextLatent, PartAfter};
use super::operator::{Combine, CpuOperator, RATE};
use super::seam_step::SeamStep;
use super::written::Written;
use crate::model::operator::{take_below, within};
use crate::model::wide::{self, CACHE_LINE};

/// Below this many places one thread is faster than handing out tasks for every step.
pub(super) const SERIAL: usize = 1 << 15;

/// A step of places that follow each other.
pub(super) struct PartialStep<'a, O: ?Sized> {
    all: &'a WholeStep<'a, O>,
    scene: &'a HeatScene,
    /// What is latent as the step begins.
    before: &'a Latent,
    /// The places, and their enthalpies, which are up to date unless potentials tell them.
    places: Range<usize>,
    enthalpies: &'a mut [f64],
    /// So many have been taken on.
    done: usize,
    seams: Option<SeamStep<'a>>,
    fronts: Queue,
    /// Whether any have been added.
    has_fronts: bool,
    /// Which of those that were latent before are among the places that are left, where steps go by potentials.
    melting: Range<usize>,
    latent: NextLatent<'a>,
    /// What held particles gave, value x capacity / s, by [`WholeStep::part`] of the places.
    given: Vec<f64>,
    /// Of [`Self::go_on`] alone: places whose potentials are to be found from their enthalpies, with these, and those
    /// that pass to another phase.
    changed: Vec<(usize, f64)>,
    crossings: Vec<usize>,
    /// Where curves were looked for last.
    curves_near: usize,
}

/// A step of all places.
pub(super) struct WholeStep<'a, O: ?Sized> {
    operator: &'a O,
    /// Potentials as the step begins.
    now: &'a [f64],
    /// s
    dt: f64,
    /// Places of which sums are made together: those of all are sums of these, which do not depend on the tasks.
    part: usize,
    /// How potentials go on, by course, if there are any.
    steps: Vec<CourseStep>,
    /// What is written before anything is added: these, by curve, or rates where there are none.
    written: Vec<Combine>,
}

impl<'a, O: CpuOperator + ?Sized> WholeStep<'a, O> {
    /// A step of `dt` (s) of a scene with potentials `now`, of which parts of so many places are taken on.
    pub(super) fn new(
        operator: &'a O,
        now: &'a [f64],
        dt: f64,
        part: usize,
        scene: &HeatScene,
    ) -> Self {
        let courses = scene.curves.courses().unwrap_or_default();
        let steps: Vec<CourseStep> = courses.iter().map(|course| course.step(dt)).collect();
        let written = steps.iter().map(|step| step.phases).collect();
        debug_assert!(dt > 0.0, "rates are found again from what is written");
        Self { operator, now, dt, part, steps, written }
    }

    /// What the operator is to write.
    pub(super) fn written(&self) -> Written<'_> {
        match &self.written[..] {
            [] => Written::Same(RATE),
            [one] => Written::Same(*one),
            each => Written::Each(each),
        }
    }

    /// The rate in what is written of a place with a curve, 1/s x value, which is taken out.
    fn take_rate(&self, place: usize, curve: usize, out: &mut f64) -> f64 {
        let [rate, rest] = self.written().of(curve).rate_and_rest(self.now[place], *out);
        *out = rest;
        rate
    }

    /// Takes `enthalpy` the step on in tasks of about so many parts, and writes its potentials to `out`. `step` has the
    /// operator write a task's places with what `scratch` has made, and has them [taken on](PartialStep::take_on);
    /// returns what held particles gave, value x capacity / s.
    pub(super) fn take<S>(
        &self,
        parts: usize,
        enthalpy: &mut Enthalpy,
        out: &mut [f64],
        scratch: impl Fn() -> S + Send + Sync,
        step: impl Fn(&mut S, &mut PartialStep<'_, O>, &mut [f64]) + Send + Sync,
    ) -> f64 {
        let (scene, begun, enthalpies) = enthalpy.parts();
        let Begun { latent: before, mut next_enthalpies, at_seams: [locals, mut after] } = begun;
        let count = out.len();
        let mut first = 0;
        let mut seams =
            scene.seams.as_ref().map(|seams| SeamStep::of_all(seams, &locals, &mut after));
        let [mut rest, mut rest_of_enthalpies] = [out, enthalpies];
        let mut rest_of_latent = &mut next_enthalpies[..];
        let mut tasks = Vec::with_capacity(count.div_ceil(parts * self.part));
        while first < count {
            let places = first..self.end_of_task(parts, first, count, &before);
            first = places.end;
            let (out, enthalpies);
            (out, rest) = rest.split_at_mut(places.len());
            (enthalpies, rest_of_enthalpies) = rest_of_enthalpies.split_at_mut(places.len());
            let seams = seams.as_mut().map(|seams| seams.take(places.end));
            let latent = NextLatent::take(&before, &mut rest_of_latent, &places);
            let task = PartialStep::new(self, scene, &before, latent, places, enthalpies, seams);
            tasks.push((task, out));
        }
        debug_assert!(rest_of_latent.is_empty(), "tasks have all of them");
        let work = |scratch: &mut S, (mut task, out): (PartialStep<'_, O>, &mut [f64])| {
            step(scratch, &mut task, out);
            (task.places.start, task.finish())
        };
        let mut done: Vec<(usize, (Vec<f64>, PartAfter))> = if count < SERIAL {
            let mut scratch = scratch();
            tasks.into_iter().map(|task| work(&mut scratch, task)).collect()
        } else {
            deal_out(&mut tasks, |(task, _)| task.exceptions());
            tasks.into_par_iter().with_max_len(1).map_init(scratch, work).collect()
        };
        // In order of places again, so that sums do not depend on how tasks were dealt out.
        done.sort_unstable_by_key(|&(first, ..)| first);
        let (given, parts): (Vec<Vec<f64>>, Vec<PartAfter>) =
            done.into_iter().map(|(_, of_task)| of_task).unzip();
        let mut latent = before;
        latent.go_on(&mut next_enthalpies, &parts);
        enthalpy.set_begun(Begun { latent, next_enthalpies, at_seams: [after, locals] });
        given.iter().flatten().sum()
    }

    /// Where the task that begins at `first` of `count` places ends: after about so many parts, where least is within reach
    /// of both it and the next of what melts, which both look at.
    fn end_of_task(&self, parts: usize, first: usize, count: usize, latent: &Latent) -> usize {
        let (task, reach) = (parts * self.part, self.operator.reach());
        // Tasks before have ended near there.
        let even = ((first + task / 2) / task + 1) * task;
        let apart = (2 * reach).next_multiple_of(self.part);
        if even >= count || apart > task / 4 {
            return even.min(count);
        }
        let near = |end: &usize| within(latent.places(), &(end - reach..end + reach)).len();
        let ends = [even, even - apart, even + apart].into_iter().filter(|&end| end < count);
        ends.min_by_key(near).unwrap_or(count)
    }
}

/// Puts tasks in an order in which halves of them, and halves of these, have as much to do as the others, first what
/// takes longest. Threads get such parts: one that had all that takes long, or had it last, would have others wait.
fn deal_out<T>(tasks: &mut Vec<T>, work: impl Fn(&T) -> usize) {
    if tasks.iter().map(&work).max() == tasks.iter().map(&work).min() {
        return;
    }
    tasks.sort_by_key(|task| Reverse(work(task)));
    let mut dealt: Vec<(usize, T)> = tasks.drain(..).enumerate().collect();
    dealt.sort_unstable_by_key(|(rank, _)| rank.reverse_bits());
    tasks.extend(dealt.into_iter().map(|(_, task)| task));
}

impl<'a, O: CpuOperator + ?Sized> PartialStep<'a, O> {
    /// A step of `places`, which have `enthalpies` and `seams`.
    fn new(
        all: &'a WholeStep<'a, O>,
        scene: &'a HeatScene,
        before: &'a Latent,
        latent: NextLatent<'a>,
        places: Range<usize>,
        enthalpies: &'a mut [f64],
        seams: Option<SeamStep<'a>>,
    ) -> Self {
        let fronts = match scene.fronts {
            Some(_) => Queue::new(before, &places, all.operator.reach(), all.now.len()),
            None => Queue::default(),
        };
        let melting = latent.before();
        let given = places.len().div_ceil(all.part);
        Self {
            all,
            scene,
            before,
            places,
            enthalpies,
            done: 0,
            seams,
            fronts,
            has_fronts: false,
            melting,
            latent,
            given: vec![0.0; given],
            changed: Vec::new(),
            crossings: Vec::new(),
            curves_near: 0,
        }
    }

    /// How many particles take longer than others do: what melts, and what is at seams.
    fn exceptions(&self) -> usize {
        self.fronts.len() + self.seams.as_ref().map_or(0, SeamStep::len)
    }

    /// The places.
    pub(super) fn places(&self) -> Range<usize> {
        self.places.clone()
    }

    /// Writes what an operator is to write where rates are, which are in `out`.
    pub(super) fn write_of_rates(&self, out: &mut [f64]) {
        let first = self.places.start;
        for (run, curve) in self.scene.curves.runs(self.places()) {
            let (now, out) =
                (&self.all.now[run.clone()], &mut out[run.start - first..run.end - first]);
            self.all.written().of(curve).write(now, out);
        }
    }

    /// Has the processor fetch the enthalpies that are taken on next, of so many places, while the operator writes others:
    /// it does not foresee by itself that they are needed.
    pub(super) fn fetch(&self, count: usize) {
        if self.scene.curves.courses().is_none() {
            let next = self.done..self.places.len().min(self.done + count);
            self.enthalpies[next]
                .chunks(CACHE_LINE)
                .for_each(|line| wide::prefetch(&raw const line[0]));
        }
    }

    /// Takes on what nothing is missing of: of the first `known` places the operator has written everything to `out`,
    /// where potentials after the step are written, and held particles in the last part of these have `given` so much,
    /// value x capacity / s.
    pub(super) fn take_on(&mut self, out: &mut [f64], known: usize, given: f64) {
        let first = self.places.start;
        let WholeStep { operator, now, .. } = *self.all;
        let (scene, before, written) = (self.scene, self.before, self.all.written());
        let of_part = &mut self.given[(known - 1) / self.all.part];
        *of_part += given;
        if let Some(seams) = &mut self.seams {
            *of_part += seams.add(first + known, first, written, out);
        }
        let mut ready = known;
        if let Some(fronts) = &scene.fronts {
            let seen = first + known;
            for which in self.fronts.next(before, seen, known == out.len()) {
                let (own, out) = (first..first + known, &mut out[..known]);
                let (of, latent, potentials) = (fronts, before, now);
                wide::run(Add { of, latent, which, operator, potentials, written, own, out });
                self.has_fronts = true;
            }
            ready = self.fronts.untouched(before, seen).saturating_sub(first).max(self.done);
        }
        if known < out.len() {
            // The rest with those that follow: whole numbers of what is worked on together.
            ready -= (ready - self.done) % FEW;
        }
        if ready > self.done {
            let (from, out) = (first + self.done, &mut out[self.done..ready]);
            if self.has_fronts {
                self.take_held(from, out);
            }
            match scene.curves.courses() {
                Some(courses) => self.go_on(courses, from, out),
                None => self.change(from, out),
            }
            self.note_seams(from, out);
            self.done = ready;
        }
    }

    /// Takes what fronts have added to held particles from places from `first` on.
    fn take_held(&mut self, first: usize, out: &mut [f64]) {
        let held = self.all.operator.held();
        let Some(fronts) = &self.scene.fronts else {
            return;
        };
        for &held in &held[within(held, &(first..first + out.len()))] {
            let held = held as usize;
            let curve = self.scene.curves.which(held);
            let rate = self.all.take_rate(held, curve, &mut out[held - first]);
            self.given[(held - self.places.start) / self.all.part] -= fronts.capacity(held) * rate;
        }
    }

    /// Takes places from `first` on a step further by their potentials, and by their enthalpies what melts at one
    /// temperature or passes to another phase.
    fn go_on(&mut self, courses: &[Course], first: usize, out: &mut [f64]) {
        let Self { all, scene, before, melting, latent, changed, crossings, curves_near, .. } =
            self;
        let WholeStep { operator, now, dt, ref steps, .. } = **all;
        let (curves, places) = (&scene.curves, first..first + out.len());
        let from = latent.len();
        for melting in take_below(before.places(), melting, places.end) {
            let (place, enthalpy, kind) = before.one(melting);
            let curve = usize::from(kind.unwrap_or_default().curve);
            let change = std::mem::replace(&mut out[place - first], now[place]) - now[place];
            let enthalpy = enthalpy + steps[curve].enthalpy_per_change * change;
            match courses[curve].goes_on_melting(now[place], enthalpy) {
                true => latent.keep(melting, enthalpy),
                false => changed.push((place, enthalpy)),
            }
        }
        operator.for_each_present(places, &mut |places| {
            let (first, out) = (places.start, &mut out[places.start - first..places.end - first]);
            let runs = curves
                .runs_near(places.clone(), curves_near)
                .map(|(run, which)| (run, &steps[which]));
            let (now, found) = (&now[places], &mut *crossings);
            wide::run(Crossings { runs, now, out, found, first });
        });
        changed.extend(crossings.drain(..).map(|place| {
            let (now, curve) = (now[place], curves.which(place));
            let [rate, _] = steps[curve].phases.rate_and_rest(now, out[place - first]);
            (place, courses[curve].enthalpy(now) + dt * rate)
        }));
        let sorted = latent.len();
        for (place, enthalpy) in changed.drain(..) {
            let course = &courses[curves.which(place)];
            let potential = course.potential(enthalpy);
            out[place - first] = potential;
            if !course.tells(enthalpy, potential) {
                latent.push(place, enthalpy, || scene.kind(place, operator));
            }
        }
        if latent.len() > sorted {
            latent.sort(from);
        }
    }

    /// Takes places from `first` on a step further by their enthalpies.
    fn change(&mut self, first: usize, out: &mut [f64]) {
        let WholeStep { operator, dt, .. } = *self.all;
        let (scene, start, latent) = (self.scene, self.places.start, &mut self.latent);
        let enthalpies = &mut self.enthalpies[first - start..first - start + out.len()];
        operator.for_each_present(first..first + out.len(), &mut |places| {
            let local = places.start - first..places.end - first;
            let (enthalpies, out) = (&mut enthalpies[local.clone()], &mut out[local]);
            scene.curves.change(places.start, enthalpies, out, dt, |first, enthalpies| {
                if let Some(fronts) = &scene.fronts {
                    fronts.find_latent(first, enthalpies, |place, enthalpy| {
                        if operator.has_particle(place) {
                            latent.push(place, enthalpy, || scene.kind(place, operator));
                        }
                    });
                }
            });
        });
        operator.clear_absent(first, out);
    }

    /// Takes note of what the particles of seams are like after places from `first` on were taken on: their potentials
    /// are in `out`.
    fn note_seams(&mut self, first: usize, out: &[f64]) {
        let Self { scene, latent, places, enthalpies, seams, .. } = self;
        let Some(step) = seams else {
            return;
        };
        let enthalpies = &enthalpies[first - places.start..];
        step.note(first + out.len(), |material, rows, locals| {
            scene.note(material, rows, [out, enthalpies], first, latent.known(), locals);
        });
    }

    /// What held particles among the places gave, value x capacity / s by part, and what is latent after the step.
    fn finish(self) -> (Vec<f64>, PartAfter) {
        debug_assert_eq!(self.done, self.places.len(), "all taken on");
        (self.given, self.latent.finish())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_of_tasks_have_as_much_to_do_as_each_other() {
        let mut tasks = vec![0, 0, 5, 0, 7, 6, 0, 4];
        deal_out(&mut tasks, |&work| work);
        assert_eq!(tasks, [7, 0, 5, 0, 6, 0, 4, 0]);
        let mut others: Vec<usize> = (0..13).collect();
        deal_out(&mut others, |&work| work);
        let sum = |part: &[usize]| part.iter().sum::<usize>();
        assert!(sum(&others[..6]).abs_diff(sum(&others[6..])) < 13 && sum(&others) == 78);
        assert_eq!(others[0], 12);
        let mut alike = vec![(3, 'a'), (3, 'b'), (3, 'c')];
        deal_out(&mut alike, |&(work, _)| work);
        assert_eq!(alike, [(3, 'a'), (3, 'b'), (3, 'c')]);
    }
}
