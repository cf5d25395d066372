//! Enthalpy in memory, and the potentials that come of it.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::CHUNK;
use super::change::Change;
use super::course::Course;
use super::fronts::FrontFlows;
use super::latent::Latent;
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::operator::Seams;
use crate::model::wide;
use crate::model::{HeatCurve, Problem};

/// The state of a scene with curves, by place.
///
/// Where the potential of a particle tells its enthalpy unless it melts, Euler's steps take potentials on and know
/// the enthalpies of [`Latent`] particles only: what such steps have left is to be [settled](Self::settle) before
/// anything else reads or changes the state.
pub(super) struct Enthalpy {
    values: Vec<f64>,
    /// Those that melt, from the first of Euler's steps on until the state is settled.
    latent: Option<Latent>,
    /// Bytes that they took at most.
    latent_bytes: usize,
    scene: HeatScene,
}

/// What does not change of it.
pub(super) struct HeatScene {
    pub(super) curves: Curves,
    /// How potentials go on, if they tell enthalpies.
    pub(super) course: Option<Course>,
    /// Where materials meet.
    pub(super) seams: Option<Seams>,
    /// What flows beside, where something melts at one temperature.
    pub(super) fronts: Option<FrontFlows>,
}

/// The curves of materials.
pub(super) struct Curves {
    /// By place: which one; none where all have the first.
    of: Option<Arc<[u16]>>,
    /// The places where another begins.
    starts: Vec<u32>,
    curves: Vec<Option<Arc<HeatCurve>>>,
}

impl Enthalpy {
    /// The initial state of `problem` in the order of `operator`, by which `capacities` are.
    pub(super) fn new(
        problem: &Problem,
        operator: &dyn CpuOperator,
        capacities: &Arc<Capacities>,
    ) -> Self {
        let material = &problem.particles.material;
        let curves = Curves::of(problem, operator);
        let places = operator.by_place(&(1..=material.len()).map(|p| p as f64).collect::<Vec<_>>());
        let mut place = vec![0; material.len()];
        for (at, &particle) in (0..).zip(&places) {
            if particle > 0.0 {
                place[particle as usize - 1] = at;
            }
        }
        let seams = Seams::of(problem, &place);
        let fronts = FrontFlows::new(problem, capacities, curves.of.as_ref(), operator);
        let values = operator.by_place(&problem.initial);
        let scene = HeatScene { course: curves.course(), curves, seams, fronts };
        Self { values, latent: None, latent_bytes: 0, scene }
    }

    /// Begins Euler's steps, unless they have begun: potentials are `now` by the order of `operator`.
    pub(super) fn begin(&mut self, now: &[f64], operator: &dyn CpuOperator) {
        if self.latent.is_some() {
            return;
        }
        let scene = &self.scene;
        if scene.course.is_none() && scene.fronts.is_none() {
            self.latent = Some(Latent::default());
            return;
        }
        let is_latent = |place: usize, value: f64, now: f64| match (&scene.course, &scene.fronts) {
            (Some(course), _) => !course.tells(value, now),
            (None, fronts) => fronts.as_ref().is_some_and(|fronts| fronts.is_latent(place, value)),
        };
        let parts = self.values.par_chunks(CHUNK).zip(now.par_chunks(CHUNK)).enumerate();
        let latent = |(k, (values, now)): (usize, (&[f64], &[f64]))| {
            let mut latent = Latent::default();
            for (place, (&value, &now)) in (k * CHUNK..).zip(values.iter().zip(now)) {
                if is_latent(place, value, now) && operator.has_particle(place) {
                    latent.push(place, value);
                }
            }
            latent
        };
        let parts: Vec<Latent> = parts.map(latent).collect();
        self.set_latent(Latent::of_parts(parts));
    }

