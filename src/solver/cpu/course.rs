//! How potentials go on as enthalpies change, where their slope changes by melting at one temperature alone.
//!
//! With constant conductivities a change delta of the enthalpy takes the potential psi of a solid to psi + s delta,
//! where s = d psi / d theta is the slope of solids, and that of a liquid by the slope of liquids. So a step reads
//! and writes one value of a particle, as it does of a temperature, and an operator can write it as it finds the rate.
//! A potential does not tell the enthalpy of what melts: those particles are [`Latent`](super::latent::Latent), and
//! what passes the melting point is looked for after the step.

use std::ops::Range;
use std::sync::Arc;

use super::operator::Combine;
use crate::model::material::Segment;
use crate::model::wide::{Work, multiply_add};
use crate::model::{HeatCurve, Material};

/// Values that are looked at together.
const FEW: usize = 32;
/// The same at the end of a run, but for the last ones.
const FEWER: usize = 4;

/// The potential of a material that melts at one temperature or not at all, as its enthalpy changes.
pub(super) struct Course {
    /// Of a solid and of a liquid.
    phases: [Phase; 2],
    /// Enthalpies between which it melts, K.
    begins: f64,
    ends: f64,
    /// The potential there, K: what is above it is liquid.
    melts: f64,
    /// None where enthalpy, temperature and potential are one.
    curve: Option<Arc<HeatCurve>>,
}

/// A phase of constant properties.
#[derive(Clone, Copy)]
struct Phase {
    /// d psi / d theta.
    slope: f64,
    /// d T / d psi.
    warming: f64,
    /// Potential and temperature of one of its states, K.
    potential: f64,
    temperature: f64,
    /// W/(m K)
    conductivity: f64,
}

impl Course {
    /// That of a material, if its conductivity is constant in each phase and it melts, if it does, at one temperature.
    pub(super) fn of(material: &Material) -> Option<Self> {
        let Some(curve) = &material.curve else {
            let conductivity = material.conductivity;
            let phase =
                Phase { slope: 1.0, warming: 1.0, potential: 0.0, temperature: 0.0, conductivity };
            let never = f64::INFINITY;
            let (phases, curve) = ([phase, phase], None);
            return Some(Self { phases, begins: never, ends: never, melts: never, curve });
        };
        let [solid, flat, liquid] = curve.phases()?;
        let phase = |segment: &Segment| Phase {
            slope: segment.slope,
            warming: segment.warming / segment.slope,
            potential: flat.potential,
            temperature: flat.temperature,
            conductivity: curve.conductivity_of(segment)[0],
        };
        Some(Self {
            phases: [solid, liquid].map(phase),
            begins: flat.start,
            ends: liquid.start,
            // The sign of a difference to it counts, also to 0.
            melts: flat.potential + 0.0,
            curve: Some(Arc::clone(curve)),
        })
    }

    /// A step of `dt` (s), which takes potentials on by rates of enthalpies.
    pub(super) fn step(&self, dt: f64) -> Combine {
        let factors = self.phases.each_ref().map(|phase| dt * phase.slope);
        Combine { share: 1.0, factors, limit: self.melts }
    }

    /// Whether a potential tells its enthalpy.
    pub(super) fn tells(&self, enthalpy: f64, potential: f64) -> bool {
        // No number tells nothing.
        (enthalpy <= self.begins && potential <= self.melts)
            || (enthalpy > self.ends && potential > self.melts)
    }

    /// Whether what has been melting, with this potential, still does with a new enthalpy: its potential stays as it is.
    #[inline]
    pub(super) fn goes_on_melting(&self, potential: f64, enthalpy: f64) -> bool {
        potential == self.melts && self.melts_at(enthalpy)
    }

    #[inline]
    fn melts_at(&self, enthalpy: f64) -> bool {
        self.begins < enthalpy && enthalpy < self.ends
    }

    /// The potential at an enthalpy; what is solid is not above where it melts.
    pub(super) fn potential(&self, enthalpy: f64) -> f64 {
        let Some(curve) = &self.curve else {
            return enthalpy;
        };
        if self.melts_at(enthalpy) {
            return self.melts;
        }
        let of_curve = curve.potential(enthalpy);
        let is_liquid = enthalpy >= self.ends;
        if !is_liquid && of_curve > self.melts { self.melts } else { of_curve }
    }

    /// The enthalpy at a potential that tells it.
    pub(super) fn enthalpy(&self, potential: f64) -> f64 {
        self.curve.as_ref().map_or(potential, |curve| curve.enthalpy_of_potential(potential))
    }

    /// T (K), psi (K) and k (W/(m K)) at a potential (K) that tells the enthalpy.
    #[inline]
    pub(super) fn state(&self, potential: f64) -> [f64; 3] {
        let phase = &self.phases[usize::from(potential > self.melts)];
        let temperature = phase.temperature + phase.warming * (potential - phase.potential);
        [temperature, potential, phase.conductivity]
    }
}

