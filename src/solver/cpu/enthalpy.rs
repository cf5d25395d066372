//! Enthalpy in memory, and the potentials that come of it.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::CHUNK;
use super::curves::Curves;
use super::fronts::FrontFlows;
use super::latent::{CurveAndLines, Latent, LatentEnthalpies};
use super::operator::CpuOperator;
use super::seam_step::Note;
use super::vector::Capacities;
use crate::model::Problem;
use crate::model::operator::{Locals, LocalsMut, SeamGroup, Seams, within};
use crate::model::wide;

/// The state of a scene with curves, by place.
///
/// Where the potential of a particle tells its enthalpy unless it melts at one temperature, Euler's steps take
/// potentials on and know the enthalpies of [`Latent`] particles only: what such steps have left is to be
/// [settled](Self::settle) before anything else reads or changes the state.
pub(super) struct Enthalpy {
    values: Vec<f64>,
    /// From the first of Euler's steps on until the state is settled.
    begun: Option<Begun>,
    /// Bytes that this took at most.
    begun_bytes: usize,
    scene: HeatScene,
}

/// What Euler's steps know of a state beside its potentials.
#[derive(Default)]
pub(super) struct Begun {
    /// Those that melt at one temperature.
    pub(super) latent: Latent,
    /// One enthalpy for each of these, which a step writes.
    pub(super) next_enthalpies: Vec<f64>,
    /// What the particles of seams are like, by their rows, and what they are like after a step.
    pub(super) at_seams: [Locals; 2],
}