    /// Finds all enthalpies after Euler's steps, where potentials are `now` by the order of `operator`.
    pub(super) fn settle(&mut self, now: &[f64], operator: &dyn CpuOperator) {
        let (Some(latent), Some(course)) = (self.latent.take(), &self.scene.course) else {
            return;
        };
        let parts = self.values.par_chunks_mut(CHUNK).zip(now.par_chunks(CHUNK));
        parts.for_each(|(values, now)| {
            for (value, &now) in values.iter_mut().zip(now) {
                // What has not changed keeps its last digit.
                if course.potential(*value) != now || !course.tells(*value, now) {
                    *value = course.enthalpy(now);
                }
            }
        });
        for (&place, &enthalpy) in latent.places().iter().zip(latent.enthalpies()) {
            self.values[place as usize] = enthalpy;
        }
        operator.clear_absent(0, &mut self.values);
    }

    /// The values, K.
    pub(super) fn values(&self) -> &[f64] {
        debug_assert!(self.latent.is_none(), "a settled state");
        &self.values
    }

    /// Takes a state that was settled.
    pub(super) fn restore(&mut self, values: &[f64]) {
        self.values.copy_from_slice(values);
        self.latent = None;
    }

    /// Adds what the matrix does not know of flows between materials to `rates`; returns what held particles
    /// gave beyond what it knows, value x capacity / s.
    pub(super) fn add_seams(&self, rates: &mut [f64]) -> f64 {
        self.add_seams_of(1.0, |place| self.values()[place], rates)
    }

    /// The same for what changes with a change `x` of the state.
    pub(super) fn add_change_of_seams(&self, x: &[f64], rates: &mut [f64]) -> f64 {
        let values = self.values();
        let before = self.add_seams_of(-1.0, |place| values[place], rates);
        before + self.add_seams_of(1.0, |place| values[place] + x[place], rates)
    }

    fn add_seams_of(
        &self,
        factor: f64,
        state: impl Fn(usize) -> f64 + Sync,
        rates: &mut [f64],
    ) -> f64 {
        let add = |seams: &Seams| seams.add(&seams.rates(state), factor, 0, rates);
        self.scene.seams.as_ref().map_or(0.0, add)
    }

    /// What the rates of the rows of seams are short of in one of Euler's steps.
    pub(super) fn rates_of_seams(&self) -> Vec<f64> {
        // Seams are only where curves differ: there steps keep the enthalpies.
        let rates = |seams: &Seams| seams.rates(|place| self.values[place]);
        self.scene.seams.as_ref().map_or(Vec::new(), rates)
    }

    /// Takes what is latent after a step.
    pub(super) fn set_latent(&mut self, latent: Latent) {
        self.latent_bytes = self.latent_bytes.max(latent.memory_bytes());
        self.latent = Some(latent);
    }

    /// The scene, what is latent as a step begins, and the values.
    pub(super) fn parts(&mut self) -> (&HeatScene, &Latent, &mut [f64]) {
        (&self.scene, self.latent.as_ref().expect("begun steps"), &mut self.values)
    }

    /// Adds a change of the state, which is in `out`, and writes the potentials that come of it in its place.
    pub(super) fn change(&mut self, out: &mut [f64]) {
        debug_assert!(self.latent.is_none(), "a settled state");
        let curves = &self.scene.curves;
        let parts = self.values.par_chunks_mut(CHUNK).zip(out.par_chunks_mut(CHUNK)).enumerate();
        parts.for_each(|(k, (values, out))| curves.change(k * CHUNK, values, out, 1.0, |_, _| ()));
    }

