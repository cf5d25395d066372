//! How potentials go on as enthalpies change, where conductivities are constant but for melting.
//!
//! A change delta of the enthalpy takes the potential psi of a solid to psi + s delta, where s = d psi / d theta is the
//! slope of solids, and that of a liquid by the slope of liquids. So a step reads and writes one value of a particle, as
//! it does of a temperature, and an operator can write it as it finds the rate. What passes to another phase, or is
//! [between them](super::mushy), is looked for after the step. A potential does not tell the enthalpy of what melts at
//! one temperature: those particles are [`Latent`](super::latent::Latent).

use std::sync::Arc;

use super::mushy::{Mushy, MushyStep};
use super::operator::Combine;
use crate::model::material::Segment;
use crate::model::wide::{choose, multiply_add};
use crate::model::{HeatCurve, Material};

/// The potential of a material of which each phase has one conductivity, as its enthalpy changes.
pub(super) struct Course {
    /// Of a solid and of a liquid.
    phases: [Phase; 2],
    /// Enthalpies between which it melts, K.
    begins: f64,
    ends: f64,
    /// The potential above which it is liquid, K.
    melts: f64,
    /// How much more what melts at one temperature conducts as its enthalpy rises, W/(m K2).
    rise: f64,
    /// What it is in between, if it melts over a range.
    mushy: Option<Mushy>,
    /// None where enthalpy, temperature and potential are one.
    curve: Option<Arc<HeatCurve>>,
}

/// A step that takes potentials on.
pub(super) struct CourseStep {
    /// Of what is solid and of what is liquid.
    pub(super) phases: Combine,
    /// Of what is in between.
    pub(super) mushy: Option<MushyStep>,
    /// How much enthalpy a change of the potential of a solid takes; of what melts at one temperature too, as that is not
    /// above the limit of `phases`.
    pub(super) enthalpy_per_change: f64,
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
    /// That of a material, if its conductivity is constant in each phase, and its potentials tell enthalpies with nearly
    /// all digits unless it melts at one temperature.
    pub(super) fn of(material: &Material) -> Option<Self> {
        let Some(curve) = &material.curve else {
            let conductivity = material.conductivity;
            let phase =
                Phase { slope: 1.0, warming: 1.0, potential: 0.0, temperature: 0.0, conductivity };
            let never = f64::INFINITY;
            return Some(Self {
                phases: [phase, phase],
                begins: never,
                ends: never,
                melts: never,
                rise: 0.0,
                mushy: None,
                curve: None,
            });
        };
        let [solid, melting, liquid] = curve.phases()?;
        let mushy = match melting.slope == 0.0 {
            true => None,
            false => Some(Mushy::of(melting, liquid, curve.reference())?),
        };
        let phase = |segment: &Segment, end: &Segment| Phase {
            slope: segment.slope,
            warming: segment.warming / segment.slope,
            potential: end.potential,
            temperature: end.temperature,
            conductivity: curve.conductivity_of(segment)[0],
        };
        let (begins, ends) = (melting.start, liquid.start);
        let phases = [phase(solid, melting), phase(liquid, liquid)];
        let [of_solid, of_liquid] = phases.each_ref().map(|phase| phase.conductivity);
        Some(Self {
            phases,
            begins,
            ends,
            rise: (of_liquid - of_solid) / (ends - begins),
            // The sign of a difference to it counts, also to 0.
            melts: liquid.potential + 0.0,
            mushy,
            curve: Some(Arc::clone(curve)),
        })
    }

    /// A step of `dt` (s), which takes potentials on by rates of enthalpies.
    pub(super) fn step(&self, dt: f64) -> CourseStep {
        let factors = self.phases.each_ref().map(|phase| dt * phase.slope);
        let phases = Combine { share: 1.0, factors, limit: self.melts };
        let mushy = self.mushy.as_ref().map(|mushy| mushy.step(dt));
        CourseStep { phases, mushy, enthalpy_per_change: 1.0 / self.phases[0].slope }
    }

