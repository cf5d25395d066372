//! Temperature and heat potential as functions of enthalpy.
//!
//! Where conductivity changes with temperature or a material melts, three quantities of a particle take
//! the part that its temperature alone has elsewhere, all in K:
//!
//! - the **enthalpy** theta, the enthalpy of a unit volume over rho c of the cold solid: what is conserved
//!   and what steps change. It is the temperature below melting;
//! - the **temperature** T(theta);
//! - the **potential** psi(theta), the integral of k dT over the reference conductivity (Kirchhoff 1894):
//!   what heat flows down. Since k grad T = k_ref grad psi, the operator of a constant conductivity, walls
//!   included, gives the flow exactly as it gives that of a temperature, and steady profiles of psi are
//!   straight whatever k(T) is.
//!
//! So d theta/dt = A psi(theta) + s, the enthalpy method (Eyres et al. 1946; Voller and Cross 1981, Int. J.
//! Heat Mass Transfer 24, 545): no front is followed, and melting and freezing need nothing more.

use super::Conductivity;
use crate::model::wide::multiply_add;

/// What a material needs in order to melt, and what it is once it has.
#[derive(Clone, Debug, PartialEq)]
pub struct Melting {
    /// Temperature at which melting begins, K.
    pub solidus: f64,
    /// Temperature at which it ends, K: the solidus where the melting point is sharp.
    pub liquidus: f64,
    /// Latent heat of a unit volume, J/m3, positive.
    pub latent: f64,
    /// Conductivity of the liquid.
    pub conductivity: Conductivity,
    /// Capacity rho c of a unit volume of the liquid, J/(m3 K), positive.
    pub capacity: f64,
}

/// A stretch of enthalpy over which k is straight in T, and T in enthalpy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Enthalpy where it begins, K.
    pub start: f64,
    /// Temperature there, K.
    pub temperature: f64,
    /// dT / d theta, not negative; 0 where all heat is latent.
    pub warming: f64,
    /// Potential there, K.
    pub potential: f64,
    /// d psi / d theta there, not negative.
    pub slope: f64,
    /// Half of d2 psi / d theta2.
    pub bend: f64,
}

impl Segment {
    fn temperature_at(&self, enthalpy: f64) -> f64 {
        self.temperature + self.warming * (enthalpy - self.start)
    }

    /// psi at an enthalpy (K) of it, K; with `FUSED`, rounded less often.
    #[inline(always)]
    pub(crate) fn potential_at<const FUSED: bool>(&self, enthalpy: f64) -> f64 {
        let above = enthalpy - self.start;
        let rise = multiply_add::<FUSED>(self.bend, above, self.slope);
        multiply_add::<FUSED>(above, rise, self.potential)
    }

    fn slope_at(&self, enthalpy: f64) -> f64 {
        self.slope + 2.0 * self.bend * (enthalpy - self.start)
    }
}

/// Temperature and potential of a material as functions of its enthalpy. Both never fall.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatCurve {
    /// Ascending. The first goes on below its start, the last has no end.
    segments: Vec<Segment>,
    /// Enthalpies between which it melts, K.
    melting: Option<[f64; 2]>,
    /// What it melts to.
    melt: Option<Melting>,
    /// Reference conductivity, W/(m K).
    reference: f64,
    /// Temperatures between which the conductivity is known, K.
    limits: [f64; 2],
}

