//! How potentials go on between solidus and liquidus.
//!
//! There the conductivity is straight in T, and T in the enthalpy, so that the potential at x above where melting begins
//! is psi_0 + s x + b x^2. Where it is psi its slope is g = sqrt(s^2 + 4 b (psi - psi_0)), and a change delta of the
//! enthalpy takes it to psi + delta (g + b delta): to what the curve has there, without a look at the enthalpy.

use super::crossings::{FEW, FEWER, Look, any_of, any_of_short, find};
use super::operator::Combine;
use crate::model::material::Segment;
use crate::model::wide::{choose, multiply_add};

/// The smallest slope d psi / d theta with which potentials are to tell enthalpies: they lose as many digits as it is
/// smaller than 1.
const LEAST_SLOPE: f64 = 0.01;

const _: () = assert!(FEW.is_multiple_of(FEWER), "groups fill what is taken on together");

/// What a material is between solidus and liquidus.
pub(super) struct Mushy {
    /// Potentials between which it is, K.
    ends: [f64; 2],
    segment: Segment,
    /// Of the material, W/(m K).
    reference: f64,
}

/// A step that takes its potentials on.
pub(super) struct MushyStep {
    ends: [f64; 2],
    /// s^2, 4 b and b.
    square: f64,
    rise: f64,
    bend: f64,
    /// s
    dt: f64,
}

impl Mushy {
    /// What melts as in `segment`, up to what is `liquid`; `None` where potentials would not tell its enthalpies.
    pub(super) fn of(segment: &Segment, liquid: &Segment, reference: f64) -> Option<Self> {
        let last = segment.slope + 2.0 * segment.bend * (liquid.start - segment.start);
        (segment.slope.min(last) >= LEAST_SLOPE).then_some(Self {
            // The signs of differences to them count, also to 0.
            ends: [segment, liquid].map(|end| end.potential + 0.0),
            segment: *segment,
            reference,
        })
    }

    /// A step of `dt` (s).
    pub(super) fn step(&self, dt: f64) -> MushyStep {
        let Self { ends, segment: Segment { slope, bend, .. }, .. } = *self;
        MushyStep { ends, square: slope * slope, rise: 4.0 * bend, bend, dt }
    }

    /// Whether what has a potential (K) is neither solid nor liquid.
    pub(super) fn has(&self, potential: f64) -> bool {
        self.ends[0] < potential && potential <= self.ends[1]
    }

    /// T (K) and k (W/(m K)) at a potential (K) of it.
    pub(super) fn state(&self, potential: f64) -> [f64; 2] {
        let Self { segment: Segment { temperature, warming, slope, .. }, reference, .. } = *self;
        let here = self.step(0.0).slope::<false>(potential);
        let above = 2.0 * (potential - self.ends[0]) / (slope + here);
        [temperature + warming * above, reference * here / warming]
    }
}

impl MushyStep {
    /// d psi / d theta at a potential of it.
    #[inline(always)]
    fn slope<const FUSED: bool>(&self, potential: f64) -> f64 {
        multiply_add::<FUSED>(self.rise, potential - self.ends[0], self.square).sqrt()
    }
}

/// The sign of what is above each end is that of a negative number.
#[inline(always)]
fn rooms([least, most]: [f64; 2], potential: f64) -> [u64; 2] {
    [(least - potential).to_bits(), (most - potential).to_bits()]
}

impl Look for &MushyStep {
    #[inline(always)]
    fn bits(self, now: f64, next: f64) -> u64 {
        // Not both solid, nor both liquid. What is no number stays so, found or not: `max` and `min` would have to look for it.
        let [least, most] = self.ends;
        let highest = if now > next { now } else { next };
        let lowest = if now < next { now } else { next };
        (least - highest).to_bits() & !(most - lowest).to_bits()
    }
}

impl MushyStep {
    /// Takes on what is mushy in a run from place `first` on, of which there is in `out` what it would be with the slopes of
    /// `phases`, whose limit is where the mushy ends; adds what passes to another phase to `found`.
    #[inline(always)]
    pub(super) fn take_on<const FUSED: bool>(
        &self,
        phases: Combine,
        now: &[f64],
        out: &mut [f64],
        found: &mut Vec<usize>,
        first: usize,
    ) {
        let per_change = self.dt / phases.factors[0];
        // Those that follow each other are taken on together.
        let (groups, rest) = now.as_chunks::<FEWER>();
        let mut some = 0..0;
        for (group, of_now) in groups.iter().enumerate() {
            let from = group * FEWER;
            let of_out = out[from..].first_chunk().expect("as many");
            if !any_of(self, of_now, of_out) {
                continue;
            }
            if some.end != from || some.len() == FEW {
                let (now, out) = (&now[some.clone()], &mut out[some.clone()]);
                self.take::<FUSED>(per_change, now, out, found, first + some.start);
                some = from..from;
            }
            some.end = from + FEWER;
        }
        let (now_of_some, out_of_some) = (&now[some.clone()], &mut out[some.clone()]);
        self.take::<FUSED>(per_change, now_of_some, out_of_some, found, first + some.start);
        let done = now.len() - rest.len();
        let rest_out = &mut out[done..];
        if any_of_short(self, rest, rest_out) {
            self.take::<FUSED>(per_change, rest, rest_out, found, first + done);
        }
    }

    /// The same of at most [`FEW`], where `per_change` of a change in `out` is that of the enthalpy.
    #[inline(always)]
    fn take<const FUSED: bool>(
        &self,
        per_change: f64,
        now: &[f64],
        out: &mut [f64],
        found: &mut Vec<usize>,
        first: usize,
    ) {
        debug_assert!(now.len() <= FEW, "all are taken");
        let (mut passes, mut any) = ([0; FEW], 0);
        for ((passes, &now), out) in passes.iter_mut().zip(now).zip(&mut *out) {
            let change = per_change * (*out - now);
            let slope = self.slope::<FUSED>(now);
            let rise = multiply_add::<FUSED>(self.bend, change, slope);
            let of_mushy = multiply_add::<FUSED>(change, rise, now);
            let [over, above] = rooms(self.ends, now);
            let is_mushy = over & !above;
            let after = choose(is_mushy >> 63 != 0, of_mushy, *out);
            let [next_over, next_above] = rooms(self.ends, after);
            // Past where the slope would be 0 the same potentials come again.
            let turns = is_mushy & (rise + self.bend * change).to_bits();
            *passes = (over ^ next_over) | (above ^ next_above) | turns;
            any |= *passes;
            *out = choose(*passes >> 63 != 0, *out, after);
        }
        if any >> 63 != 0 {
            find(passes.into_iter().take(now.len()), found, first);
        }
    }
}