/// Finds what passes the melting point in a step, of which it takes the last part where operators have written rates.
pub(super) struct Crossings<'a, R> {
    /// Places that follow each other, and what takes those of each run a step on.
    pub(super) runs: R,
    /// The potentials before it.
    pub(super) now: &'a [f64],
    /// Those after it, or where `of_rates` the rates, which become them.
    pub(super) out: &'a mut [f64],
    pub(super) of_rates: bool,
    /// Takes the places that do, where potentials are from place `first` on.
    pub(super) found: &'a mut Vec<usize>,
    pub(super) first: usize,
}

impl<R: Iterator<Item = (Range<usize>, Combine)>> Work for Crossings<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        match self.of_rates {
            true => self.look::<FUSED, true>(),
            false => self.look::<FUSED, false>(),
        }
    }
}

impl<R: Iterator<Item = (Range<usize>, Combine)>> Crossings<'_, R> {
    #[inline(always)]
    fn look<const FUSED: bool, const RATES: bool>(self) {
        let Self { runs, now, out, found, first, .. } = self;
        for (run, step) in runs {
            let local = run.start - first..run.end - first;
            let mut rest =
                Rest { step, now: &now[local.clone()], out: &mut out[local], first: run.start };
            rest.look::<FUSED, RATES, FEW>(found);
            // Runs between materials may be short.
            rest.look::<FUSED, RATES, FEWER>(found);
            rest.look::<FUSED, RATES, 1>(found);
        }
    }
}

/// What is left of a run, whose potentials are from place `first` on.
struct Rest<'a> {
    step: Combine,
    now: &'a [f64],
    out: &'a mut [f64],
    first: usize,
}

impl Rest<'_> {
    /// Looks at as many as there are `COUNT` together of.
    #[inline(always)]
    fn look<const FUSED: bool, const RATES: bool, const COUNT: usize>(
        &mut self,
        found: &mut Vec<usize>,
    ) {
        let Self { step, mut now, .. } = *self;
        let mut out = std::mem::take(&mut self.out);
        while let Some((few, rest)) = now.split_first_chunk::<COUNT>() {
            let (these, others) = out.split_first_chunk_mut::<COUNT>().expect("as many");
            if any_crosses::<FUSED, RATES, COUNT>(step, few, these) {
                find(step, few, these, found, self.first);
            }
            (now, out) = (rest, others);
            self.first += COUNT;
        }
        (self.now, self.out) = (now, out);
    }
}

/// Whether any of a few potentials passes the melting point; with `RATES`, takes them on by these, which are in `out`.
#[inline(always)]
fn any_crosses<const FUSED: bool, const RATES: bool, const COUNT: usize>(
    step: Combine,
    now: &[f64; COUNT],
    out: &mut [f64; COUNT],
) -> bool {
    let (mut next, mut any) = (*out, 0);
    for x in 0..COUNT {
        if RATES {
            next[x] = multiply_add::<FUSED>(step.factor(now[x]), out[x], now[x]);
        }
        // Bits of signs, since a processor puts them together for several at once.
        any |= step.room(now[x]).to_bits() ^ step.room(next[x]).to_bits();
    }
    if RATES {
        *out = next;
    }
    any >> 63 != 0
}