impl HeatCurve {
    /// The curve of a solid of conductivity `solid` and capacity `capacity` (rho c, J/(m3 K)) that melts as
    /// `melting` says. The reference conductivity is the solid's where it melts, else its largest: against one
    /// that goes to 0 somewhere, potentials would be too large for a step to show in their digits.
    pub fn new(solid: &Conductivity, capacity: f64, melting: Option<&Melting>) -> Self {
        let end = melting.map_or(f64::INFINITY, |melting| melting.solidus);
        let reference = melting.map_or(solid.largest(), |melting| solid.at(melting.solidus));
        let mut temperatures: Vec<f64> = solid.within(f64::NEG_INFINITY, end).collect();
        // Below the first point k is constant: one straight segment does for what lies under it.
        let first =
            temperatures.first().copied().unwrap_or(if end.is_finite() { end } else { 0.0 });
        temperatures.insert(0, first - 1.0);
        let start = first - 1.0;
        let mut made =
            Builder { segments: Vec::new(), enthalpy: start, potential: start, reference };
        if end.is_finite() {
            temperatures.push(end);
        }
        for two in temperatures.windows(2) {
            made.heat(two[0], two[1], solid.at(two[0]), solid.at(two[1]), two[1] - two[0]);
        }
        let Some(melting) = melting else {
            let last = temperatures[temperatures.len() - 1];
            made.go_on(last, solid.at(last), 1.0);
            return Self::anchored(made.segments, None, reference).limited(solid.limits());
        };
        let ratio = melting.capacity / capacity;
        let (solidus, liquidus) = (melting.solidus, melting.liquidus);
        let begins = made.enthalpy;
        let span = melting.latent / capacity + 0.5 * (1.0 + ratio) * (liquidus - solidus);
        made.heat(solidus, liquidus, solid.at(solidus), melting.conductivity.at(liquidus), span);
        let ends = made.enthalpy;
        let mut temperatures = vec![liquidus];
        temperatures.extend(melting.conductivity.within(liquidus, f64::INFINITY));
        let k = |t: f64| melting.conductivity.at(t);
        for two in temperatures.windows(2) {
            made.heat(two[0], two[1], k(two[0]), k(two[1]), ratio * (two[1] - two[0]));
        }
        let last = temperatures[temperatures.len() - 1];
        made.go_on(last, k(last), 1.0 / ratio);
        let [least, _] = solid.limits();
        let [_, most] = melting.conductivity.limits();
        let made = Self::anchored(made.segments, Some([begins, ends]), reference);
        Self { melt: Some(melting.clone()), ..made.limited([least, most]) }
    }

    /// The same where the conductivity is only known between two temperatures (K): beyond, potentials are no
    /// numbers.
    fn limited(mut self, limits: [f64; 2]) -> Self {
        let unknown = |start: f64, temperature: f64| {
            let warming = 1.0;
            Segment { start, temperature, warming, potential: f64::NAN, slope: f64::NAN, bend: 0.0 }
        };
        let [least, most] = limits;
        if most.is_finite() {
            let start = self.enthalpy(most);
            self.segments.retain(|segment| segment.start < start);
            self.segments.push(unknown(start.next_up(), most));
        }
        if least.is_finite() {
            let [potential, start] = [self.potential_at(least), self.enthalpy(least)];
            let slope = self.slope(start);
            let first =
                Segment { start, temperature: least, potential, slope, ..*self.segment(start) };
            self.segments.retain(|segment| segment.start > start);
            self.segments.splice(..0, [unknown(start - 1.0, least - 1.0), first]);
        }
        self.limits = limits;
        self
    }

    /// Moves potentials so that they are temperatures where the material melts or the first point lies.
    fn anchored(mut segments: Vec<Segment>, melting: Option<[f64; 2]>, reference: f64) -> Self {
        let at = |segment: &Segment| segment.temperature - segment.potential;
        let shift = match melting {
            Some([begins, _]) => {
                let melts = segments.iter().find(|segment| segment.start == begins);
                melts.map_or(0.0, at)
            }
            None => segments.get(1).map_or(0.0, at),
        };
        segments.iter_mut().for_each(|segment| segment.potential += shift);
        let limits = [f64::NEG_INFINITY, f64::INFINITY];
        Self { segments, melting, melt: None, reference, limits }
    }

    /// Its segments, ascending.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The reference conductivity, W/(m K).
    pub fn reference(&self) -> f64 {
        self.reference
    }

    /// Temperatures between which the conductivity is known to be positive, K.
    pub fn limits(&self) -> [f64; 2] {
        self.limits
    }

    /// Enthalpies between which it melts, K.
    pub fn melting(&self) -> Option<[f64; 2]> {
        self.melting
    }

