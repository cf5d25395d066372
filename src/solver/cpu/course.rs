//! How potentials go on as enthalpies change, where their slope changes by melting at one temperature alone.
//!
//! With constant conductivities a change delta of the enthalpy takes the potential psi of a solid to psi + s delta,
//! where s = d psi / d theta is the slope of solids, and that of a liquid by the slope of liquids. So a step reads
//! and writes one value of a particle, as it does of a temperature. A potential does not tell the enthalpy of what
//! melts: those particles are [`Latent`](super::latent::Latent).

use std::sync::Arc;

use crate::model::material::Segment;
use crate::model::wide::{Work, choose, multiply_add};
use crate::model::{HeatCurve, Material};

/// Values that are worked on together, in registers.
const FEW: usize = 16;
/// The same at the end of a run.
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

    /// Whether a potential tells its enthalpy.
    pub(super) fn tells(&self, enthalpy: f64, potential: f64) -> bool {
        // No number tells nothing.
        (enthalpy <= self.begins && potential <= self.melts)
            || (enthalpy > self.ends && potential > self.melts)
    }

    /// The potential at an enthalpy; what is solid is not above where it melts.
    pub(super) fn potential(&self, enthalpy: f64) -> f64 {
        let Some(curve) = &self.curve else {
            return enthalpy;
        };
        if self.begins < enthalpy && enthalpy < self.ends {
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

/// Takes potentials a step on.
pub(super) struct GoOn<'a> {
    pub(super) course: &'a Course,
    /// The potentials.
    pub(super) now: &'a [f64],
    /// Rates of enthalpies, which become the potentials after the step.
    pub(super) out: &'a mut [f64],
    pub(super) dt: f64,
    /// Takes those that begin to melt or to freeze: their numbers from `first` on, and by how much their enthalpies
    /// change. They keep their potentials.
    pub(super) leaving: &'a mut Vec<(usize, f64)>,
    pub(super) first: usize,
}

impl Work for GoOn<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { course, mut now, mut out, dt, leaving, mut first } = self;
        let [solid, liquid] = course.phases.map(|phase| dt * phase.slope);
        let step = Step { solid, liquid, melts: course.melts };
        let mut leaves = |place: usize, rate: f64| leaving.push((place, dt * rate));
        while let Some((these, more)) = now.split_first_chunk::<FEW>() {
            let (rates, rest) = out.split_first_chunk_mut::<FEW>().expect("as many");
            step.few::<FUSED, FEW>(these, rates, first, &mut leaves);
            (now, out, first) = (more, rest, first + FEW);
        }
        // Runs between materials may be short.
        while let Some((these, more)) = now.split_first_chunk::<FEWER>() {
            let (rates, rest) = out.split_first_chunk_mut::<FEWER>().expect("as many");
            step.few::<FUSED, FEWER>(these, rates, first, &mut leaves);
            (now, out, first) = (more, rest, first + FEWER);
        }
        for (k, (now, out)) in now.iter().zip(out).enumerate() {
            let (now, out) = (std::array::from_ref(now), std::array::from_mut(out));
            step.few::<FUSED, 1>(now, out, first + k, &mut leaves);
        }
    }
}

/// A step of potentials.
#[derive(Clone, Copy)]
struct Step {
    /// Rises with a rate of a solid and of a liquid, s.
    solid: f64,
    liquid: f64,
    /// See [`Course`].
    melts: f64,
}

impl Step {
    /// How far melting is above a potential: of a liquid by its sign a negative number, which a choice takes as it
    /// is.
    #[inline(always)]
    fn above(self, potential: f64) -> f64 {
        self.melts - potential
    }

    #[inline(always)]
    fn one<const FUSED: bool>(self, now: f64, rate: f64) -> f64 {
        let rise = choose(self.above(now).is_sign_negative(), self.liquid, self.solid);
        multiply_add::<FUSED>(rise, rate, now)
    }

    /// Takes a few on, from place `first` on, whose rates are in `out`; calls `leaves` with what begins to melt or to
    /// freeze and its rate.
    #[inline(always)]
    fn few<const FUSED: bool, const COUNT: usize>(
        self,
        now: &[f64; COUNT],
        out: &mut [f64; COUNT],
        first: usize,
        leaves: &mut dyn FnMut(usize, f64),
    ) {
        let (mut next, mut any) = ([0.0; COUNT], 0);
        for x in 0..COUNT {
            next[x] = self.one::<FUSED>(now[x], out[x]);
            // Bits of signs, since a processor puts them together for several at once.
            any |= self.above(now[x]).to_bits() ^ self.above(next[x]).to_bits();
        }
        if any >> 63 == 0 {
            *out = next;
        } else {
            self.some(now, out, first, leaves);
        }
    }

    /// The same one by one: rarely needed, and beside the others it would keep them from staying in registers.
    #[cold]
    #[inline(never)]
    fn some(self, now: &[f64], out: &mut [f64], first: usize, leaves: &mut dyn FnMut(usize, f64)) {
        for (x, (&now, out)) in now.iter().zip(out).enumerate() {
            let rate = *out;
            let next = self.one::<false>(now, rate);
            let changes = self.above(now).is_sign_negative() != self.above(next).is_sign_negative();
            if changes {
                leaves(first + x, rate);
            }
            *out = if changes { now } else { next };
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

    #[test]
    fn potentials_go_where_their_enthalpies_do() {
        let course = Course::of(&melts()).expect("a straight curve");
        let told = |enthalpy: &f64| course.tells(*enthalpy, course.potential(*enthalpy));
        let before: Vec<f64> = enthalpies().filter(told).collect();
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
        assert!(!leaving.is_empty() && leaving.len() < before.len() / 5, "few leave");
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
    fn what_does_not_melt_goes_on_with_its_rates() {
        let course = Course::of(&material(&Conductivity::constant(300.0), None)).expect("one");
        assert!(course.tells(1e9, 1e9) && !course.tells(f64::NAN, f64::NAN));
        assert_eq!([course.potential(450.0), course.enthalpy(450.0)], [450.0; 2]);
        assert_eq!(course.state(450.0), [450.0, 450.0, 300.0]);
        let now: Vec<f64> = enthalpies().take(21).collect();
        let (mut out, mut leaving) = (vec![4.0; now.len()], Vec::new());
        let go_on = GoOn {
            course: &course,
            now: &now,
            out: &mut out,
            dt: 0.5,
            leaving: &mut leaving,
            first: 0,
        };
        wide::run(go_on);
        assert!(out.iter().zip(&now).all(|(out, now)| *out == now + 2.0) && leaving.is_empty());
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
