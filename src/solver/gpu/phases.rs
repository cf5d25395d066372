//! Enthalpies that potentials tell: of materials that melt at one temperature between constant conductivities, or not at
//! all.
//!
//! Explicit Euler steps take the potential of a solid or a liquid on by its slope times what is added to the enthalpy
//! (`shaders/end/phases_step.wgsl`): so a step reads and writes one value of a particle, as without melting. Enthalpies in
//! memory are up to date only where potentials are that of melting, until they are asked for.

use super::curve_passes::CurveKind;
use super::enthalpy::Curves;
use crate::gpu::Constant;
use crate::model::HeatCurve;
use crate::solver::Precision;

/// The phases of a material, in the numbers that a device has of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phases {
    precision: Precision,
    /// Enthalpies between which it melts, K.
    begins: f64,
    ends: f64,
    /// The potential there, K.
    melts: f64,
    /// d psi / d theta of a solid and of a liquid.
    slopes: [f64; 2],
}

/// How near a potential is taken for that of melting, in parts of it: a few roundings of a value.
pub(super) fn roundings(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => f64::from(4.0 * f32::EPSILON),
        // The second word has as many bits as the first.
        Precision::Compensated => f64::from(16.0 * f32::EPSILON * f32::EPSILON),
        Precision::F64 => 4.0 * f64::EPSILON,
    }
}

/// What of a state of enthalpies is up to date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum UpToDate {
    /// Enthalpies, and potentials, which go together.
    Both,
    /// Enthalpies, and potentials to within rounding.
    Enthalpies,
    /// Potentials, and enthalpies of what melts.
    Potentials,
}

/// The potential of melting of what does not melt, K: further above everything than any state gets.
pub(super) const NEVER: f64 = 1e30;

impl Phases {
    /// Those of `curve`, if its potentials tell enthalpies.
    pub(super) fn of(curve: &HeatCurve, precision: Precision) -> Option<Self> {
        let value = |number: f64| precision.on_device(&[number])[0];
        if curve.is_straight() {
            let melts = value(NEVER);
            return Some(Self { precision, begins: melts, ends: melts, melts, slopes: [1.0; 2] });
        }
        let [solid, melting, liquid] = curve.phases()?;
        if melting.slope != 0.0 {
            return None;
        }
        let real = |number: f64| {
            let real = precision.real();
            real.from_bytes(&real.to_bytes(&[number]))[0]
        };
        Some(Self {
            precision,
            begins: value(melting.start),
            ends: value(liquid.start),
            melts: value(melting.potential),
            slopes: [solid, liquid].map(|segment| real(segment.slope)),
        })
    }

    /// Some, to look at shaders with.
    pub(super) fn some(precision: Precision) -> Self {
        Self { precision, begins: 300.5, ends: 400.0, melts: 300.5, slopes: [1.0, 0.5] }
    }