    /// Whether a potential tells its enthalpy.
    pub(super) fn tells(&self, enthalpy: f64, potential: f64) -> bool {
        // No number tells nothing.
        match self.mushy {
            Some(_) => !enthalpy.is_nan() && !potential.is_nan(),
            None => {
                (enthalpy <= self.begins && potential <= self.melts)
                    || (enthalpy > self.ends && potential > self.melts)
            }
        }
    }

    /// Whether what has been melting at one temperature, with this potential, still does with a new enthalpy: its
    /// potential stays as it is.
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
        let of_curve = curve.potential(enthalpy);
        if self.mushy.is_some() {
            return of_curve;
        }
        if self.melts_at(enthalpy) {
            return self.melts;
        }
        let is_liquid = enthalpy >= self.ends;
        if !is_liquid && of_curve > self.melts { self.melts } else { of_curve }
    }

    /// The enthalpy at a potential that tells it.
    pub(super) fn enthalpy(&self, potential: f64) -> f64 {
        self.curve.as_ref().map_or(potential, |curve| curve.enthalpy_of_potential(potential))
    }

    /// An enthalpy (K) at which [`Self::states`] has the conductivity of a solid: that where melting begins, unless it
    /// does not matter, as it may be infinite then.
    #[inline(always)]
    pub(super) fn unmelted(&self) -> f64 {
        if self.rise == 0.0 { 0.0 } else { self.begins }
    }

    /// T (K) and k (W/(m K)) at a potential (K), and at the enthalpy `melting` (K) of what melts at one temperature,
    /// [`Self::unmelted`] of anything else: with the liquid k goes from one phase's to the other's.
    #[inline(always)]
    fn state<const FUSED: bool>(&self, potential: f64, melting: f64) -> [f64; 2] {
        if let Some(mushy) = self.mushy.as_ref().filter(|mushy| mushy.has(potential)) {
            return mushy.state(potential);
        }
        self.state_of_phases::<FUSED>(potential, melting)
    }

    /// The same of what is not in between, without a branch.
    #[inline(always)]
    fn state_of_phases<const FUSED: bool>(&self, potential: f64, melting: f64) -> [f64; 2] {
        let [solid, liquid] = &self.phases;
        // As in the step: a sign, which several at once are chosen by.
        let is_liquid = (self.melts - potential).is_sign_negative();
        let of = |get: fn(&Phase) -> f64| choose(is_liquid, get(liquid), get(solid));
        let above = potential - of(|phase| phase.potential);
        let temperature =
            multiply_add::<FUSED>(of(|phase| phase.warming), above, of(|phase| phase.temperature));
        let of_melting =
            multiply_add::<FUSED>(self.rise, melting - self.unmelted(), solid.conductivity);
        [temperature, choose(is_liquid, liquid.conductivity, of_melting)]
    }

    /// [`Self::state`] of several: T and k of all.
    #[inline(always)]
    pub(super) fn states<const COUNT: usize, const FUSED: bool>(
        &self,
        potentials: &[f64; COUNT],
        melting: &[f64; COUNT],
    ) -> [[f64; COUNT]; 2] {
        let [mut temperatures, mut conductivities] = [[0.0; COUNT]; 2];
        if self.mushy.is_none() {
            for x in 0..COUNT {
                [temperatures[x], conductivities[x]] =
                    self.state_of_phases::<FUSED>(potentials[x], melting[x]);
            }
        } else {
            for x in 0..COUNT {
                [temperatures[x], conductivities[x]] =
                    self.state::<FUSED>(potentials[x], melting[x]);
            }
        }
        [temperatures, conductivities]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::model::{Conductivity, Melting};

    fn material(solid: &Conductivity, melting: Option<&Melting>) -> Material {
        Material::thermal("metal", solid, 2.5e6, melting, 1.0)
    }

    /// Melting from 400 K to a liquidus (K) to what has a conductivity (W/(m K)).
    fn melting(liquidus: f64, conductivity: f64) -> Melting {
        Melting {
            solidus: 400.0,
            liquidus,
            latent: 5e8,
            conductivity: Conductivity::constant(conductivity),
            capacity: 3e6,
        }
    }

    /// Has 300 W/(m K) as a solid, and melts so.
    pub(in crate::solver::cpu) fn melts(liquidus: f64, conductivity: f64) -> Material {
        material(&Conductivity::constant(300.0), Some(&melting(liquidus, conductivity)))
    }

    /// Does not melt.
    pub(in crate::solver::cpu) fn solid() -> Material {
        material(&Conductivity::constant(300.0), None)
    }

    /// From those of solids to those of liquids, K.
    pub(in crate::solver::cpu) fn enthalpies() -> impl Iterator<Item = f64> {
        (0..5000).map(|k| 250.03 + 0.1 * f64::from(k))
    }

    #[test]
    fn a_potential_tells_its_enthalpy_unless_it_melts_at_one_temperature() {
        for (liquidus, conductivity) in [(400.0, 200.0), (420.0, 200.0), (420.0, 900.0)] {
            let material = melts(liquidus, conductivity);
            let course = Course::of(&material).expect("constant phases");
            let curve = material.curve.expect("it melts");
            for enthalpy in enthalpies() {
                let potential = course.potential(enthalpy);
                let melts = curve.slope(enthalpy) == 0.0;
                assert_eq!(course.tells(enthalpy, potential), !melts, "{enthalpy}");
                if !melts {
                    assert!((course.enthalpy(potential) - enthalpy).abs() < 1e-9, "{enthalpy}");
                }
                let is_latent = melts && course.melts_at(enthalpy);
                let melting = if is_latent { enthalpy } else { course.unmelted() };
                let [temperature, conductivity] = course.state::<false>(potential, melting);
                let own = [temperature, potential, conductivity];
                for (own, expected) in own.iter().zip(curve.state(enthalpy)) {
                    assert!((own - expected).abs() < 1e-11 * expected, "{enthalpy}");
                }
            }
            assert!(!course.tells(500.0, f64::NAN) && !course.tells(f64::NAN, 500.0));
        }
    }

    #[test]
    fn what_melts_keeps_its_potential_between_both_ends_alone() {
        let course = Course::of(&melts(400.0, 200.0)).expect("constant phases");
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
    fn what_does_not_melt_has_enthalpies_for_potentials() {
        let course = Course::of(&solid()).expect("one");
        assert!(course.tells(1e9, 1e9) && !course.tells(f64::NAN, f64::NAN));
        assert_eq!([course.potential(450.0), course.enthalpy(450.0)], [450.0; 2]);
        assert_eq!(course.state::<false>(450.0, course.unmelted()), [450.0, 300.0]);
    }

    #[test]
    fn only_constant_phases_have_one_and_no_range_that_is_too_flat() {
        let rising = Conductivity::of_points(vec![[300.0, 300.0], [350.0, 320.0]]);
        let constant = Conductivity::constant(300.0);
        assert!(Course::of(&material(&rising, None)).is_none());
        for liquidus in [400.0, 420.0] {
            let melting = melting(liquidus, 200.0);
            assert!(Course::of(&material(&rising, Some(&melting))).is_none());
            assert!(Course::of(&material(&constant, Some(&melting))).is_some());
        }
        // 3 K take 203 K of enthalpy; where the liquid conducts a third, the slope falls below the limit.
        for (liquidus, conductivity, has) in [(403.0, 300.0, true), (403.0, 100.0, false)] {
            let melting = melting(liquidus, conductivity);
            assert_eq!(Course::of(&material(&constant, Some(&melting))).is_some(), has);
        }
    }
}
