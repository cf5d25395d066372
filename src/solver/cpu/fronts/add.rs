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
        line: &Line<'_>,
        gain: &mut [f64; LANES],
        out: &mut [f64; LANES],
    ) {
        for x in 0..LANES {
            self.add::<FUSED>(line.potentials[x], line.weights[x], &mut gain[x], &mut out[x]);
        }
    }

    /// The same of all lines, where potentials are in `around` from the first to the last of them; returns what flows to the
    /// particle, to the last bit the same for `near` as for any part of what is near.
    #[inline(always)]
    fn add_lines<const FUSED: bool>(
        self,
        lines: &Lines,
        around: &[f64],
        mut near: impl NearLines,
    ) -> [f64; LANES] {
        // Added to three sums in turn, since each addition waits for the one before.
        let [mut first, mut second, mut third] = [[0.0; LANES]; 3];
        for (&ahead, weights) in lines.all() {
            let potentials = around[ahead..].first_chunk().expect("a line's length");
            near.add::<FUSED>(self, &Line { ahead, potentials, weights }, &mut first);
            [first, second, third] = [second, third, first];
        }
        for x in 0..LANES {
            first[x] += second[x] + third[x];
        }
        first
    }
}

/// A line of neighbours.
struct Line<'a> {
    /// How far it begins from the first.
    ahead: usize,
    /// K
    potentials: &'a [f64; LANES],
    /// 1/s
    weights: &'a [f64; LANES],
}

/// What is written near a particle.
trait NearLines {
    /// Takes what flows from a line from what is written of it, and adds it to `gain`.
    fn add<const FUSED: bool>(&mut self, flow: Flow, line: &Line<'_>, gain: &mut [f64; LANES]);
}

/// From the first to the last of all lines.
struct Whole<'a>(&'a mut [f64]);

impl NearLines for Whole<'_> {
    #[inline(always)]
    fn add<const FUSED: bool>(&mut self, flow: Flow, line: &Line<'_>, gain: &mut [f64; LANES]) {
        let out = self.0[line.ahead..].first_chunk_mut().expect("a line's length");
        flow.add_line::<FUSED>(line, gain, out);
    }
}

/// Lines as far as they are in `out`, where the first begins at `first`: what flows from beyond counts only if the particle
/// `is_own`.
struct Cut<'a> {
    out: &'a mut [f64],
    first: usize,
    is_own: bool,
}

impl NearLines for Cut<'_> {
    #[inline(always)]
    fn add<const FUSED: bool>(&mut self, flow: Flow, line: &Line<'_>, gain: &mut [f64; LANES]) {
        let (count, out) = (self.out.len(), &mut *self.out);
        // What begins before the first has wrapped around.
        let to = self.first.wrapping_add(line.ahead);
        if let Some(out) = out.get_mut(to..).and_then(<[f64]>::first_chunk_mut) {
            flow.add_line::<FUSED>(line, gain, out);
        } else if (0..LANES).all(|x| to.wrapping_add(x) >= count) {
            if self.is_own {
                flow.add_line::<FUSED>(line, gain, &mut [0.0; LANES]);
            }
        } else {
            let mut written = [0.0; LANES];
            for (x, written) in written.iter_mut().enumerate() {
                *written = out.get(to.wrapping_add(x)).copied().unwrap_or(0.0);
            }
            flow.add_line::<FUSED>(line, gain, &mut written);
            for (x, written) in written.iter().enumerate() {
                if let Some(out) = out.get_mut(to.wrapping_add(x)) {
                    *out = *written;
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
            // All before any is needed: what waits for a quotient would have the next particle wait.
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
                        let first = start.wrapping_sub(own.start);
                        let span = lines.span();
                        match potentials.get(start..start + span) {
                            Some(around) if are_alike => {
                                let flow = flow.times(factor);
                                let whole = out.get_mut(first..first.wrapping_add(span));
                                *gain = match whole {
                                    Some(near) => {
                                        // One length for both, so that each line is looked for once.
                                        let near = Whole(&mut near[..around.len()]);
                                        flow.add_lines::<FUSED>(lines, around, near)
                                    }
                                    None => {
                                        let is_own = own.contains(&place);
                                        let near = Cut { out: &mut *out, first, is_own };
                                        flow.add_lines::<FUSED>(lines, around, near)
                                    }
                                };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_give_and_take_the_same_wherever_they_are_cut() {
        let steps = [-31, -30, -29, -20, -11, -9, -1, 1, 2, 9, 11, 20, 30, 31];
        for steps in [&steps[..], &steps[3..], &steps[..4], &steps[6..9]] {
            let weight = |step: isize| 1.0 / (3.5 + step as f64).abs();
            let entries: Vec<_> = steps.iter().map(|&step| (step, weight(step))).collect();
            let (lines, place, count) = (Lines::of(&entries), 40, 80);
            let (start, span) = (lines.start(place), lines.span());
            let flow =
                Flow { potential: 0.3, excess: [0.5, -0.2], taken: [0.25, -0.3], factor: 1.0 };
            let potentials: Vec<f64> = (0..count).map(|k| (k * 37 % 11) as f64 / 11.0).collect();
            let around = &potentials[start..start + span];
            let mut whole = vec![1.0; count];
            let near = Whole(&mut whole[start..start + span]);
            let gain = flow.add_lines::<true>(&lines, around, near);
            let (mut expected, mut gained) = (vec![1.0; count], 0.0);
            lines.for_each(place, |other, weight| {
                flow.add::<true>(potentials[other], weight, &mut gained, &mut expected[other]);
            });
            assert_eq!(whole, expected);
            assert!((sum_of(gain) - gained).abs() < 1e-15, "{gain:?} {gained}");
            for (cut, end) in (0..=count).flat_map(|end| (0..=end).map(move |cut| (cut, end))) {
                let mut parts = vec![1.0; count];
                let (before, behind) = parts.split_at_mut(cut);
                let (some, rest) = behind.split_at_mut(end - cut);
                for (part, out) in [(0..cut, before), (cut..end, some), (end..count, rest)] {
                    let (first, is_own) = (start.wrapping_sub(part.start), part.contains(&place));
                    let found = flow.add_lines::<true>(&lines, around, Cut { out, first, is_own });
                    assert!(found == gain || !is_own, "{part:?}");
                }
                assert_eq!(parts, whole, "cut at {cut} and {end}");
            }
        }
    }
}
