//! The flows of melting particles, in loops that a processor runs on several values at once.

use std::ops::Range;

use super::FrontFlows;
use crate::model::wide::{Work, choose, multiply_add, sum_of};
use crate::solver::cpu::entries::{Entries, LANES, Lines, Near};
use crate::solver::cpu::latent::{CurveAndLines, Latent};
use crate::solver::cpu::operator::CpuOperator;
use crate::solver::cpu::written::Written;

/// Particles that are worked on together.
const FEW: usize = 16;

/// Adds what flows to and from some latent particles beside what the operator has of it. Held particles do not melt:
/// at the melting point they are solid.
pub(in crate::solver::cpu) struct Add<'a, O: ?Sized> {
    pub(in crate::solver::cpu) of: &'a FrontFlows,
    pub(in crate::solver::cpu) latent: &'a Latent,
    pub(in crate::solver::cpu) which: Range<usize>,
    pub(in crate::solver::cpu) operator: &'a O,
    pub(in crate::solver::cpu) potentials: &'a [f64],
    /// What is made of rates.
    pub(in crate::solver::cpu) written: Written<'a>,
    /// The places where that is here.
    pub(in crate::solver::cpu) own: Range<usize>,
    pub(in crate::solver::cpu) out: &'a mut [f64],
}

/// What flows to a melting particle beside what the operator has of it, and what is made of that.
#[derive(Clone, Copy, Default)]
struct Flow {
    /// Of the particle, K.
    potential: f64,
    /// From a solid neighbour, and from a liquid one: how many times weight and difference it is.
    excess: [f64; 2],
    /// The same of what is taken from what is written of the neighbour.
    taken: [f64; 2],
    /// What is written of the particle is made of rates by this.
    factor: f64,
}

impl Flow {
    /// That of a particle with a curve and an enthalpy (K): nothing if it does not melt.
    #[inline(always)]
    fn of(fronts: &FrontFlows, written: Written<'_>, curve: u16, enthalpy: f64) -> Self {
        match fronts.front_of(curve) {
            Some(front) if front.is_in(enthalpy) => {
                let [from_liquid, from_solid] = fronts.fronts.excess(front, enthalpy);
                let [solid, liquid] = written.of(usize::from(curve)).factors;
                Self {
                    potential: front.potential,
                    excess: [from_solid, from_liquid],
                    taken: [from_solid * solid, from_liquid * liquid],
                    // What melts is not above where it does.
                    factor: solid,
                }
            }
            _ => Self::default(),
        }
    }

    #[inline(always)]
    fn is_none(self) -> bool {
        self.excess == [0.0; 2]
    }

    /// That where all weights are to be multiplied by a factor.
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        match factor == 1.0 {
            // As a rule: compilers would multiply the flow of every neighbour.
            true => self,
            false => {
                let [excess, taken] = [self.excess, self.taken].map(|of| of.map(|x| factor * x));
                Self { excess, taken, ..self }
            }
        }
    }

    /// Adds what flows from a neighbour of some potential and weight to `gain`, and takes it from what is written of the
    /// neighbour. What melts too has the same potential, and gives nothing.
    #[inline(always)]
    fn add<const FUSED: bool>(self, other: f64, weight: f64, gain: &mut f64, out: &mut f64) {
        let above = other - self.potential;
        let of_phase = |[solid, liquid]: [f64; 2]| choose(above.is_sign_negative(), solid, liquid);
        let flow = weight * above;
        *gain = multiply_add::<FUSED>(flow, of_phase(self.excess), *gain);
        *out = multiply_add::<FUSED>(-flow, of_phase(self.taken), *out);
    }

    /// The same of a line.
    #[inline(always)]
    fn add_line<const FUSED: bool>(
        self,
        others: &[f64; LANES],
        weights: &[f64; LANES],
        gain: &mut [f64; LANES],
        out: &mut [f64; LANES],
    ) {
        for x in 0..LANES {
            self.add::<FUSED>(others[x], weights[x], &mut gain[x], &mut out[x]);
        }
    }

    /// The same of lines of which some or nothing is in `out`, where the first of all begins at `first`.
    #[inline(always)]
    fn add_cut<'a, const FUSED: bool>(
        self,
        lines: impl Iterator<Item = (&'a usize, &'a [f64; LANES])>,
        around: &[f64],
        gain: &mut [f64; LANES],
        first: usize,
        out: &mut [f64],
    ) {
        for (&ahead, weights) in lines {
            let others = around[ahead..].first_chunk().expect("a line's length");
            let (to, mut line) = (first.wrapping_add(ahead), [0.0; LANES]);
            for (x, line) in line.iter_mut().enumerate() {
                *line = out.get(to.wrapping_add(x)).copied().unwrap_or(0.0);
            }
            self.add_line::<FUSED>(others, weights, gain, &mut line);
            for (x, line) in line.iter().enumerate() {
                if let Some(out) = out.get_mut(to.wrapping_add(x)) {
                    *out = *line;
                }
            }
        }
    }
}

