//! How potentials go on as enthalpies change.
//!
//! Where a potential tells the enthalpy it need not be looked up: psi(theta) is quadratic from one point of its
//! curve to the next, so that a change delta of theta takes psi to psi + delta (q + q') / 2. Here q is the slope
//! d psi / d theta at psi, with q^2 = s^2 + 4 b (psi - p) for a segment that begins at the potential p with the
//! slope s and half the second derivative b, and q' = q + 2 b delta is the slope at the end. So a step reads and
//! writes one value of a particle, as it does of a temperature.
//!
//! A potential does not tell the enthalpy of what melts at one temperature, nor past what is known of a
//! conductivity: those particles are [`Latent`](super::latent::Latent).

use std::sync::Arc;

use crate::model::HeatCurve;
use crate::model::wide::{Work, choose, multiply_add};

/// Values that are worked on together, in registers.
const FEW: usize = 16;
/// Pieces that are more than the loops below are compiled for.
const MANY: usize = 0;

/// The potential of a material as its enthalpy changes.
pub(super) struct Course {
    /// Ascending; the first holds below all others.
    pieces: Vec<Piece>,
    /// Whether a slope changes within a piece.
    is_bent: bool,
    /// Where all heat is latent.
    plateau: Option<Plateau>,
    /// None of what has its temperature as its potential.
    curve: Option<Arc<HeatCurve>>,
}

/// A segment of a curve that is not flat, by potential.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// It holds for potentials above this, K.
    above: f64,
    /// Potential where it begins, K.
    potential: f64,
    /// The slope there, and half the second derivative.
    slope: f64,
    bend: f64,
}

/// Enthalpies over which a potential does not change.
#[derive(Clone, Copy, Debug)]
struct Plateau {
    begins: f64,
    ends: f64,
    potential: f64,
}

impl Course {
    /// That of a material with `curve`, or without one.
    pub(super) fn of(curve: Option<&Arc<HeatCurve>>) -> Self {
        let Some(curve) = curve else {
            let straight =
                Piece { above: f64::NEG_INFINITY, potential: 0.0, slope: 1.0, bend: 0.0 };
            return Self { pieces: vec![straight], is_bent: false, plateau: None, curve: None };
        };
        let (mut pieces, mut plateau) = (Vec::new(), None);
        let segments = curve.segments();
        let [least, most] = curve.limits();
        for (k, segment) in segments.iter().enumerate() {
            let next = segments.get(k + 1).map_or(f64::INFINITY, |next| next.start);
            let (potential, slope, bend) = (segment.potential, segment.slope, segment.bend);
            if slope == 0.0 && bend == 0.0 {
                plateau = Some(Plateau { begins: segment.start, ends: next, potential });
                continue;
            }
            // Of what is unknown nothing goes on: only places without a particle are there.
            let unknown = |above: f64| Piece { above, potential: 0.0, slope: 0.0, bend: 0.0 };
            pieces.push(match (potential.is_nan(), k) {
                (true, 0) => unknown(f64::NEG_INFINITY),
                (true, _) => unknown(curve.potential_at(most)),
                (false, 0) => Piece { above: f64::NEG_INFINITY, potential, slope, bend },
                (false, _) => {
                    let above = if segment.temperature == least {
                        potential.next_down()
                    } else {
                        potential
                    };
                    Piece { above, potential, slope, bend }
                }
            });
        }
        // The sign of a difference to it counts, also to 0.
        pieces.iter_mut().for_each(|piece: &mut Piece| piece.above += 0.0);
        let is_bent = pieces.iter().any(|piece| piece.bend != 0.0);
        Self { pieces, is_bent, plateau, curve: Some(Arc::clone(curve)) }
    }

    /// Whether a potential tells its enthalpy.
    pub(super) fn tells(&self, enthalpy: f64, potential: f64) -> bool {
        // No number tells nothing.
        self.plateau.map_or(!potential.is_nan(), |plateau| {
            (enthalpy <= plateau.begins && potential <= plateau.potential)
                || (enthalpy > plateau.ends && potential > plateau.potential)
        })
    }

    /// The potential at an enthalpy; what is solid is not above where it melts.
    pub(super) fn potential(&self, enthalpy: f64) -> f64 {
        let of_curve = || self.curve.as_ref().map_or(enthalpy, |curve| curve.potential(enthalpy));
        match self.plateau {
            Some(plateau) if plateau.begins < enthalpy && enthalpy < plateau.ends => {
                plateau.potential
            }
            Some(plateau) if enthalpy <= plateau.begins => match of_curve() {
                above if above > plateau.potential => plateau.potential,
                potential => potential,
            },
            _ => of_curve(),
        }
    }

    /// Finds which changes take potentials, which are `next` then, out of their pieces: those keep their potential.
    fn find_leaving(
        &self,
        now: &[f64; FEW],
        rates: &[f64; FEW],
        next: &mut [f64; FEW],
        dt: f64,
        first: usize,
        leaving: &mut Vec<(usize, f64)>,
    ) {
        let piece = |potential: f64| self.pieces[1..].partition_point(|p| potential > p.above);
        for x in 0..FEW {
            let Piece { potential, slope, bend, .. } = self.pieces[piece(now[x])];
            let change = dt * rates[x];
            let (_, turns) = bent::<false>(now[x], now[x] - potential, slope, bend, change);
            if turns || piece(now[x]) != piece(next[x]) {
                leaving.push((first + x, change));
                next[x] = now[x];
            }
        }
    }