    /// Whether the conductivity changes only by melting.
    pub fn is_constant_in_phases(&self) -> bool {
        let melts = self.melting.map_or(f64::INFINITY, |[begins, _]| begins);
        let solid = self.segments.iter().filter(|segment| segment.start < melts);
        let is_reference = |segment: &Segment| segment.slope == 1.0 && segment.bend == 0.0;
        solid.clone().all(is_reference)
            && self.melt.as_ref().is_none_or(|melt| melt.conductivity.is_constant())
    }

    /// Whether enthalpy, temperature and potential are one.
    pub(crate) fn is_straight(&self) -> bool {
        let is_one = |segment: &Segment| {
            let Segment { start, temperature, warming, potential, slope, bend } = *segment;
            [temperature, potential] == [start; 2] && [warming, slope, bend] == [1.0, 1.0, 0.0]
        };
        self.segments.len() == 1 && is_one(&self.segments[0])
    }

    /// What is solid, what melts and what is liquid, each of one segment: if it melts and the conductivity is constant in
    /// each phase.
    pub(crate) fn phases(&self) -> Option<[&Segment; 3]> {
        let [solid, melting, liquid] = &self.segments[..] else {
            return None;
        };
        let is_straight = [solid, liquid].iter().all(|phase| phase.bend == 0.0);
        let melts = self.melting.is_some() && melting.start < liquid.start;
        (melts && is_straight).then_some([solid, melting, liquid])
    }

    /// How it melts, and what it is then.
    pub fn melt(&self) -> Option<&Melting> {
        self.melt.as_ref()
    }

    /// Which segment an enthalpy (K) is of.
    #[inline]
    pub(crate) fn which(&self, enthalpy: f64) -> usize {
        let next = self.segments.partition_point(|segment| segment.start <= enthalpy);
        next.saturating_sub(1)
    }

    fn segment(&self, enthalpy: f64) -> &Segment {
        &self.segments[self.which(enthalpy)]
    }

    /// T at an enthalpy (K), K.
    pub fn temperature(&self, enthalpy: f64) -> f64 {
        self.segment(enthalpy).temperature_at(enthalpy)
    }

    /// psi at an enthalpy (K), K.
    pub fn potential(&self, enthalpy: f64) -> f64 {
        self.segment(enthalpy).potential_at::<false>(enthalpy)
    }

    /// T (K), psi (K) and k (W/(m K)) at an enthalpy (K).
    pub fn state(&self, enthalpy: f64) -> [f64; 3] {
        let segment = self.segment(enthalpy);
        let conductivity = self.conductivity_in(segment, enthalpy);
        [segment.temperature_at(enthalpy), segment.potential_at::<false>(enthalpy), conductivity]
    }

    /// d psi / d theta at an enthalpy (K).
    pub fn slope(&self, enthalpy: f64) -> f64 {
        self.segment(enthalpy).slope_at(enthalpy)
    }

    /// The largest d psi / d theta: what explicit steps have to be shorter by.
    pub fn largest_slope(&self) -> f64 {
        let ends = self.segments.iter().skip(1).map(|segment| segment.start);
        let just_below = |end: f64| self.slope(end.next_down());
        let starts = self.segments.iter().map(|segment| segment.slope);
        ends.map(just_below).chain(starts).fold(0.0, f64::max)
    }

    /// The largest dT / d theta.
    pub fn largest_warming(&self) -> f64 {
        self.segments.iter().map(|segment| segment.warming).fold(0.0, f64::max)
    }

    /// The largest conductivity over the reference.
    pub fn largest_conductivity_ratio(&self) -> f64 {
        let ends = self.segments.iter().skip(1).map(|segment| segment.start.next_down());
        let starts = self.segments.iter().map(|segment| segment.start);
        let ratio = |enthalpy: f64| self.conductivity(enthalpy) / self.reference;
        starts.chain(ends).map(ratio).fold(0.0, f64::max)
    }

    /// k at an enthalpy (K), W/(m K).
    pub fn conductivity(&self, enthalpy: f64) -> f64 {
        self.conductivity_in(self.segment(enthalpy), enthalpy)
    }

