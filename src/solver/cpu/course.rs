//! How potentials go on as enthalpies change, where their slope changes by melting at one temperature alone.
//!
//! With constant conductivities a change delta of the enthalpy takes the potential psi of a solid to psi + s delta,
//! where s = d psi / d theta is the slope of solids, and that of a liquid by the slope of liquids. So a step reads
//! and writes one value of a particle, as it does of a temperature. A potential does not tell the enthalpy of what
//! melts: those particles are [`Latent`](super::latent::Latent).

use std::sync::Arc;

use crate::model::HeatCurve;
use crate::model::wide::{Work, choose, multiply_add};

/// Values that are worked on together, in registers.
const FEW: usize = 16;

/// The potential of a material that melts at one temperature, as its enthalpy changes.
pub(super) struct Course {
    /// d psi / d theta of a solid and of a liquid.
    slopes: [f64; 2],
    /// Enthalpies between which it melts, K.
    begins: f64,
    ends: f64,
    /// The potential there, K: what is above it is liquid.
    melts: f64,
    curve: Arc<HeatCurve>,
}

impl Course {
    /// That of a material with `curve`, if both conductivities are constant and it melts at one temperature.
    pub(super) fn of(curve: &Arc<HeatCurve>) -> Option<Self> {
        let [solid, flat, liquid] = curve.segments() else {
            return None;
        };
        let is_straight = [solid, flat, liquid].iter().all(|segment| segment.bend == 0.0);
        (is_straight && flat.slope == 0.0).then(|| Self {
            slopes: [solid.slope, liquid.slope],
            begins: flat.start,
            ends: liquid.start,
            // The sign of a difference to it counts, also to 0.
            melts: flat.potential + 0.0,
            curve: Arc::clone(curve),
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
        if self.begins < enthalpy && enthalpy < self.ends {
            return self.melts;
        }
        let of_curve = self.curve.potential(enthalpy);
        let is_liquid = enthalpy >= self.ends;
        if !is_liquid && of_curve > self.melts { self.melts } else { of_curve }
    }

    /// The enthalpy at a potential that tells it.
    pub(super) fn enthalpy(&self, potential: f64) -> f64 {
        self.curve.enthalpy_of_potential(potential)
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
        let [solid, liquid] = course.slopes;
        let step = Step { solid: dt * solid, liquid: dt * liquid, melts: course.melts };
        while let Some((these, more)) = now.split_first_chunk::<FEW>() {
            let (rates, rest) = out.split_first_chunk_mut::<FEW>().expect("as many");
            let (mut next, mut leaves) = ([0.0; FEW], 0);
            for x in 0..FEW {
                next[x] = step.one::<FUSED>(these[x], rates[x]);
                // Bits of signs, since a processor puts them together for several at once.
                leaves |= step.above(these[x]).to_bits() ^ step.above(next[x]).to_bits();
            }
            if leaves >> 63 == 0 {
                *rates = next;
            } else {
                step.some(these, rates, &mut |x, rate| leaving.push((first + x, dt * rate)));
            }
            (now, out, first) = (more, rest, first + FEW);
        }
        step.some(now, out, &mut |x, rate| leaving.push((first + x, dt * rate)));
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

    /// Writes those after the step that do not begin to melt or to freeze; calls `leaves` with the others and their
    /// rates. Rarely needed but for what is left over: beside the others, it would keep them from staying in registers.
    #[cold]
    #[inline(never)]
    fn some(self, now: &[f64], out: &mut [f64], leaves: &mut dyn FnMut(usize, f64)) {
        for (x, (&now, out)) in now.iter().zip(out).enumerate() {
            let rate = *out;
            let next = self.one::<false>(now, rate);
            let changes = self.above(now).is_sign_negative() != self.above(next).is_sign_negative();
            if changes {
                leaves(x, rate);
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

    fn curve() -> Arc<HeatCurve> {
        let constant = Conductivity::constant(300.0);
        Arc::new(HeatCurve::new(&constant, 2.5e6, Some(&melting(400.0))))
    }

    fn enthalpies() -> impl Iterator<Item = f64> {
        (0..5000).map(|k| 250.03 + 0.1 * f64::from(k))
    }

    #[test]
    fn potentials_go_where_their_enthalpies_do() {
        let course = Course::of(&curve()).expect("a straight curve");
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
        let curve = curve();
        let course = Course::of(&curve).expect("a straight curve");
        for enthalpy in enthalpies() {
            let potential = course.potential(enthalpy);
            let melts = curve.slope(enthalpy) == 0.0;
            assert_eq!(course.tells(enthalpy, potential), !melts, "{enthalpy}");
            if !melts {
                assert!((course.enthalpy(potential) - enthalpy).abs() < 1e-9, "{enthalpy}");
            }
        }
        assert!(!course.tells(500.0, f64::NAN));
    }

    #[test]
    fn only_what_melts_at_one_temperature_between_constant_conductivities_has_one() {
        let rising = Conductivity::of_points(vec![[300.0, 300.0], [350.0, 320.0]]);
        let constant = Conductivity::constant(300.0);
        for (solid, liquidus) in [(&rising, 400.0), (&rising, 420.0), (&constant, 420.0)] {
            let curve = HeatCurve::new(solid, 2.5e6, Some(&melting(liquidus)));
            assert!(Course::of(&Arc::new(curve)).is_none());
        }
    }
}
