//! How potentials go on between solidus and liquidus.
//!
//! There the conductivity is straight in T, and T in the enthalpy, so that the potential at x above where melting begins
//! is psi_0 + s x + b x^2. Where it is psi its slope is g = sqrt(s^2 + 4 b (psi - psi_0)), and a change delta of the
//! enthalpy takes it to psi + delta (g + b delta): to what the curve has there, without a look at the enthalpy.

use super::crossings::{FEW, Look, find};
use super::operator::Combine;
use crate::model::material::Segment;
use crate::model::wide::{choose, multiply_add};

/// The smallest slope d psi / d theta with which potentials are to tell enthalpies: they lose as many digits as it is
/// smaller than 1.
const LEAST_SLOPE: f64 = 0.01;

/// What a material is between solidus and liquidus.
pub(super) struct Mushy {
    /// Potentials between which it is, K.
    ends: [f64; 2],
    segment: Segment,
    /// Of the material, W/(m K).
    reference: f64,
}

/// A step that takes its potentials on.
#[derive(Clone, Copy)]
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

/// With what takes on what is solid or liquid: above a limit, which is where the mushy ends.
impl Look for (Combine, MushyStep) {
    #[inline(always)]
    fn bits(self, now: f64, next: f64) -> u64 {
        let [[over, above], [next_over, next_above]] =
            [now, next].map(|potential| rooms(self.1.ends, potential));
        // Not both solid, nor both liquid: what is above the most is above the least.
        (over | next_over) & !(above & next_above)
    }

    /// Takes on what is mushy, of which there is in `out` what it would be with the slopes of other phases.
    #[inline(always)]
    fn take<const FUSED: bool>(
        self,
        now: &[f64],
        out: &mut [f64],
        found: &mut Vec<usize>,
        first: usize,
    ) {
        debug_assert!(now.len() <= FEW, "all are taken");
        let (phases, mushy) = self;
        let per_change = mushy.dt / phases.factors[0];
        let (mut passes, mut any) = ([0; FEW], 0);
        for ((passes, &now), out) in passes.iter_mut().zip(now).zip(&mut *out) {
            let change = per_change * (*out - now);
            let slope = mushy.slope::<FUSED>(now);
            let rise = multiply_add::<FUSED>(mushy.bend, change, slope);
            let of_mushy = multiply_add::<FUSED>(change, rise, now);
            let [over, above] = rooms(mushy.ends, now);
            let is_mushy = over & !above;
            let after = choose(is_mushy >> 63 != 0, of_mushy, *out);
            let [next_over, next_above] = rooms(mushy.ends, after);
            // Past where the slope would be 0 the same potentials come again.
            let turns = is_mushy & (rise + mushy.bend * change).to_bits();
            *passes = (over ^ next_over) | (above ^ next_above) | turns;
            any |= *passes;
            *out = choose(*passes >> 63 != 0, *out, after);
        }
        if any >> 63 != 0 {
            find(passes.into_iter().take(now.len()), found, first);
        }
    }
}