    fn conductivity_in(&self, segment: &Segment, enthalpy: f64) -> f64 {
        match segment.warming {
            // Where all heat is latent psi is flat: k goes from one side to the other with the liquid.
            0.0 => {
                let [begins, ends] = self.melting.unwrap_or([segment.start, segment.start]);
                let sides = [begins.next_down(), ends].map(|side| self.conductivity(side));
                sides[0] + (sides[1] - sides[0]) * self.liquid_fraction(enthalpy)
            }
            warming => self.reference * segment.slope_at(enthalpy) / warming,
        }
    }

    /// Conductivity where a segment begins, W/(m K), and how it rises with enthalpy, W/(m K2).
    pub fn conductivity_of(&self, segment: &Segment) -> [f64; 2] {
        if segment.warming > 0.0 {
            let over = self.reference / segment.warming;
            return [segment.slope * over, 2.0 * segment.bend * over];
        }
        let [begins, ends] = self.melting.unwrap_or([segment.start, segment.start]);
        let [solid, liquid] = [begins.next_down(), ends].map(|side| self.conductivity(side));
        [solid, (liquid - solid) / (ends - begins)]
    }

    /// How much of it is liquid at an enthalpy (K), 0 to 1.
    pub fn liquid_fraction(&self, enthalpy: f64) -> f64 {
        let of_range = |[begins, ends]: [f64; 2]| {
            // Where rounding leaves no width, what is above is liquid.
            let above = enthalpy - begins;
            if ends > begins {
                (above / (ends - begins)).clamp(0.0, 1.0)
            } else {
                f64::from(above > 0.0)
            }
        };
        self.melting.map_or(0.0, of_range)
    }

    /// The enthalpy at a temperature (K), K: at a sharp melting point that of the solid.
    pub fn enthalpy(&self, temperature: f64) -> f64 {
        let next = self.segments.partition_point(|segment| segment.temperature < temperature);
        let segment = &self.segments[next.saturating_sub(1)];
        match segment.warming {
            0.0 => segment.start,
            warming => segment.start + (temperature - segment.temperature) / warming,
        }
    }

    /// The enthalpy at a potential (K), K: where it melts sharply that of the solid, and beyond what is known
    /// of the conductivity as if it went on.
    pub fn enthalpy_of_potential(&self, potential: f64) -> f64 {
        // Unknown are at most the first and the last.
        let unknown = usize::from(self.segments[0].potential.is_nan());
        let known = &self.segments[unknown..];
        let next = known.partition_point(|segment| segment.potential < potential);
        let segment = &known[next.saturating_sub(1)];
        let rise = potential - segment.potential;
        // The root of (slope + bend x) x = rise that goes to 0 with the rise, without cancellation.
        let root = (segment.slope.powi(2) + 4.0 * segment.bend * rise).max(0.0).sqrt();
        match segment.slope + root {
            0.0 => segment.start,
            sum => segment.start + 2.0 * rise / sum,
        }
    }

    /// The potential at a temperature (K), K.
    pub fn potential_at(&self, temperature: f64) -> f64 {
        self.potential(self.enthalpy(temperature))
    }
}

/// Puts segments one after the other.
struct Builder {
    segments: Vec<Segment>,
    enthalpy: f64,
    potential: f64,
    reference: f64,
}

impl Builder {
    /// A segment from temperature `from` to `to` (K) with conductivities `k` to `l` that takes `span` of
    /// enthalpy (K).
    fn heat(&mut self, from: f64, to: f64, k: f64, l: f64, span: f64) {
        let warming = (to - from) / span;
        let (slope, bend) = (k * warming, 0.5 * (l - k) * warming / span);
        self.push(from, warming, slope / self.reference, bend / self.reference);
        self.enthalpy += span;
        self.potential += span * (slope + bend * span) / self.reference;
    }

    /// The last segment, from temperature `from` (K) on.
    fn go_on(&mut self, from: f64, k: f64, warming: f64) {
        self.push(from, warming, k * warming / self.reference, 0.0);
    }

    fn push(&mut self, temperature: f64, warming: f64, slope: f64, bend: f64) {
        let (start, potential) = (self.enthalpy, self.potential);
        self.segments.push(Segment { start, temperature, warming, potential, slope, bend });
    }
}

#[cfg(test)]
#[path = "curve_tests.rs"]
mod tests;
