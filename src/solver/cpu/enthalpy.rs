//! Enthalpy in memory, and the potentials that come of it.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::CHUNK;
use super::course::Course;
use super::fronts::FrontFlows;
use super::latent::Latent;
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::material::Segment;
use crate::model::operator::Seams;
use crate::model::wide::{self, Work, multiply_add};
use crate::model::{HeatCurve, Problem};

/// Curves of more pieces that are not flat are searched for the one that counts; of fewer, all are added up.
const MOST_PIECES: usize = 4;

/// The state of a scene with curves, by place.
///
/// Euler's steps take potentials on, and know the enthalpies of [`Latent`] particles only: what such steps have
/// left is to be [settled](Self::settle) before anything else reads or changes the state.
pub(super) struct Enthalpy {
    values: Vec<f64>,
    /// Those whose potential does not tell their enthalpy, from the first of Euler's steps on until it is settled.
    latent: Option<Latent>,
    /// Bytes that they took at most.
    latent_bytes: usize,
    pub(super) curves: Curves,
    /// Where materials meet.
    pub(super) seams: Option<Seams>,
    /// What flows beside, where something melts at one temperature.
    pub(super) fronts: Option<FrontFlows>,
}

/// The curves of materials.
pub(super) struct Curves {
    /// By place: which one; none where all have the first.
    of: Option<Arc<[u16]>>,
    curves: Vec<Option<Arc<HeatCurve>>>,
    courses: Vec<Course>,
    /// Those of the curve, if there is one that has few.
    pieces: Option<Pieces>,
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
        let fronts = FrontFlows::new(problem, capacities, curves.of.as_ref());
        let values = operator.by_place(&problem.initial);
        Self { values, latent: None, latent_bytes: 0, curves, seams, fronts }
    }

    /// Begins Euler's steps, unless they have begun: potentials are `now` by the order of `operator`.
    pub(super) fn begin(&mut self, now: &[f64], operator: &dyn CpuOperator) {
        if self.latent.is_some() {
            return;
        }
        let parts = self.values.par_chunks(CHUNK).zip(now.par_chunks(CHUNK)).enumerate();
        let latent = |(k, (values, now)): (usize, (&[f64], &[f64]))| {
            let mut latent = Latent::default();
            for (place, (&value, &now)) in (k * CHUNK..).zip(values.iter().zip(now)) {
                let is_told = self.curves.course(place).tells(value, now);
                if !is_told && operator.has_particle(place) {
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
        let Some(latent) = self.latent.take() else {
            return;
        };
        let curves = &self.curves;
        let parts = self.values.par_chunks_mut(CHUNK).zip(now.par_chunks(CHUNK)).enumerate();
        parts.for_each(|(k, (values, now))| {
            for (place, (value, &now)) in (k * CHUNK..).zip(values.iter_mut().zip(now)) {
                let course = curves.course(place);
                // What has not changed keeps its last digit.
                if course.potential(*value) != now || !course.tells(*value, now) {
                    *value = course.enthalpy(now);
                }
            }
        });
        for (&place, &enthalpy) in latent.places().iter().zip(latent.enthalpies()) {
            self.values[place as usize] = enthalpy;
        }
        operator.clear_absent(&mut self.values);
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
        self.seams.as_ref().map_or(0.0, add)
    }

    /// What the rates of the rows of seams are short of in one of Euler's steps, where potentials are `now`.
    pub(super) fn rates_of_seams(&self, now: &[f64]) -> Vec<f64> {
        let state = |place: usize| {
            let listed = self.latent().enthalpy(place);
            listed.unwrap_or_else(|| self.curves.course(place).enthalpy(now[place]))
        };
        self.seams.as_ref().map_or(Vec::new(), |seams| seams.rates(state))
    }

    /// Takes what is latent after a step.
    pub(super) fn set_latent(&mut self, latent: Latent) {
        self.latent_bytes = self.latent_bytes.max(latent.memory_bytes());
        self.latent = Some(latent);
    }

    /// What is latent as a step begins.
    pub(super) fn latent(&self) -> &Latent {
        self.latent.as_ref().expect("begun steps")
    }

    /// Adds a change of the state, which is in `out`, and writes the potentials that come of it in its place.
    pub(super) fn change(&mut self, out: &mut [f64]) {
        debug_assert!(self.latent.is_none(), "a settled state");
        let parts = self.values.par_chunks_mut(CHUNK).zip(out.par_chunks_mut(CHUNK)).enumerate();
        parts.for_each(|(k, (values, out))| self.curves.change(k * CHUNK, values, out));
    }

    /// Writes by how much the potentials, now `now`, change with a change `x` of the state.
    pub(super) fn potential_change(&self, x: &[f64], now: &[f64], out: &mut [f64]) {
        let parts = out.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).enumerate();
        parts.for_each(|(k, (out, x))| {
            let places = k * CHUNK..k * CHUNK + x.len();
            let mut state = self.values()[places.clone()].to_vec();
            out.copy_from_slice(x);
            self.curves.change(places.start, &mut state, out);
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
            let root = self.curves.at(place).map_or(1.0, |curve| curve.slope(enthalpy).sqrt());
            // Where there is no particle there is no temperature either.
            *out = if root.is_nan() { 0.0 } else { root };
        });
    }

    /// Bytes that it holds.
    pub(super) fn memory_bytes(&self) -> usize {
        let curves = self.curves.of.as_ref().map_or(0, |of| size_of_val(&**of));
        let seams = self.seams.as_ref().map_or(0, Seams::memory_bytes);
        size_of_val(&*self.values) + curves + seams + self.latent_bytes
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
            let of = operator.by_place(&numbers).into_iter().map(|m| m as u16).collect();
            (Some(of), all.collect())
        };
        let one = curves[0].as_ref().filter(|_| of.is_none());
        let pieces = one.and_then(|curve| Pieces::of(curve));
        let courses = curves.iter().map(|curve| Course::of(curve.as_ref())).collect();
        Self { of, curves, courses, pieces }
    }

    #[inline]
    fn index(&self, place: usize) -> usize {
        self.of.as_ref().map_or(0, |of| usize::from(of[place]))
    }

    /// The curve of a place.
    fn at(&self, place: usize) -> Option<&HeatCurve> {
        self.curves[self.index(place)].as_deref()
    }

    /// The course of a place.
    pub(super) fn course(&self, place: usize) -> &Course {
        &self.courses[self.index(place)]
    }

    /// Parts of `places` that are of one material, with its course.
    pub(super) fn runs(
        &self,
        places: Range<usize>,
    ) -> impl Iterator<Item = (Range<usize>, &Course)> {
        let mut start = places.start;
        std::iter::from_fn(move || {
            let length = match &self.of {
                _ if start == places.end => return None,
                None => places.end - start,
                Some(of) => {
                    let rest = &of[start..places.end];
                    rest.iter().position(|m| *m != rest[0]).unwrap_or(rest.len())
                }
            };
            let run = start..start + length;
            start = run.end;
            Some((run.clone(), self.course(run.start)))
        })
    }

    /// Adds changes, which are in `out`, to `values`, of places from `first` on, and writes their potentials there.
    fn change(&self, first: usize, values: &mut [f64], out: &mut [f64]) {
        if let Some(pieces) = &self.pieces {
            wide::run(Change { pieces, values, out });
            return;
        }
        for (k, (value, out)) in values.iter_mut().zip(out).enumerate() {
            *value += *out;
            *out = self.at(first + k).map_or(*value, |curve| curve.potential(*value));
        }
    }
}