    /// The enthalpy at a potential that tells it.
    pub(super) fn enthalpy(&self, potential: f64) -> f64 {
        self.curve.as_ref().map_or(potential, |curve| curve.enthalpy_of_potential(potential))
    }
}

/// Takes potentials a step on.
pub(super) struct GoOn<'a> {
    pub(super) course: &'a Course,
    /// The potentials.
    pub(super) now: &'a [f64],
    /// Rates of enthalpies, which become the potentials after the step.
    pub(super) out: &'a mut [f64],
    pub(super) dt: f64,
    /// Takes those that leave their piece of the curve: their numbers from `first` on, and by how much their
    /// enthalpies change. They keep their potentials.
    pub(super) leaving: &'a mut Vec<(usize, f64)>,
    pub(super) first: usize,
}

impl Work for GoOn<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        match (self.course.is_bent, self.course.pieces.len()) {
            (false, 1) => self.with::<FUSED, false, 1>(),
            (false, 2) => self.with::<FUSED, false, 2>(),
            (_, 3) => self.with::<FUSED, true, 3>(),
            (_, 4) => self.with::<FUSED, true, 4>(),
            _ => self.with::<FUSED, true, MANY>(),
        }
    }
}

impl GoOn<'_> {
    /// With a curve of so many `PIECES`.
    #[inline(always)]
    fn with<const FUSED: bool, const BENT: bool, const PIECES: usize>(self) {
        let Self { course, mut now, mut out, dt, leaving, mut first } = self;
        while let Some((these, more)) = now.split_first_chunk::<FEW>() {
            let (rates, rest) = out.split_first_chunk_mut::<FEW>().expect("as many");
            course.step::<FUSED, BENT, PIECES>(these, rates, dt, first, leaving);
            (now, out, first) = (more, rest, first + FEW);
        }
        // What fills the rest up stays where it is.
        let (mut these, mut rates) = ([course.pieces[0].potential; FEW], [0.0; FEW]);
        these[..now.len()].copy_from_slice(now);
        rates[..out.len()].copy_from_slice(out);
        course.step::<FUSED, BENT, PIECES>(&these, &mut rates, dt, first, leaving);
        out.copy_from_slice(&rates[..out.len()]);
    }
}

impl Course {
    #[inline(always)]
    fn step<const FUSED: bool, const BENT: bool, const PIECES: usize>(
        &self,
        now: &[f64; FEW],
        out: &mut [f64; FEW],
        dt: f64,
        first: usize,
        leaving: &mut Vec<(usize, f64)>,
    ) {
        let (mut next, any_leaves) = match self.pieces.first_chunk::<PIECES>() {
            Some(pieces) if PIECES != MANY => few::<FUSED, BENT, PIECES>(pieces, now, out, dt),
            _ => few_of_many::<FUSED>(&self.pieces, now, out, dt),
        };
        if any_leaves {
            self.find_leaving(now, out, &mut next, dt, first, leaving);
        }
        *out = next;
    }
}

/// Where potentials go with changes of `dt` times the rates `out`, and whether any of them may leave its piece.
#[inline(always)]
fn few<const FUSED: bool, const BENT: bool, const PIECES: usize>(
    pieces: &[Piece; PIECES],
    now: &[f64; FEW],
    out: &[f64; FEW],
    dt: f64,
) -> ([f64; FEW], bool) {
    let (mut next, mut leaves) = ([0.0; FEW], 0);
    for x in 0..FEW {
        let Piece { mut slope, mut potential, mut bend, .. } = pieces[0];
        for piece in &pieces[1..] {
            let there = is_above(now[x], piece);
            slope = choose(there, piece.slope, slope);
            if BENT {
                potential = choose(there, piece.potential, potential);
                bend = choose(there, piece.bend, bend);
            }
        }
        let change = dt * out[x];
        let (after, turns) = match BENT {
            true => bent::<FUSED>(now[x], now[x] - potential, slope, bend, change),
            false => (multiply_add::<FUSED>(slope, change, now[x]), false),
        };
        leaves |= u64::from(turns);
        for piece in &pieces[1..] {
            leaves |= u64::from(is_above(now[x], piece) != is_above(after, piece));
        }
        next[x] = after;
    }
    (next, leaves != 0)
}

