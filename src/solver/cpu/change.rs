//! How potentials change with enthalpies.

use crate::model::HeatCurve;
use crate::model::material::Segment;
use crate::model::wide::{Work, any_signs, choose, multiply_add};

/// Values that are worked on together: of one segment of their curve as a rule.
const FEW: usize = 16;
/// The same once they are of several: fewer together are of fewer segments.
const FEWER: usize = 8;

const _: () = assert!(FEW.is_multiple_of(FEWER) && FEWER.is_power_of_two());

/// Adds `dt` times what is in `out` to each enthalpy, and writes its potential there.
pub(super) struct Change<'a, F> {
    /// None where the potential is the enthalpy.
    pub(super) curve: Option<&'a HeatCurve>,
    pub(super) enthalpies: &'a mut [f64],
    pub(super) out: &'a mut [f64],
    pub(super) dt: f64,
    /// Called with the parts where any may melt at one temperature after it: where they begin, and their enthalpies.
    pub(super) may_melt: F,
}

impl<F: FnMut(usize, &[f64])> Work for Change<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { curve, enthalpies, out, dt, mut may_melt } = self;
        let Some(curve) = curve else {
            for (out, enthalpy) in out.iter_mut().zip(enthalpies) {
                *enthalpy = multiply_add::<FUSED>(dt, *out, *enthalpy);
                *out = *enthalpy;
            }
            return;
        };
        let segments = curve.segments();
        let flat = segments.iter().position(|segment| segment.warming == 0.0);
        let first = enthalpies.first().map_or(0.0, |first| *first);
        let mut here = Here { segments, which: curve.which(first), flat };
        let count = enthalpies.len();
        if count < FEW {
            // What fills up does not change.
            let (mut few, mut changes) = ([first; FEW], [0.0; FEW]);
            few[..count].copy_from_slice(enthalpies);
            changes[..count].copy_from_slice(out);
            let melting = here.few::<FUSED>(&mut few, &mut changes, dt);
            enthalpies.copy_from_slice(&few[..count]);
            out.copy_from_slice(&changes[..count]);
            if melting.contains(&true) {
                may_melt(0, enthalpies);
            }
            return;
        }
        let mut done = 0;
        while done < count {
            let start = done.min(count - FEW);
            if start < done {
                // The last few: those among them that have changed do not change again.
                out[start..done].fill(0.0);
            }
            let few = (&mut enthalpies[start..start + FEW]).try_into().expect("so many");
            let changes = (&mut out[start..start + FEW]).try_into().expect("so many");
            let melting = here.few::<FUSED>(few, changes, dt);
            for (begins, melts) in (start..).step_by(FEWER).zip(melting) {
                let (from, end) = (begins.max(done), begins + FEWER);
                if melts && from < end {
                    may_melt(from, &enthalpies[from..end]);
                }
            }
            done = start + FEW;
        }
    }
}

/// A place on a curve: the segment of the enthalpy looked at last, which is that of the next as a rule.
struct Here<'a> {
    segments: &'a [Segment],
    which: usize,
    /// The segment where it melts at one temperature, if it does.
    flat: Option<usize>,
}

impl Here<'_> {
    /// Changes a few enthalpies; tells of each part of them whether any may melt at one temperature after it.
    #[inline(always)]
    fn few<const FUSED: bool>(
        &mut self,
        enthalpies: &mut [f64; FEW],
        out: &mut [f64; FEW],
        dt: f64,
    ) -> [bool; FEW / FEWER] {
        let (segments, which) = (self.segments, self.which);
        let ([start, end], segment) = (ends_of(segments, which), segments[which]);
        let (mut after, mut potentials, mut within) = ([0.0; FEW], [0.0; FEW], u64::MAX);
        for x in 0..FEW {
            after[x] = multiply_add::<FUSED>(dt, out[x], enthalpies[x]);
            potentials[x] = segment.potential_at::<FUSED>(after[x]);
            within &= is_within([start, end], after[x]);
        }
        *enthalpies = after;
        *out = potentials;
        let mut melting = [self.flat == Some(which); FEW / FEWER];
        if within >> 63 == 0 {
            let (fewer, _) = enthalpies.as_chunks();
            let (out, _) = out.as_chunks_mut();
            for ((fewer, out), melting) in fewer.iter().zip(out).zip(&mut melting) {
                let outside = fewer.map(|enthalpy| !is_within([start, end], enthalpy));
                if any_signs(outside) {
                    *melting = self.fewer::<FUSED>(fewer, out);
                } else {
                    self.which = which;
                }
            }
        }
        melting
    }

    /// Writes the potentials of fewer enthalpies: for each segment that they are of with all of them at once.
    /// Returns whether any may melt at one temperature.
    #[inline(always)]
    fn fewer<const FUSED: bool>(
        &mut self,
        enthalpies: &[f64; FEWER],
        out: &mut [f64; FEWER],
    ) -> bool {
        let [least, most] = extremes(enthalpies);
        let mut which = self.which;
        while which > 0 && least < self.segments[which].start {
            which -= 1;
        }
        for x in 0..FEWER {
            out[x] = self.segments[which].potential_at::<FUSED>(enthalpies[x]);
        }
        self.which = which;
        let (first, last) = (which, enthalpies[FEWER - 1]);
        while let Some(next) = self.segments.get(which + 1).filter(|next| next.start <= most) {
            for x in 0..FEWER {
                let potential = next.potential_at::<FUSED>(enthalpies[x]);
                out[x] = choose(next.start <= enthalpies[x], potential, out[x]);
            }
            which += 1;
            if next.start <= last {
                self.which = which;
            }
        }
        match self.flat {
            Some(flat) if (first..=which).contains(&flat) => {
                any_is_within(ends_of(self.segments, flat), enthalpies)
            }
            _ => false,
        }
    }
}