/// A piece of a curve that is not flat: what it adds to the potential is `above` (`slope` + `bend` `above`)
/// of how far, between `least` and `most`, an enthalpy is above its start.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    start: f64,
    least: f64,
    most: f64,
    slope: f64,
    bend: f64,
}

/// A curve of few segments as what its pieces add up to, without a branch.
#[derive(Clone, Copy, Debug)]
struct Pieces {
    /// The potential where the first segment begins.
    base: f64,
    pieces: [Piece; MOST_PIECES],
    count: usize,
}

impl Pieces {
    /// The pieces of `curve`; none if they are too many, or one is no number.
    fn of(curve: &HeatCurve) -> Option<Self> {
        let segments = curve.segments();
        let mut of = Self { base: segments[0].potential, pieces: Default::default(), count: 0 };
        for (k, segment) in segments.iter().enumerate() {
            let Segment { start, slope, bend, .. } = *segment;
            if slope == 0.0 && bend == 0.0 {
                continue;
            }
            let least = if k == 0 { f64::NEG_INFINITY } else { 0.0 };
            let most = segments.get(k + 1).map_or(f64::INFINITY, |next| next.start - start);
            *of.pieces.get_mut(of.count)? = Piece { start, least, most, slope, bend };
            of.count += 1;
        }
        curve.is_known_everywhere().then_some(of)
    }
}