    /// These numbers in shaders. As constants they cost a step nothing.
    pub(super) fn constants(&self) -> [(&'static str, Constant); 9] {
        let [melts, melts_rest, solid, liquid, begins, begins_rest, ends, ends_rest] =
            self.numbers();
        [
            ("BEGINS", begins),
            ("BEGINS_REST", begins_rest),
            ("ENDS", ends),
            ("ENDS_REST", ends_rest),
            ("MELTS", melts),
            ("MELTS_REST", melts_rest),
            ("SOLID_SLOPE", solid),
            ("LIQUID_SLOPE", liquid),
            ("WIDTH", self.width()),
        ]
        .map(|(name, number)| (name, Constant::Real(number)))
    }

    /// As they are in two vectors: see `shaders/end/phases_of_each.wgsl`.
    fn numbers(&self) -> [f64; 8] {
        let Self { precision, begins, ends, melts, slopes: [solid, liquid] } = *self;
        let [[begins, begins_rest], [ends, ends_rest], [melts, melts_rest]] =
            [begins, ends, melts].map(|number| precision.in_words(number));
        [melts, melts_rest, solid, liquid, begins, begins_rest, ends, ends_rest]
    }

    /// How near a potential is taken for that of melting, K.
    fn width(&self) -> f64 {
        roundings(self.precision) * self.melts.abs()
    }

    /// The potential of an enthalpy (K), K: of what melts that of melting, and on their side of it of all others, as in
    /// `shaders/end/phases_correction.wgsl`.
    fn potential(&self, enthalpy: f64) -> f64 {
        let Self { begins, ends, melts, slopes: [solid, liquid], .. } = *self;
        if self.never_melts() {
            return enthalpy;
        }
        let width = self.width();
        let [of_solid, of_liquid] = [solid * (enthalpy - begins), liquid * (enthalpy - ends)];
        if of_solid < -width {
            melts + of_solid
        } else if of_liquid > width {
            melts + of_liquid
        } else if enthalpy.is_finite() {
            melts
        } else {
            enthalpy
        }
    }

    /// The enthalpy (K) that a potential (K) tells, which is not that of melting.
    fn enthalpy(&self, potential: f64) -> f64 {
        let Self { begins, ends, melts, slopes: [solid, liquid], .. } = *self;
        if self.never_melts() {
            return potential;
        }
        let above = potential - melts;
        if above > 0.0 { ends + above / liquid } else { begins + above / solid }
    }

    fn never_melts(&self) -> bool {
        self.melts > 0.5 * NEVER
    }
}

/// The phases of the materials of a scene.
#[derive(Debug)]
pub(super) enum Told {
    /// All have these.
    One(Phases),
    /// By place: which of those of materials.
    Each { of: Vec<u32>, phases: Vec<Phases> },
}

impl Told {
    /// Whether all potentials of `curves` tell enthalpies.
    pub(super) fn is_of(curves: &Curves, precision: Precision) -> bool {
        curves.list().iter().all(|curve| Phases::of(curve, precision).is_some())
    }

    /// Those of `curves`, if all their potentials tell enthalpies.
    pub(super) fn of(curves: &Curves, precision: Precision) -> Option<Self> {
        match curves {
            Curves::One(curve) => Phases::of(curve, precision).map(Self::One),
            Curves::Each { of, curves } => {
                let phases = curves.iter().map(|curve| Phases::of(curve, precision));
                Some(Self::Each { of: of.clone(), phases: phases.collect::<Option<_>>()? })
            }
        }
    }

    /// Which kind of curves they make.
    pub(super) fn kind(&self) -> CurveKind {
        match self {
            Self::One(phases) => CurveKind::Phases(*phases),
            Self::Each { .. } => CurveKind::EachPhases,
        }
    }

    /// The numbers of each material, if it is not one: see `shaders/end/phases_of_each.wgsl`.
    pub(super) fn table(&self) -> Option<Vec<f64>> {
        match self {
            Self::One(_) => None,
            Self::Each { phases, .. } => Some(phases.iter().flat_map(Phases::numbers).collect()),
        }
    }

    fn at(&self, place: usize) -> &Phases {
        match self {
            Self::One(phases) => phases,
            Self::Each { of, phases } => &phases[of[place] as usize],
        }
    }

    fn precision(&self) -> Precision {
        self.at(0).precision
    }

    /// The potentials of enthalpies (K) by place, K.
    pub(super) fn potentials(&self, enthalpies: &[f64]) -> Vec<f64> {
        let of = |(place, &enthalpy): (usize, &f64)| self.at(place).potential(enthalpy);
        let potentials: Vec<f64> = enthalpies.iter().enumerate().map(of).collect();
        self.precision().on_device(&potentials)
    }

