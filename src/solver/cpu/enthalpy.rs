//! Enthalpy in memory, and the potentials that come of it.

use std::sync::Arc;

use rayon::prelude::*;

use super::CHUNK;
use super::fronts::{Melting, MeltingPlaces};
use super::operator::CpuOperator;
use super::vector::Capacities;
use crate::model::material::Segment;
use crate::model::operator::Seams;
use crate::model::wide::{self, Work, multiply_add};
use crate::model::{HeatCurve, Problem};

/// Curves of more pieces that are not flat are searched for the one that counts; of fewer, all are added up.
const MOST_PIECES: usize = 4;

/// The state of a scene with curves, by place.
pub(super) struct Enthalpy {
    pub(super) values: Vec<f64>,
    curves: Curves,
    /// Where materials meet.
    seams: Option<Seams>,
    /// What melts, where it does at one temperature.
    melting: Option<MeltingPlaces>,
}

/// Which curve each place has.
pub(super) enum Curves {
    /// All have this one, which may have few pieces.
    One(Arc<HeatCurve>, Option<Pieces>),
    /// By place: an index into the curves of materials.
    Each { of: Arc<[u16]>, curves: Vec<Option<Arc<HeatCurve>>> },
}

impl Enthalpy {
    /// The initial state of `problem` in the order of `operator`, by which `capacities` are.
    pub(super) fn new(
        problem: &Problem,
        operator: &dyn CpuOperator,
        capacities: &Arc<Capacities>,
    ) -> Self {
        let material = &problem.particles.material;
        let first = problem.materials[usize::from(material[0])].curve.clone();
        let same = problem.has_one_curve();
        let curves = match first.filter(|_| same) {
            Some(curve) => {
                let pieces = Pieces::of(&curve);
                Curves::One(curve, pieces)
            }
            None => {
                let numbers: Vec<f64> = material.iter().map(|&m| f64::from(m)).collect();
                let of = operator.by_place(&numbers).into_iter().map(|m| m as u16).collect();
                let curves = problem.materials.iter().map(|m| m.curve.clone()).collect();
                Curves::Each { of, curves }
            }
        };
        let places = operator.by_place(&(1..=material.len()).map(|p| p as f64).collect::<Vec<_>>());
        let mut place = vec![0; material.len()];
        for (at, &particle) in (0..).zip(&places) {
            if particle > 0.0 {
                place[particle as usize - 1] = at;
            }
        }
        let seams = Seams::of(problem, &place);
        let of = match &curves {
            Curves::One(..) => None,
            Curves::Each { of, .. } => Some(of),
        };
        let melting = MeltingPlaces::new(problem, capacities, of);
        Self { values: operator.by_place(&problem.initial), curves, seams, melting }
    }

    /// Whether different materials meet.
    pub(super) fn has_seams(&self) -> bool {
        self.seams.is_some()
    }

    /// Adds what the matrix does not know of flows between materials to `rates`; returns what held particles
    /// gave beyond what it knows, value x capacity / s.
    pub(super) fn add_seams(&self, rates: &mut [f64]) -> f64 {
        let state = |place: usize| self.values[place];
        self.seams.as_ref().map_or(0.0, |seams| seams.add(state, 1.0, rates))
    }

    /// The same for what changes with a change `x` of the state.
    pub(super) fn add_change_of_seams(&self, x: &[f64], rates: &mut [f64]) -> f64 {
        let Some(seams) = &self.seams else {
            return 0.0;
        };
        let before = seams.add(|place| self.values[place], -1.0, rates);
        before + seams.add(|place| self.values[place] + x[place], 1.0, rates)
    }

    /// The values, K.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// The curves, what melts, and the values to be changed.
    pub(super) fn parts(&mut self) -> (&Curves, Option<&MeltingPlaces>, &mut [f64]) {
        (&self.curves, self.melting.as_ref(), &mut self.values)
    }

    /// What melts as a step begins; `None` where nothing melts at one temperature.
    pub(super) fn melting(&mut self) -> Option<Melting> {
        self.melting.as_mut().map(|melting| melting.melting(&self.values))
    }

    /// Takes the places that melt after a step, ascending.
    pub(super) fn set_melting(&mut self, places: Vec<u32>) {
        if let Some(melting) = &mut self.melting {
            melting.set(places);
        }
    }

    /// Has what melts looked for again.
    pub(super) fn forget_fronts(&mut self) {
        if let Some(melting) = &mut self.melting {
            melting.forget();
        }
    }

    /// Adds what flows to and from what melts to the rates `out`, where potentials are `now`; returns what held
    /// particles give beyond what the operator knows, value x capacity / s.
    pub(super) fn add_fronts<O: CpuOperator + ?Sized>(
        &self,
        melting: &Melting,
        operator: &O,
        now: &[f64],
        out: &mut [f64],
    ) -> f64 {
        let places = self.melting.as_ref();
        places.map_or(0.0, |places| places.add(melting, operator, now, 0, out))
    }

    /// Adds `dt` times the rates `out`, and writes the potentials that come of it in their place.
    pub(super) fn advance(&mut self, out: &mut [f64], dt: f64) {
        let parts = self.values.par_chunks_mut(CHUNK).zip(out.par_chunks_mut(CHUNK)).enumerate();
        parts.for_each(|(k, (values, out))| self.curves.advance(k * CHUNK, values, out, dt));
    }