/// The same with a curve of many pieces, one after the other.
#[inline(always)]
fn few_of_many<const FUSED: bool>(
    pieces: &[Piece],
    now: &[f64; FEW],
    out: &[f64; FEW],
    dt: f64,
) -> ([f64; FEW], bool) {
    let mut slopes = [pieces[0].slope; FEW];
    let (mut starts, mut bends) = ([pieces[0].potential; FEW], [pieces[0].bend; FEW]);
    for piece in &pieces[1..] {
        for x in 0..FEW {
            let there = is_above(now[x], piece);
            slopes[x] = choose(there, piece.slope, slopes[x]);
            starts[x] = choose(there, piece.potential, starts[x]);
            bends[x] = choose(there, piece.bend, bends[x]);
        }
    }
    let (mut next, mut leaves) = ([0.0; FEW], 0);
    for x in 0..FEW {
        let (rise, change) = (now[x] - starts[x], dt * out[x]);
        let (after, turns) = bent::<FUSED>(now[x], rise, slopes[x], bends[x], change);
        leaves |= u64::from(turns);
        next[x] = after;
    }
    for piece in &pieces[1..] {
        for x in 0..FEW {
            leaves |= u64::from(is_above(now[x], piece) != is_above(next[x], piece));
        }
    }
    (next, leaves != 0)
}

/// Where a potential goes, from `rise` above the start of a piece, and whether it turns within the piece: that is
/// no part of a curve, which never falls.
#[inline(always)]
fn bent<const FUSED: bool>(now: f64, rise: f64, slope: f64, bend: f64, change: f64) -> (f64, bool) {
    let square = multiply_add::<FUSED>(4.0 * bend, rise, slope * slope);
    let slope = if square > 0.0 { square } else { 0.0 }.sqrt();
    let end = multiply_add::<FUSED>(2.0 * bend, change, slope);
    (multiply_add::<FUSED>(0.5 * change, slope + end, now), end < 0.0)
}

/// Whether a potential is above the start of a piece: by the sign of a difference, which a choice takes as it is.
#[inline(always)]
fn is_above(potential: f64, piece: &Piece) -> bool {
    (piece.above - potential).is_sign_negative()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::model::wide;
    use crate::model::{Conductivity, Melting};

    /// Melting between 400 K and a liquidus (K).
    pub(in crate::solver::cpu) fn melting(liquidus: f64) -> Melting {
        Melting {
            solidus: 400.0,
            liquidus,
            latent: 5e8,
            conductivity: Conductivity::constant(200.0),
            capacity: 3e6,
        }
    }

    fn curves() -> Vec<HeatCurve> {
        let points = (0..9).map(|k| [300.0 + 10.0 * f64::from(k), 300.0 + f64::from(k * k)]);
        let many = Conductivity::of_points(points.collect());
        let constant = Conductivity::constant(300.0);
        vec![
            HeatCurve::new(&constant, 2.5e6, None),
            HeatCurve::new(&constant, 2.5e6, Some(&melting(400.0))),
            HeatCurve::new(&constant, 2.5e6, Some(&melting(420.0))),
            HeatCurve::new(&many, 2.5e6, None),
            HeatCurve::new(&many, 2.5e6, Some(&melting(400.0))),
        ]
    }

    #[test]
    fn potentials_go_where_their_enthalpies_do() {
        for curve in curves() {
            let course = Course::of(Some(&Arc::new(curve.clone())));
            let told = |enthalpy: &f64| course.tells(*enthalpy, course.potential(*enthalpy));
            let all = (0..5000).map(|k| 250.03 + 0.1 * f64::from(k));
            let before: Vec<f64> = all.filter(told).collect();
            let now: Vec<f64> = before.iter().map(|h| course.potential(*h)).collect();
            let change = |k: usize| 0.7 * ((7 * k % 31) as f64 - 15.0);
            let mut out: Vec<f64> = (0..before.len()).map(change).collect();
            let (mut leaving, dt) = (Vec::new(), 0.5);
            let (course, now, first) = (&course, &now[..], 0);
            wide::run(GoOn { course, now, out: &mut out, dt, leaving: &mut leaving, first });
            let mut off: f64 = 0.0;
            for (k, (before, after)) in before.iter().zip(&out).enumerate() {
                let expected = course.potential(before + dt * change(k));
                match leaving.binary_search_by_key(&k, |&(place, _)| place) {
                    Ok(found) => {
                        assert_eq!(leaving[found].1, dt * change(k));
                        assert_eq!(*after, now[k], "it keeps its potential");
                    }
                    Err(_) => off = off.max((after - expected).abs()),
                }
            }
            assert!(off < 1e-10, "{off:e}");
            assert!(leaving.len() < before.len() / 5, "few leave");
            let segments = curve.segments().len();
            assert_eq!(leaving.is_empty(), segments == 1, "{segments} segments");
        }
    }

    #[test]
    fn a_potential_tells_its_enthalpy_where_nothing_melts_at_it() {
        for curve in curves() {
            let course = Course::of(Some(&Arc::new(curve.clone())));
            let flat = |enthalpy: f64| curve.slope(enthalpy) == 0.0;
            for enthalpy in (0..5000).map(|k| 250.03 + 0.1 * f64::from(k)) {
                let potential = course.potential(enthalpy);
                assert_eq!(course.tells(enthalpy, potential), !flat(enthalpy), "{enthalpy}");
                if !flat(enthalpy) {
                    assert!((course.enthalpy(potential) - enthalpy).abs() < 1e-9, "{enthalpy}");
                }
            }
            assert!(!course.tells(500.0, f64::NAN));
        }
    }
}
