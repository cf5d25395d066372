//! What passes to another phase in a step of potentials.

use std::ops::Range;

use super::course::CourseStep;
use super::operator::Combine;
use crate::model::wide::{Work, any_signs};

/// Values that are looked at together.
pub(super) const FEW: usize = 32;
/// The same in runs that are shorter, and of what melts over a range.
pub(super) const FEWER: usize = 8;

/// Finds what passes to another phase in a step, which it takes on where a phase has no single slope.
pub(super) struct Crossings<'a, R> {
    /// Places that follow each other, and what takes those of each run a step on.
    pub(super) runs: R,
    /// The potentials before it.
    pub(super) now: &'a [f64],
    /// Those after it: in between phases, and of what passes to another one, what they would be with the slope of
    /// [`CourseStep::phases`].
    pub(super) out: &'a mut [f64],
    /// Takes the places that do, where potentials are from place `first` on.
    pub(super) found: &'a mut Vec<usize>,
    pub(super) first: usize,
}

impl<'s, R: Iterator<Item = (Range<usize>, &'s CourseStep)>> Work for Crossings<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { runs, now, out, found, first } = self;
        for (run, &CourseStep { phases, ref mushy, .. }) in runs {
            let local = run.start - first..run.end - first;
            let (now, out) = (&now[local.clone()], &mut out[local]);
            match mushy {
                // What does not melt has one phase.
                None if phases.limit == f64::INFINITY => {}
                None => find_in(phases, now, out, found, run.start),
                Some(mushy) => mushy.take_on::<FUSED>(phases, now, out, found, run.start),
            }
        }
    }
}

/// How potentials are looked at.
pub(super) trait Look: Copy {
    /// As its highest bit, that of a sign, whether something may be to be done with a potential (K) that becomes another
    /// one.
    fn bits(self, now: f64, next: f64) -> u64;
}

/// Of what melts at one temperature or not at all.
impl Look for Combine {
    #[inline(always)]
    fn bits(self, now: f64, next: f64) -> u64 {
        self.room(now).to_bits() ^ self.room(next).to_bits()
    }
}

/// Finds what passes to another phase in a run from place `first` on.
#[inline(always)]
fn find_in(by: Combine, now: &[f64], out: &[f64], found: &mut Vec<usize>, first: usize) {
    if now.len() < FEW {
        if any_of_short(by, now, out) {
            find_by(by, now, out, found, first);
        }
        return;
    }
    let mut from = 0;
    while from < now.len() {
        let to = now.len().min(from + FEW);
        // A last chunk that is short is looked at with values before it.
        let chunks = now[..to].last_chunk::<FEW>().zip(out[..to].last_chunk());
        let (of_now, of_out) = chunks.expect("as many at least");
        if any_of(by, of_now, of_out) {
            find_by(by, &now[from..to], &out[from..to], found, first + from);
        }
        from = to;
    }
}

/// Whether there are any bits among some.
#[inline(always)]
pub(super) fn any_of<const COUNT: usize>(
    by: impl Look,
    now: &[f64; COUNT],
    out: &[f64; COUNT],
) -> bool {
    let mut lanes = [0; COUNT];
    add_bits(by, now, out, &mut lanes);
    any_signs(lanes)
}

/// Adds the bits of some, for several at once by a processor.
#[inline(always)]
fn add_bits<const COUNT: usize>(
    by: impl Look,
    now: &[f64; COUNT],
    out: &[f64; COUNT],
    lanes: &mut [u64; COUNT],
) {
    for x in 0..COUNT {
        lanes[x] |= by.bits(now[x], out[x]);
    }
}

/// Whether there are any bits in a run that is short, as those between materials may be: put together once, since that
/// takes as long as looking at many.
#[inline(always)]
pub(super) fn any_of_short(by: impl Look, now: &[f64], out: &[f64]) -> bool {
    let mut lanes = [0; FEWER];
    let (Some(last_now), Some(last_out)) = (now.last_chunk(), out.last_chunk()) else {
        return now.iter().zip(out).any(|(now, out)| any_signs([by.bits(*now, *out)]));
    };
    add_bits(by, last_now, last_out, &mut lanes);
    for (now, out) in now.as_chunks().0.iter().zip(out.as_chunks().0) {
        add_bits(by, now, out, &mut lanes);
    }
    any_signs(lanes)
}

/// Finds those of some, from place `first` on: rarely needed.
#[cold]
#[inline(never)]
fn find_by(by: Combine, now: &[f64], out: &[f64], found: &mut Vec<usize>, first: usize) {
    find(now.iter().zip(out).map(|(now, out)| by.bits(*now, *out)), found, first);
}

/// Finds those of a few, from place `first` on, of which bits of signs say that they do: rarely needed.
#[cold]
#[inline(never)]
pub(super) fn find(bits: impl Iterator<Item = u64>, found: &mut Vec<usize>, first: usize) {
    found.extend((first..).zip(bits).filter(|(_, bits)| bits >> 63 != 0).map(|(place, _)| place));
}