/// Enthalpies between which all are of one of the segments, the first of them too.
#[inline(always)]
fn ends_of(segments: &[Segment], which: usize) -> [f64; 2] {
    let start = if which == 0 { f64::NEG_INFINITY } else { segments[which].start };
    [start, segments.get(which + 1).map_or(f64::INFINITY, |next| next.start)]
}

/// Whether any of a few numbers is not below a start and below an end: by bits of signs, since a processor puts them
/// together for several at once.
#[inline(always)]
fn any_is_within([start, end]: [f64; 2], numbers: &[f64; FEWER]) -> bool {
    any_signs(numbers.map(|number| is_within([start, end], number)))
}

/// As the bit of a sign: whether a number is not below a start and below an end.
#[inline(always)]
fn is_within([start, end]: [f64; 2], number: f64) -> u64 {
    !(number - start).to_bits() & (number - end).to_bits()
}

/// The least and the greatest of some numbers. Beside one that is none they may be any of the others: potentials of a step in
/// which an enthalpy is no number are not used.
#[inline(always)]
fn extremes(numbers: &[f64; FEWER]) -> [f64; 2] {
    let (mut least, mut most) = (*numbers, *numbers);
    let mut count = FEWER;
    while count > 1 {
        count /= 2;
        for x in 0..count {
            least[x] = if least[x + count] < least[x] { least[x + count] } else { least[x] };
            most[x] = if most[x + count] > most[x] { most[x + count] } else { most[x] };
        }
    }
    [least[0], most[0]]
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
                // In order, and from one end to the other and back among a few.
                for step in [1, 1009] {
                    let at = |k: u32| 200.0 + 0.17 * f64::from(k * step % 5003);
                    let mut enthalpies: Vec<f64> = (0..5003).map(at).collect();
                    let mut out = vec![2.0; enthalpies.len()];
                    let mut parts = Vec::new();
                    wide::run(Change {
                        curve: Some(&curve),
                        enthalpies: &mut enthalpies,
                        out: &mut out,
                        dt: 0.5,
                        may_melt: |first: usize, few: &[f64]| parts.push(first..first + few.len()),
                    });
                    assert_eq!(enthalpies[10], at(10) + 1.0);
                    let off = |shift: usize| {
                        let pairs = out.iter().zip(&enthalpies[shift..]);
                        pairs
                            .map(|(out, &at)| (out - curve.potential(at)).abs())
                            .fold(0.0, f64::max)
                    };
                    assert!(off(0) < 1e-10, "{:e}", off(0));
                    assert!(off(1) > 0.1, "a shift is noticed");
                    let melts = |enthalpy: f64| curve.slope(enthalpy) == 0.0;
                    for (k, &enthalpy) in enthalpies.iter().enumerate().filter(|(_, h)| melts(**h))
                    {
                        assert!(parts.iter().any(|part| part.contains(&k)), "{k}: {enthalpy}");
                    }
                    let many: usize = parts.iter().map(|part| part.len()).sum();
                    let few = enthalpies.iter().filter(|h| melts(**h)).count();
                    assert!(step > 1 || many <= few + 2 * FEWER, "{many} are looked at for {few}");
                    assert!(parts.windows(2).all(|two| two[0].end <= two[1].start));
                }
            }
        }
    }
}