    /// Writes by how much the potentials, now `now`, change with a change `x` of the state.
    pub(super) fn potential_change(&self, x: &[f64], now: &[f64], out: &mut [f64]) {
        let parts = out.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).enumerate();
        parts.for_each(|(k, (out, x))| {
            let places = k * CHUNK..k * CHUNK + x.len();
            let state = &self.values[places.clone()];
            for ((out, value), x) in out.iter_mut().zip(state).zip(x) {
                *out = value + x;
            }
            self.curves.potentials(places.start, out);
            // What does not change gets 0, held particles too.
            for ((out, now), x) in out.iter_mut().zip(&now[places]).zip(x) {
                *out = if *x == 0.0 { 0.0 } else { *out - now };
            }
        });
    }

    /// Writes the square roots of the slopes after a change `x` of the state.
    pub(super) fn slope_root(&self, x: &[f64], out: &mut [f64]) {
        out.par_iter_mut().enumerate().for_each(|(place, out)| {
            let enthalpy = self.values[place] + x[place];
            let root = self.curves.of(place).map_or(1.0, |curve| curve.slope(enthalpy).sqrt());
            // Where there is no particle there is no temperature either.
            *out = if root.is_nan() { 0.0 } else { root };
        });
    }

    /// Bytes that it holds.
    pub(super) fn memory_bytes(&self) -> usize {
        let curves = match &self.curves {
            Curves::One(..) => 0,
            Curves::Each { of, .. } => size_of_val(&**of),
        };
        let seams = self.seams.as_ref().map_or(0, Seams::memory_bytes);
        let melting = self.melting.as_ref().map_or(0, MeltingPlaces::memory_bytes);
        size_of_val(&*self.values) + curves + seams + melting
    }
}

impl Curves {
    /// The curve of a place.
    fn of(&self, place: usize) -> Option<&HeatCurve> {
        match self {
            Self::One(curve, _) => Some(curve),
            Self::Each { of, curves } => curves[usize::from(of[place])].as_deref(),
        }
    }

    /// Adds `dt` times the rates `out` to `values`, of places from `first` on, and writes their potentials
    /// in place of the rates.
    pub(super) fn advance(&self, first: usize, values: &mut [f64], out: &mut [f64], dt: f64) {
        if let Self::One(_, Some(pieces)) = self {
            wide::run(Advance { pieces, values, out, dt });
            return;
        }
        for (k, (value, out)) in values.iter_mut().zip(out).enumerate() {
            *value += dt * *out;
            *out = self.of(first + k).map_or(*value, |curve| curve.potential(*value));
        }
    }

    /// Replaces what is in `values`, of places from `first` on, by its potential.
    fn potentials(&self, first: usize, values: &mut [f64]) {
        if let Self::One(_, Some(pieces)) = self {
            let mut rates = vec![0.0; values.len()];
            wide::run(Advance { pieces, values, out: &mut rates, dt: 0.0 });
            values.copy_from_slice(&rates);
            return;
        }
        for (k, value) in values.iter_mut().enumerate() {
            if let Some(curve) = self.of(first + k) {
                *value = curve.potential(*value);
            }
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
pub(super) struct Pieces {
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

/// Adds `dt` times what is in `out` to each value, and writes its potential there.
struct Advance<'a> {
    pieces: &'a Pieces,
    values: &'a mut [f64],
    out: &'a mut [f64],
    dt: f64,
}

impl Work for Advance<'_> {
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

impl Advance<'_> {
    /// With the first `N` pieces: those past the last add nothing.
    #[inline(always)]
    fn with<const FUSED: bool, const N: usize>(self) {
        let Self { pieces: Pieces { base, pieces, .. }, values, out, dt } = self;
        for (out, value) in out.iter_mut().zip(values) {
            *value = multiply_add::<FUSED>(dt, *out, *value);
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
    use super::*;
    use crate::model::{Conductivity, Melting};

    #[test]
    fn what_pieces_add_up_to_is_the_potential() {
        let melting = |liquidus: f64| Melting {
            solidus: 400.0,
            liquidus,
            latent: 5e8,
            conductivity: Conductivity::constant(200.0),
            capacity: 3e6,
        };
        let rising = Conductivity::of_points(vec![[300.0, 300.0], [350.0, 320.0]]);
        let curves = [
            (HeatCurve::new(&Conductivity::constant(300.0), 2.5e6, Some(&melting(400.0))), Some(2)),
            (HeatCurve::new(&rising, 2.5e6, None), Some(3)),
            (HeatCurve::new(&rising, 2.5e6, Some(&melting(420.0))), None),
        ];
        for (curve, count) in curves {
            let pieces = Pieces::of(&curve);
            assert_eq!(pieces.map(|pieces| pieces.count), count);
            let all = Curves::One(Arc::new(curve.clone()), pieces);
            let mut values: Vec<f64> = (0..5000).map(|k| 200.0 + 0.17 * f64::from(k)).collect();
            let mut out = vec![2.0; values.len()];
            all.advance(0, &mut values, &mut out, 0.5);
            assert_eq!(values[10], 200.0 + 1.7 + 1.0, "half a second at 2 K/s");
            let off = |shift: usize| {
                let pairs = out.iter().zip(&values[shift..]);
                pairs.map(|(out, &value)| (out - curve.potential(value)).abs()).fold(0.0, f64::max)
            };
            assert!(off(0) < 1e-10, "{:e}", off(0));
            assert!(off(1) > 0.1, "a shift is noticed");
        }
    }
}