/// Adds what is in `out` to each value, and writes its potential there.
struct Change<'a> {
    pieces: &'a Pieces,
    values: &'a mut [f64],
    out: &'a mut [f64],
}

impl Work for Change<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        match self.pieces.count {
            1 => self.with::<FUSED, 1>(),
            2 => self.with::<FUSED, 2>(),
            3 => self.with::<FUSED, 3>(),
            _ => self.with::<FUSED, MOST_PIECES>(),
        }
    }
}

impl Change<'_> {
    /// With the first `N` pieces: those past the last add nothing.
    #[inline(always)]
    fn with<const FUSED: bool, const N: usize>(self) {
        let Self { pieces: Pieces { base, pieces, .. }, values, out } = self;
        for (out, value) in out.iter_mut().zip(values) {
            *value += *out;
            let mut potential = *base;
            for piece in &pieces[..N] {
                let above = *value - piece.start;
                // Comparisons, since they are one instruction each, and keep what is no number.
                let above = if above < piece.least { piece.least } else { above };
                let above = if above > piece.most { piece.most } else { above };
                let rise = multiply_add::<FUSED>(piece.bend, above, piece.slope);
                potential = multiply_add::<FUSED>(above, rise, potential);
            }
            *out = potential;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::course::tests::melting;
    use super::*;
    use crate::model::Conductivity;

    #[test]
    fn what_pieces_add_up_to_is_the_potential() {
        let rising = Conductivity::of_points(vec![[300.0, 300.0], [350.0, 320.0]]);
        let curves = [
            (HeatCurve::new(&Conductivity::constant(300.0), 2.5e6, Some(&melting(400.0))), Some(2)),
            (HeatCurve::new(&rising, 2.5e6, None), Some(3)),
            (HeatCurve::new(&rising, 2.5e6, Some(&melting(420.0))), None),
        ];
        for (curve, count) in curves {
            let pieces = Pieces::of(&curve);
            assert_eq!(pieces.map(|pieces| pieces.count), count);
            let curves = vec![Some(Arc::new(curve.clone()))];
            let all = Curves { of: None, curves, courses: Vec::new(), pieces };
            let mut values: Vec<f64> = (0..5000).map(|k| 200.0 + 0.17 * f64::from(k)).collect();
            let mut out = vec![1.0; values.len()];
            all.change(0, &mut values, &mut out);
            assert_eq!(values[10], 200.0 + 1.7 + 1.0);
            let off = |shift: usize| {
                let pairs = out.iter().zip(&values[shift..]);
                pairs.map(|(out, &value)| (out - curve.potential(value)).abs()).fold(0.0, f64::max)
            };
            assert!(off(0) < 1e-10, "{:e}", off(0));
            assert!(off(1) > 0.1, "a shift is noticed");
        }
    }
}