    /// Writes by how much the potentials, now `now`, change with a change `x` of the state.
    pub(super) fn potential_change(&self, x: &[f64], now: &[f64], out: &mut [f64]) {
        let parts = out.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).enumerate();
        parts.for_each(|(k, (out, x))| {
            let places = k * CHUNK..k * CHUNK + x.len();
            let mut state = self.values()[places.clone()].to_vec();
            out.copy_from_slice(x);
            self.scene.curves.change(places.start, &mut state, out, 1.0, |_, _| ());
            // What does not change gets 0, held particles too.
            for ((out, now), x) in out.iter_mut().zip(&now[places]).zip(x) {
                *out = if *x == 0.0 { 0.0 } else { *out - now };
            }
        });
    }

    /// Writes the square roots of the slopes after a change `x` of the state.
    pub(super) fn slope_root(&self, x: &[f64], out: &mut [f64]) {
        let values = self.values();
        out.par_iter_mut().enumerate().for_each(|(place, out)| {
            let enthalpy = values[place] + x[place];
            let root =
                self.scene.curves.at(place).map_or(1.0, |curve| curve.slope(enthalpy).sqrt());
            // Where there is no particle there is no temperature either.
            *out = if root.is_nan() { 0.0 } else { root };
        });
    }

    /// Bytes that it holds.
    pub(super) fn memory_bytes(&self) -> usize {
        let curves = &self.scene.curves;
        let of = curves.of.as_ref().map_or(0, |of| size_of_val(&**of));
        let curves = of + size_of_val(&*curves.starts);
        let seams = self.scene.seams.as_ref().map_or(0, Seams::memory_bytes);
        let fronts = self.scene.fronts.as_ref().map_or(0, FrontFlows::memory_bytes);
        size_of_val(&*self.values) + curves + seams + fronts + self.latent_bytes
    }
}

impl Curves {
    /// Those of `problem` in the order of `operator`.
    fn of(problem: &Problem, operator: &dyn CpuOperator) -> Self {
        let material = &problem.particles.material;
        let all = problem.materials.iter().map(|material| material.curve.clone());
        let (of, curves): (_, Vec<_>) = if problem.has_one_curve() {
            (None, all.skip(usize::from(material[0])).take(1).collect())
        } else {
            let numbers: Vec<f64> = material.iter().map(|&m| f64::from(m)).collect();
            let of: Arc<[u16]> =
                operator.by_place(&numbers).into_iter().map(|m| m as u16).collect();
            (Some(of), all.collect())
        };
        let changes = |of: &Arc<[u16]>| {
            let pairs = (1..).zip(of.windows(2));
            pairs.filter(|(_, pair)| pair[0] != pair[1]).map(|(place, _)| place).collect()
        };
        let starts = of.as_ref().map_or(Vec::new(), changes);
        Self { of, starts, curves }
    }

    /// The course of all places, if they have one.
    fn course(&self) -> Option<Course> {
        let one = self.curves[0].as_ref().filter(|_| self.of.is_none());
        one.and_then(Course::of)
    }

    #[inline]
    fn index(&self, place: usize) -> usize {
        self.of.as_ref().map_or(0, |of| usize::from(of[place]))
    }

    /// The curve of a place.
    fn at(&self, place: usize) -> Option<&HeatCurve> {
        self.curves[self.index(place)].as_deref()
    }

    /// Parts of `places` that are of one material, with its curve.
    fn runs(
        &self,
        places: Range<usize>,
    ) -> impl Iterator<Item = (Range<usize>, Option<&HeatCurve>)> {
        let first = self.starts.partition_point(|&start| start as usize <= places.start);
        let mut starts = self.starts[first..].iter();
        let mut start = places.start;
        std::iter::from_fn(move || {
            let next = starts.next().map_or(places.end, |&next| places.end.min(next as usize));
            let run = start..next;
            start = run.end;
            (!run.is_empty()).then(|| (run.clone(), self.at(run.start)))
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
        for (run, curve) in self.runs(first..first + out.len()) {
            let local = run.start - first..run.end - first;
            let (enthalpies, out) = (&mut values[local.clone()], &mut out[local]);
            let may_melt = |begins: usize, few: &[f64]| may_melt(run.start + begins, few);
            wide::run(Change { curve, enthalpies, out, dt, may_melt });
        }
    }
}
