//! How potentials change with enthalpies.

use crate::model::HeatCurve;
use crate::model::material::Segment;
use crate::model::wide::{Work, choose, multiply_add};

/// Values that are worked on together: of one segment of their curve as a rule.
const FEW: usize = 16;

/// Adds `dt` times what is in `out` to each enthalpy, and writes its potential there.
pub(super) struct Change<'a> {
    /// None where the potential is the enthalpy.
    pub(super) curve: Option<&'a HeatCurve>,
    pub(super) enthalpies: &'a mut [f64],
    pub(super) out: &'a mut [f64],
    pub(super) dt: f64,
}

impl Work for Change<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { curve, enthalpies, out, dt } = self;
        let Some(curve) = curve else {
            for (out, enthalpy) in out.iter_mut().zip(enthalpies) {
                *enthalpy = multiply_add::<FUSED>(dt, *out, *enthalpy);
                *out = *enthalpy;
            }
            return;
        };
        let first = enthalpies.first().map_or(0.0, |first| *first);
        let mut here = Here { segments: curve.segments(), which: curve.which(first) };
        let (mut parts, mut rates) = (enthalpies.chunks_exact_mut(FEW), out.chunks_exact_mut(FEW));
        for (few, out) in parts.by_ref().zip(rates.by_ref()) {
            let few = few.try_into().expect("so many");
            here.few::<FUSED>(few, out.try_into().expect("so many"), dt);
        }
        let (few, out) = (parts.into_remainder(), rates.into_remainder());
        let Some(&last) = few.last() else {
            return;
        };
        // What fills the rest up does not change.
        let (mut these, mut changes) = ([last; FEW], [0.0; FEW]);
        these[..few.len()].copy_from_slice(few);
        changes[..out.len()].copy_from_slice(out);
        here.few::<FUSED>(&mut these, &mut changes, dt);
        few.copy_from_slice(&these[..few.len()]);
        out.copy_from_slice(&changes[..out.len()]);
    }
}

/// A place on a curve: the segment of the enthalpy looked at last, which is that of the next as a rule.
struct Here<'a> {
    segments: &'a [Segment],
    which: usize,
}

impl Here<'_> {
    /// Enthalpies between which all are of the segment, the first of them too.
    #[inline(always)]
    fn ends(&self) -> [f64; 2] {
        let Self { segments, which } = *self;
        let start = if which == 0 { f64::NEG_INFINITY } else { segments[which].start };
        [start, segments.get(which + 1).map_or(f64::INFINITY, |next| next.start)]
    }

    /// Changes a few enthalpies.
    #[inline(always)]
    fn few<const FUSED: bool>(
        &mut self,
        enthalpies: &mut [f64; FEW],
        out: &mut [f64; FEW],
        dt: f64,
    ) {
        let ([start, end], segment) = (self.ends(), self.segments[self.which]);
        let (mut after, mut potentials, mut within) = ([0.0; FEW], [0.0; FEW], u64::MAX);
        for x in 0..FEW {
            after[x] = multiply_add::<FUSED>(dt, out[x], enthalpies[x]);
            potentials[x] = segment.potential_at::<FUSED>(after[x]);
            // Bits of signs, since a processor puts them together for several at once.
            within &= !(after[x] - start).to_bits() & (after[x] - end).to_bits();
        }
        *enthalpies = after;
        *out = potentials;
        if within >> 63 == 0 {
            self.few_of_several::<FUSED>(&after, out);
        }
    }

    /// Writes the potentials of a few enthalpies: for each segment that they are of with all of them at once.
    #[inline(always)]
    fn few_of_several<const FUSED: bool>(&mut self, enthalpies: &[f64; FEW], out: &mut [f64; FEW]) {
        let mut which = self.which;
        while which > 0 && any_is_below(self.segments[which].start, enthalpies) {
            which -= 1;
        }
        for x in 0..FEW {
            out[x] = self.segments[which].potential_at::<FUSED>(enthalpies[x]);
        }
        self.which = which;
        let last = enthalpies[FEW - 1];
        while let Some(next) =
            self.segments.get(which + 1).filter(|next| any_is_at_least(next.start, enthalpies))
        {
            for x in 0..FEW {
                let potential = next.potential_at::<FUSED>(enthalpies[x]);
                out[x] = choose(next.start <= enthalpies[x], potential, out[x]);
            }
            which += 1;
            if next.start <= last {
                self.which = which;
            }
        }
    }
}

/// Whether any of a few numbers is below an end: by bits of signs, since a processor puts them together for several
/// at once.
#[inline(always)]
fn any_is_below(end: f64, numbers: &[f64; FEW]) -> bool {
    let mut any = 0;
    for number in numbers {
        any |= (number - end).to_bits();
    }
    any >> 63 != 0
}

/// Whether any of a few numbers is not below a start.
#[inline(always)]
fn any_is_at_least(start: f64, numbers: &[f64; FEW]) -> bool {
    let mut all = u64::MAX;
    for number in numbers {
        all &= (number - start).to_bits();
    }
    all >> 63 == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::wide;
    use crate::model::{Conductivity, Melting};

    #[test]
    fn potentials_are_those_of_the_changed_enthalpies() {
        let points = |count: u32| {
            (0..count).map(|k| [300.0 + 10.0 * f64::from(k), 300.0 + f64::from(k * k)])
        };
        let melting = |liquidus: f64| Melting {
            solidus: 400.0,
            liquidus,
            latent: 5e8,
            conductivity: Conductivity::constant(200.0),
            capacity: 3e6,
        };
        for count in [1, 2, 9] {
            let solid = Conductivity::of_points(points(count).collect());
            for melting in [None, Some(melting(400.0)), Some(melting(420.0))] {
                let curve = HeatCurve::new(&solid, 2.5e6, melting.as_ref());
                let mut enthalpies: Vec<f64> =
                    (0..5003).map(|k| 200.0 + 0.17 * f64::from(k)).collect();
                let mut out = vec![2.0; enthalpies.len()];
                wide::run(Change {
                    curve: Some(&curve),
                    enthalpies: &mut enthalpies,
                    out: &mut out,
                    dt: 0.5,
                });
                assert_eq!(enthalpies[10], 200.0 + 1.7 + 1.0);
                let off = |shift: usize| {
                    let pairs = out.iter().zip(&enthalpies[shift..]);
                    pairs.map(|(out, &at)| (out - curve.potential(at)).abs()).fold(0.0, f64::max)
                };
                assert!(off(0) < 1e-10, "{:e}", off(0));
                assert!(off(1) > 0.1, "a shift is noticed");
            }
        }
    }
}