/// What does not change of it.
pub(super) struct HeatScene {
    pub(super) curves: Curves,
    /// Where materials meet.
    pub(super) seams: Option<Seams>,
    /// What flows beside, where something melts at one temperature.
    pub(super) fronts: Option<FrontFlows>,
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
        let written = |place| Some(operator.written_entries(place)?.to_vec(place));
        let seams = Seams::of(problem, &place, operator.has_lines(), written);
        let fronts = FrontFlows::new(problem, capacities, curves.materials(), operator);
        let values = operator.by_place(&problem.initial);
        Self { values, begun: None, begun_bytes: 0, scene: HeatScene { curves, seams, fronts } }
    }

    /// Begins Euler's steps, unless they have begun: potentials are `now` by the order of `operator`.
    pub(super) fn begin(&mut self, now: &[f64], operator: &dyn CpuOperator) {
        if self.begun.is_some() {
            return;
        }
        let latent = self.find_latent(now, operator);
        let Self { values, scene, .. } = &*self;
        let [mut before, after] = [(); 2].map(|()| match &scene.seams {
            Some(seams) => Locals::of(seams),
            None => Locals::default(),
        });
        let mut rest = before.all_mut();
        for SeamGroup { material, rows } in scene.seams.iter().flat_map(Seams::groups) {
            let locals = rest.take(rows.len());
            scene.note(*material, rows.clone(), [now, values], 0, latent.known(), locals);
        }
        let next_enthalpies = vec![0.0; latent.places().len()];
        self.set_begun(Begun { latent, next_enthalpies, at_seams: [before, after] });
    }

    fn find_latent(&self, now: &[f64], operator: &dyn CpuOperator) -> Latent {
        let HeatScene { curves, fronts, .. } = &self.scene;
        if curves.courses().is_none() && fronts.is_none() {
            return Latent::default();
        }
        let is_latent = |place: usize, value: f64, now: f64| match (curves.courses(), fronts) {
            (Some(courses), _) => !courses[curves.which(place)].tells(value, now),
            (None, fronts) => fronts.as_ref().is_some_and(|fronts| fronts.is_latent(place, value)),
        };
        let parts = self.values.par_chunks(CHUNK).zip(now.par_chunks(CHUNK)).enumerate();
        let latent = |(k, (values, now)): (usize, (&[f64], &[f64]))| {
            let mut latent = Latent::default();
            for (place, (&value, &now)) in (k * CHUNK..).zip(values.iter().zip(now)) {
                if is_latent(place, value, now) && operator.has_particle(place) {
                    latent.push(place, value, self.scene.kind(place, operator));
                }
            }
            latent
        };
        let parts: Vec<Latent> = parts.map(latent).collect();
        Latent::of_parts(&parts.iter().map(Latent::all).collect::<Vec<_>>())
    }

    /// Finds all enthalpies after Euler's steps, where potentials are `now` by the order of `operator`.
    pub(super) fn settle(&mut self, now: &[f64], operator: &dyn CpuOperator) {
        let curves = &self.scene.curves;
        let (Some(Begun { latent, .. }), Some(courses)) = (self.begun.take(), curves.courses())
        else {
            return;
        };
        let parts = self.values.par_chunks_mut(CHUNK).zip(now.par_chunks(CHUNK)).enumerate();
        parts.for_each(|(k, (values, now))| {
            let first = k * CHUNK;
            for (run, which) in curves.runs(first..first + values.len()) {
                let (course, local) = (&courses[which], run.start - first..run.end - first);
                for (value, &now) in values[local.clone()].iter_mut().zip(&now[local]) {
                    // What has not changed keeps its last digit.
                    if course.potential(*value) != now || !course.tells(*value, now) {
                        *value = course.enthalpy(now);
                    }
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
        debug_assert!(self.begun.is_none(), "a settled state");
        &self.values
    }

    /// Takes a state that was settled.
    pub(super) fn restore(&mut self, values: &[f64]) {
        self.values.copy_from_slice(values);
        self.begun = None;
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
        let Some(seams) = &self.scene.seams else {
            return 0.0;
        };
        let locals = seams.locals(|row, place| seams.local(row, state(place)));
        let add = |(k, rates): (usize, &mut [f64])| {
            let places = k * CHUNK..k * CHUNK + rates.len();
            let of_group = |group: &SeamGroup| {
                let near = within(&seams.places()[group.rows.clone()], &places);
                let rows = group.rows.start + near.start..group.rows.start + near.end;
                let add = |place, _, rate| rates[place - places.start] += factor * rate;
                factor * seams.add(rows, &locals, add)
            };
            seams.groups().iter().map(of_group).sum::<f64>()
        };
        let given: Vec<f64> = rates.par_chunks_mut(CHUNK).enumerate().map(add).collect();
        given.iter().sum()
    }

    /// What does not change of it.
    pub(super) fn scene(&self) -> &HeatScene {
        &self.scene
    }

    /// Takes what steps know after one.
    pub(super) fn set_begun(&mut self, begun: Begun) {
        self.begun_bytes = self.begun_bytes.max(begun.memory_bytes());
        self.begun = Some(begun);
    }

    /// The scene, what steps know as one begins, which is taken, and the values.
    pub(super) fn parts(&mut self) -> (&HeatScene, Begun, &mut [f64]) {
        (&self.scene, self.begun.take().expect("begun steps"), &mut self.values)
    }

    /// Adds a change of the state, which is in `out`, and writes the potentials that come of it in its place.
    pub(super) fn change(&mut self, out: &mut [f64]) {
        debug_assert!(self.begun.is_none(), "a settled state");
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
        let HeatScene { curves, seams, fronts } = &self.scene;
        let seams = seams.as_ref().map_or(0, Seams::memory_bytes);
        let fronts = fronts.as_ref().map_or(0, FrontFlows::memory_bytes);
        let scene = curves.memory_bytes() + seams + fronts;
        size_of_val(&*self.values) + scene + self.begun_bytes
    }
}

impl HeatScene {
    /// Whether not all places are of one kind.
    fn has_kinds(&self) -> bool {
        let has_lines = self.fronts.as_ref().is_some_and(FrontFlows::has_lines);
        has_lines || self.curves.materials().is_some()
    }

    /// The kind of what melts in a place, unless all are of one.
    pub(super) fn kind<O: CpuOperator + ?Sized>(
        &self,
        place: usize,
        operator: &O,
    ) -> Option<CurveAndLines> {
        let lines = || self.fronts.as_ref().map_or(0, |fronts| fronts.lines(place, operator));
        self.has_kinds()
            .then(|| CurveAndLines { curve: self.curves.which(place) as u16, lines: lines() })
    }

    /// Takes note in `locals` of what the particles of some rows of seams, which are of a `material`, are like in Euler's
    /// steps: with potentials (K), enthalpies (K) where potentials do not tell them, both of places from `first` on,
    /// and what is `latent`.
    pub(super) fn note(
        &self,
        material: u16,
        rows: Range<usize>,
        [potentials, enthalpies]: [&[f64]; 2],
        first: usize,
        latent: LatentEnthalpies<'_>,
        mut locals: LocalsMut<'_>,
    ) {
        let Some(seams) = &self.seams else {
            return;
        };
        let places = &seams.places()[rows.clone()];
        match self.curves.courses() {
            Some(courses) => {
                let course = &courses[usize::from(material)];
                wide::run(Note { seams, course, places, potentials, first, latent, locals });
            }
            None => {
                for (k, (row, &place)) in rows.zip(places).enumerate() {
                    locals.set(k, seams.local(row, enthalpies[place as usize - first]));
                }
            }
        }
    }
}

impl Begun {
    fn memory_bytes(&self) -> usize {
        let at_seams = self.at_seams.iter().map(Locals::memory_bytes);
        let latent = self.latent.memory_bytes() + size_of_val(&*self.next_enthalpies);
        latent + at_seams.sum::<usize>()
    }
}