#[cfg(test)]
mod tests {
    use super::super::course::Course;
    use super::super::course::tests::{enthalpies, melts, solid};
    use super::*;
    use crate::model::Material;
    use crate::model::wide;

    fn course(material: &Material) -> Course {
        Course::of(material).expect("constant phases")
    }

    /// Melting at one temperature, and over ranges to what conducts less, as much and more.
    fn courses() -> [Course; 4] {
        [(400.0, 200.0), (420.0, 200.0), (420.0, 300.0), (420.0, 1200.0)]
            .map(|(liquidus, conductivity)| course(&melts(liquidus, conductivity)))
    }

    /// The potentials after a step of `dt` (s), and what passes to another phase in it.
    fn after(course: &Course, now: &[f64], rates: Vec<f64>, dt: f64) -> (Vec<f64>, Vec<usize>) {
        let (middle, mut out) = (now.len() / 2, rates);
        let step = course.step(dt);
        let runs = [0..middle, middle..now.len()].map(|run| (7 + run.start..7 + run.end, &step));
        step.phases.write(now, &mut out);
        let (runs, mut found) = (runs.into_iter(), Vec::new());
        wide::run(Crossings { runs, now, out: &mut out, found: &mut found, first: 7 });
        (out, found.iter().map(|place| place - 7).collect::<Vec<_>>())
    }

    #[test]
    fn potentials_go_where_their_enthalpies_do() {
        for (which, course) in courses().iter().enumerate() {
            let told = |enthalpy: &f64| course.tells(*enthalpy, course.potential(*enthalpy));
            let ascending: Vec<f64> = enthalpies().filter(told).collect();
            // The second takes some from one side of what is mushy to the other, and beyond. In the third some follow each
            // other, and others are mushy elsewhere.
            for (dt, few, stride) in [(0.5, 5, 1), (40.0, 1, 1), (0.5, 5, 1009)] {
                let at = |k: usize| ascending[(k / 11 * 11 * stride + k % 11) % ascending.len()];
                let before: Vec<f64> = (0..ascending.len()).map(at).collect();
                let now: Vec<f64> = before.iter().map(|h| course.potential(*h)).collect();
                let change = |k: usize| 0.7 * ((7 * k % 31) as f64 - 15.0);
                let rates: Vec<f64> = (0..before.len()).map(change).collect();
                let (out, crossings) = after(course, &now, rates.clone(), dt);
                let (mut off, mut would_be): (f64, f64) = (0.0, 0.0);
                for (k, (before, after)) in before.iter().zip(&out).enumerate() {
                    let expected = course.potential(before + dt * change(k));
                    match crossings.binary_search(&k) {
                        Ok(_) => {
                            let [rate, rest] = course.step(dt).phases.rate_and_rest(now[k], *after);
                            assert!(
                                (rate - rates[k]).abs() < 1e-11 && rest == now[k],
                                "{k}: {rate}"
                            );
                            would_be = would_be.max((after - expected).abs());
                        }
                        Err(_) => off = off.max((after - expected).abs()),
                    }
                }
                assert!(off < 1e-10, "{which}: {off:e}");
                assert!(would_be > 0.1, "{which}: what passes does not go on as it was");
                assert!(!crossings.is_empty() && crossings.len() < before.len() / few, "{which}");
            }
        }
    }

    #[test]
    fn what_does_not_melt_goes_on_with_its_rates() {
        let now: Vec<f64> = enthalpies().take(41).collect();
        let (out, crossings) = after(&course(&solid()), &now, vec![4.0; now.len()], 0.5);
        assert!(out.iter().zip(&now).all(|(out, now)| *out == now + 2.0) && crossings.is_empty());
    }

    #[test]
    fn crossings_are_found_wherever_they_are() {
        for course in courses() {
            for length in [1, 3, 4, 31, 32, 39, 77, 150] {
                for place in 0..length {
                    // All begin just below where something begins; one of them gets there.
                    let begins = course.potential(400.0);
                    let (now, mut rates) = (vec![begins; length], vec![-1.0; length]);
                    rates[place] = 1e-9;
                    assert_eq!(after(&course, &now, rates, 0.5).1, [place], "of {length}");
                }
            }
        }
    }

    #[test]
    fn all_that_pass_among_a_few_are_found() {
        for course in courses() {
            for (one, other) in (0..77).flat_map(|one| (0..one).map(move |other| (one, other))) {
                let begins = course.potential(400.0);
                let (now, mut rates) = (vec![begins; 77], vec![-1.0; 77]);
                [rates[one], rates[other]] = [1e-9; 2];
                assert_eq!(after(&course, &now, rates, 0.5).1, [other, one]);
            }
        }
    }

    #[test]
    fn a_potential_that_is_no_number_stays_so() {
        for course in courses() {
            let mut now = vec![course.potential(300.0); 40];
            now[17] = f64::NAN;
            let out = after(&course, &now, vec![0.0; now.len()], 0.5).0;
            assert!(out[17].is_nan() && out[16] == now[16] && out[18] == now[18]);
        }
    }
}