impl<O: CpuOperator + ?Sized> Work for Add<'_, O> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { of, latent, which, operator, potentials, written, own, out } = self;
        let (places, enthalpies) =
            (&latent.places()[which.clone()], &latent.enthalpies()[which.clone()]);
        let mut near = Near::default();
        let firsts = which.step_by(FEW);
        for ((places, enthalpies), first) in
            places.chunks(FEW).zip(enthalpies.chunks(FEW)).zip(firsts)
        {
            let mut kinds = [CurveAndLines::default(); FEW];
            for (which, kind) in (first..).zip(&mut kinds[..places.len()]) {
                *kind = latent.kind(which).unwrap_or_default();
            }
            // All before any is needed, since a processor divides several at once.
            let mut flows = [Flow::default(); FEW];
            for ((flow, &enthalpy), kind) in flows.iter_mut().zip(enthalpies).zip(&kinds) {
                *flow = Flow::of(of, written, kind.curve, enthalpy);
            }
            let mut gains = [[0.0; LANES]; FEW];
            let particles = places.iter().zip(&kinds).zip(&flows);
            for (((&place, kind), flow), gain) in particles.zip(&mut gains) {
                if flow.is_none() {
                    continue;
                }
                let place = place as usize;
                let mut add = |other: usize, weight: f64| {
                    let Some(ratio) = of.ratio(place, other) else {
                        return;
                    };
                    let mut given = 0.0;
                    flow.add::<FUSED>(potentials[other], weight, &mut gain[0], &mut given);
                    if let Some(out) = out.get_mut(other.wrapping_sub(own.start)) {
                        *out += given * ratio;
                    }
                };
                let (entries, are_alike) = of.entries(place, kind.lines, operator, &mut near);
                match entries {
                    Entries::Lines(lines, factor) => {
                        let start = lines.start(place);
                        match potentials.get(start..start + lines.span()) {
                            Some(around) if are_alike => {
                                let flow = flow.times(factor);
                                let first = start.wrapping_sub(own.start);
                                let is_own = own.contains(&place);
                                *gain = along::<FUSED>(lines, flow, around, first, is_own, out);
                            }
                            _ => lines.for_each(place, |other, weight| add(other, factor * weight)),
                        }
                    }
                    Entries::Row(others, weights) => {
                        let entries = others.iter().zip(weights);
                        entries.for_each(|(&other, &weight)| add(other as usize, weight));
                    }
                }
            }
            for ((&place, gain), flow) in places.iter().zip(&gains).zip(&flows) {
                if let Some(out) = out.get_mut((place as usize).wrapping_sub(own.start)) {
                    *out += flow.factor * sum_of(*gain);
                }
            }
        }
    }
}

/// Takes the flows from all of `lines`, whose potentials are in `around` from the first to the last, from what is in
/// `out` of these as far as they are there, where the first line begins at `first`; returns what flows to the particle,
/// if it `is_own`: there, what lies beyond counts too.
#[inline(always)]
fn along<const FUSED: bool>(
    lines: &Lines,
    flow: Flow,
    around: &[f64],
    first: usize,
    is_own: bool,
    out: &mut [f64],
) -> [f64; LANES] {
    let (mut gain, count) = ([0.0; LANES], out.len());
    let whole = lines.within(first, count);
    // What lies beyond counts for the particle's own sum alone; beside whole lines, only those next to them can be cut.
    let beyond = |all: Range<usize>, next: Range<usize>| {
        if is_own {
            return all;
        }
        let mut some = lines.some(next.clone());
        let is_cut = some.any(|(ahead, _)| !is_beyond(first.wrapping_add(*ahead), count));
        if is_cut { next } else { 0..0 }
    };
    let last_before = if whole.is_empty() { 0 } else { whole.start.saturating_sub(1) };
    let before = beyond(0..whole.start, last_before..whole.start);
    let behind = beyond(whole.end..lines.len(), whole.end..lines.len().min(whole.end + 1));
    flow.add_cut::<FUSED>(lines.some(before), around, &mut gain, first, out);
    for (&ahead, weights) in lines.some(whole) {
        let others = around[ahead..].first_chunk().expect("a line's length");
        let line = out[first.wrapping_add(ahead)..].first_chunk_mut().expect("a line's length");
        flow.add_line::<FUSED>(others, weights, &mut gain, line);
    }
    flow.add_cut::<FUSED>(lines.some(behind), around, &mut gain, first, out);
    gain
}

/// Whether a line that begins at `first` of so many places has nothing in common with them.
#[inline(always)]
fn is_beyond(first: usize, count: usize) -> bool {
    // What begins before the first has wrapped around.
    first >= count && first.wrapping_add(LANES - 1) >= count
}