/// Finds those of a few that do: rarely needed.
#[cold]
#[inline(never)]
fn find(step: Combine, now: &[f64], next: &[f64], found: &mut Vec<usize>, first: usize) {
    for ((&now, &next), place) in now.iter().zip(next).zip(first..) {
        if step.room(now).is_sign_negative() != step.room(next).is_sign_negative() {
            found.push(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::wide;
    use crate::model::{Conductivity, Melting};

    /// Melting between 400 K and a liquidus (K).
    fn melting(liquidus: f64) -> Melting {
        Melting {
            solidus: 400.0,
            liquidus,
            latent: 5e8,
            conductivity: Conductivity::constant(200.0),
            capacity: 3e6,
        }
    }

    fn material(solid: &Conductivity, melting: Option<&Melting>) -> Material {
        Material::thermal("metal", solid, 2.5e6, melting, 1.0)
    }

    /// Melts at 400 K.
    fn melts() -> Material {
        material(&Conductivity::constant(300.0), Some(&melting(400.0)))
    }

    fn enthalpies() -> impl Iterator<Item = f64> {
        (0..5000).map(|k| 250.03 + 0.1 * f64::from(k))
    }

    /// The potentials after a step of `dt` (s), and what passes the melting point in it.
    fn after(course: &Course, now: &[f64], rates: Vec<f64>, dt: f64) -> (Vec<f64>, Vec<usize>) {
        let find = |of_rates: bool, mut out: Vec<f64>| {
            let middle = now.len() / 2;
            let runs = [0..middle, middle..now.len()]
                .map(|run| (7 + run.start..7 + run.end, course.step(dt)));
            let (runs, mut found) = (runs.into_iter(), Vec::new());
            wide::run(Crossings {
                runs,
                now,
                out: &mut out,
                of_rates,
                found: &mut found,
                first: 7,
            });
            (out, found.iter().map(|place| place - 7).collect())
        };
        let after = find(true, rates);
        assert_eq!(find(false, after.0.clone()), after, "what the operator wrote remains");
        after
    }

    #[test]
    fn potentials_go_where_their_enthalpies_do() {
        let course = Course::of(&melts()).expect("a straight curve");
        let told = |enthalpy: &f64| course.tells(*enthalpy, course.potential(*enthalpy));
        let before: Vec<f64> = enthalpies().filter(told).collect();
        let now: Vec<f64> = before.iter().map(|h| course.potential(*h)).collect();
        let (change, dt) = (|k: usize| 0.7 * ((7 * k % 31) as f64 - 15.0), 0.5);
        let rates: Vec<f64> = (0..before.len()).map(change).collect();
        let (out, crossings) = after(&course, &now, rates.clone(), dt);
        let mut off: f64 = 0.0;
        for (k, (before, after)) in before.iter().zip(&out).enumerate() {
            let enthalpy = before + dt * change(k);
            let expected = course.potential(enthalpy);
            match crossings.binary_search(&k) {
                Ok(_) => {
                    let [rate, rest] = course.step(dt).rate_and_rest(now[k], *after);
                    assert!((rate - rates[k]).abs() < 1e-11 && rest == now[k], "{k}: {rate}");
                    assert!((after - expected).abs() > 1e-12, "it does not go on as it was");
                }
                Err(_) => off = off.max((after - expected).abs()),
            }
        }
        assert!(off < 1e-10, "{off:e}");
        assert!(!crossings.is_empty() && crossings.len() < before.len() / 5, "few cross");
    }

    #[test]
    fn a_potential_tells_its_enthalpy_unless_it_melts() {
        let material = melts();
        let course = Course::of(&material).expect("a straight curve");
        let curve = material.curve.expect("it melts");
        for enthalpy in enthalpies() {
            let potential = course.potential(enthalpy);
            let melts = curve.slope(enthalpy) == 0.0;
            assert_eq!(course.tells(enthalpy, potential), !melts, "{enthalpy}");
            if !melts {
                assert!((course.enthalpy(potential) - enthalpy).abs() < 1e-9, "{enthalpy}");
                for (own, expected) in course.state(potential).iter().zip(curve.state(enthalpy)) {
                    assert!((own - expected).abs() < 1e-11 * expected, "{enthalpy}");
                }
            }
        }
        assert!(!course.tells(500.0, f64::NAN));
    }

    #[test]
    fn what_melts_keeps_its_potential_between_both_ends_alone() {
        let course = Course::of(&melts()).expect("a straight curve");
        let middle = 0.5 * (course.begins + course.ends);
        assert!(
            course.goes_on_melting(course.melts, middle) && !course.tells(middle, course.melts)
        );
        assert_eq!(course.potential(middle), course.melts);
        for enthalpy in [course.begins, course.ends, f64::NAN] {
            assert!(!course.goes_on_melting(course.melts, enthalpy), "{enthalpy}");
        }
        assert!(!course.goes_on_melting(course.melts.next_up(), middle));
    }

    #[test]
    fn what_does_not_melt_goes_on_with_its_rates() {
        let course = Course::of(&material(&Conductivity::constant(300.0), None)).expect("one");
        assert!(course.tells(1e9, 1e9) && !course.tells(f64::NAN, f64::NAN));
        assert_eq!([course.potential(450.0), course.enthalpy(450.0)], [450.0; 2]);
        assert_eq!(course.state(450.0), [450.0, 450.0, 300.0]);
        let now: Vec<f64> = enthalpies().take(41).collect();
        let (out, crossings) = after(&course, &now, vec![4.0; now.len()], 0.5);
        assert!(out.iter().zip(&now).all(|(out, now)| *out == now + 2.0) && crossings.is_empty());
    }

    #[test]
    fn crossings_are_found_wherever_they_are() {
        let course = Course::of(&melts()).expect("a straight curve");
        for length in [1, 3, 4, 31, 32, 39, 77, 150] {
            for place in 0..length {
                let (now, mut rates) = (vec![course.potential(500.0); length], vec![-1.0; length]);
                rates[place] = 1e-9;
                assert_eq!(after(&course, &now, rates, 0.5).1, [place], "of {length}");
            }
        }
    }

    #[test]
    fn only_what_melts_at_one_temperature_between_constant_conductivities_has_one() {
        let rising = Conductivity::of_points(vec![[300.0, 300.0], [350.0, 320.0]]);
        let constant = Conductivity::constant(300.0);
        assert!(Course::of(&material(&rising, None)).is_none());
        for (solid, liquidus) in [(&rising, 400.0), (&rising, 420.0), (&constant, 420.0)] {
            assert!(Course::of(&material(solid, Some(&melting(liquidus)))).is_none());
        }
    }
}