    /// Brings `enthalpies` (K) by place, of which those of what melts are up to date, to what `potentials` (K) tell. What
    /// has not changed keeps its last digit.
    pub(super) fn tell(&self, potentials: &[f64], enthalpies: &mut [f64]) {
        let before = self.potentials(enthalpies);
        let places = enthalpies.iter_mut().zip(potentials).zip(before).enumerate();
        for (place, ((enthalpy, &potential), before)) in places {
            let phases = self.at(place);
            if potential != phases.melts && potential != before {
                *enthalpy = phases.enthalpy(potential);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Conductivity, Melting};

    fn curve(liquidus: f64) -> HeatCurve {
        let melting = Melting {
            solidus: 400.0,
            liquidus,
            latent: 5e8,
            conductivity: Conductivity::constant(200.0),
            capacity: 3e6,
        };
        HeatCurve::new(&Conductivity::constant(300.0), 2.5e6, Some(&melting))
    }

    #[test]
    fn potentials_tell_enthalpies_but_of_what_melts() {
        for precision in Precision::ALL {
            let curve = curve(400.0);
            let phases = Phases::of(&curve, precision).expect("constant in each phase");
            let phases = Told::One(phases);
            let numbers: Vec<f64> = (0..5000).map(|k| 250.03 + 0.1 * f64::from(k)).collect();
            let enthalpies = precision.on_device(&numbers);
            let potentials = phases.potentials(&enthalpies);
            let digits = match precision {
                Precision::F32 => 1e-4,
                Precision::Compensated => 1e-10,
                Precision::F64 => 1e-12,
            };
            let mut told = vec![0.0; enthalpies.len()];
            phases.tell(&potentials, &mut told);
            for ((&enthalpy, &potential), &told) in enthalpies.iter().zip(&potentials).zip(&told) {
                let off = (potential - curve.potential(enthalpy)).abs();
                assert!(off < 1e-4, "{precision:?}, {enthalpy}: {off:e}");
                let melts = curve.slope(enthalpy) == 0.0;
                let off = (told - enthalpy).abs();
                assert!((off < digits) != melts, "{precision:?}, {enthalpy}: {off:e}");
            }
            let mut unchanged = enthalpies.clone();
            phases.tell(&potentials, &mut unchanged);
            assert_eq!(unchanged, enthalpies);
        }
    }

    #[test]
    fn a_potential_is_that_of_melting_or_can_be_told_from_it() {
        for precision in Precision::ALL {
            let own = Phases::of(&curve(400.0), precision).expect("constant in each phase");
            let phases = Told::One(own);
            let near =
                [1e-20, 1e-15, 1e-13, 1e-11, 1e-6, 1e-3].map(|by| [400.0 - by, own.ends + by]);
            let enthalpies = precision.on_device(near.as_flattened());
            let potentials = phases.potentials(&enthalpies);
            let mut told = enthalpies.clone();
            // What does not melt has changed since.
            for (told, potential) in told.iter_mut().zip(&potentials) {
                *told = if *potential == own.melts { *told } else { 7.0 };
            }
            phases.tell(&potentials, &mut told);
            let most = 4.0 * roundings(precision);
            for (told, enthalpy) in told.iter().zip(&enthalpies) {
                let off = (told - enthalpy).abs() / enthalpy;
                assert!(off <= most, "{precision:?}, {enthalpy}: {off:e}");
            }
            assert!(potentials[0] == 400.0 && potentials[11] > 400.0 && potentials[10] < 400.0);
            assert!(phases.potentials(&[f64::NAN])[0].is_nan());
        }
    }

    #[test]
    fn what_melts_over_a_range_has_no_phases() {
        assert!(Phases::of(&curve(420.0), Precision::F64).is_none());
    }

    #[test]
    fn each_place_is_told_of_its_own_material() {
        for precision in Precision::ALL {
            let brick = HeatCurve::new(&Conductivity::constant(300.0), 2.5e6, None);
            let curves = Curves::Each { of: vec![0, 1, 1, 0], curves: vec![curve(400.0), brick] };
            let told = Told::of(&curves, precision).expect("constant in each phase");
            let enthalpies = precision.on_device(&[500.1, 500.1, 350.2, 350.2]);
            let potentials = told.potentials(&enthalpies);
            assert_eq!(potentials[0], precision.on_device(&[400.0])[0], "it melts");
            assert_eq!(potentials[1..3], enthalpies[1..3], "it does not");
            let mut after = enthalpies.clone();
            let warmer = precision.on_device(&[400.0, 510.3, 340.4, 340.4]);
            told.tell(&warmer, &mut after);
            assert_eq!(after[..3], [enthalpies[0], warmer[1], warmer[2]]);
            assert!((after[3] - 340.4).abs() < 1e-4);
        }
    }
}
