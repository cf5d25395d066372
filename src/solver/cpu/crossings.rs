//! What passes to another phase in a step of potentials.

use std::ops::Range;

use super::course::CourseStep;
use super::operator::Combine;
use crate::model::wide::{Work, multiply_add};

/// Values that are looked at together.
const FEW: usize = 32;
/// The same at the end of a run, but for the last ones.
const FEWER: usize = 4;

/// Finds what passes to another phase in a step, of which it takes the last part where operators have written rates, and
/// where a phase has no single slope.
pub(super) struct Crossings<'a, R> {
    /// Places that follow each other, and what takes those of each run a step on.
    pub(super) runs: R,
    /// The potentials before it.
    pub(super) now: &'a [f64],
    /// Those after it, or where `of_rates` the rates, which become them. What passes to another phase has what it would
    /// have with the slope of [`CourseStep::phases`].
    pub(super) out: &'a mut [f64],
    pub(super) of_rates: bool,
    /// Takes the places that do, where potentials are from place `first` on.
    pub(super) found: &'a mut Vec<usize>,
    pub(super) first: usize,
}

impl<R: Iterator<Item = (Range<usize>, CourseStep)>> Work for Crossings<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        match self.of_rates {
            true => self.look::<FUSED, true>(),
            false => self.look::<FUSED, false>(),
        }
    }
}

impl<R: Iterator<Item = (Range<usize>, CourseStep)>> Crossings<'_, R> {
    #[inline(always)]
    fn look<const FUSED: bool, const RATES: bool>(self) {
        let Self { runs, now, out, found, first, .. } = self;
        for (run, CourseStep { phases, mushy }) in runs {
            let local = run.start - first..run.end - first;
            let rest = Rest { now: &now[local.clone()], out: &mut out[local], first: run.start };
            match mushy {
                None => rest.look::<FUSED, RATES>(phases, found),
                Some(mushy) => rest.look::<FUSED, RATES>((phases, mushy), found),
            }
        }
    }
}

/// How a few potentials are taken on and looked at.
pub(super) trait Look: Copy {
    /// Adds those from place `first` on that pass to another phase to `found`; with `RATES`, takes them on by these, which
    /// are in `out`.
    fn few<const FUSED: bool, const RATES: bool, const COUNT: usize>(
        self,
        now: &[f64; COUNT],
        out: &mut [f64; COUNT],
        found: &mut Vec<usize>,
        first: usize,
    );
}

/// What is left of a run, whose potentials are from place `first` on.
struct Rest<'a> {
    now: &'a [f64],
    out: &'a mut [f64],
    first: usize,
}

impl Rest<'_> {
    #[inline(always)]
    fn look<const FUSED: bool, const RATES: bool>(mut self, by: impl Look, found: &mut Vec<usize>) {
        self.some::<FUSED, RATES, FEW>(by, found);
        // Runs between materials may be short.
        self.some::<FUSED, RATES, FEWER>(by, found);
        self.some::<FUSED, RATES, 1>(by, found);
    }

    /// Looks at as many as there are `COUNT` together of.
    #[inline(always)]
    fn some<const FUSED: bool, const RATES: bool, const COUNT: usize>(
        &mut self,
        by: impl Look,
        found: &mut Vec<usize>,
    ) {
        let mut now = self.now;
        let mut out = std::mem::take(&mut self.out);
        while let Some((few, rest)) = now.split_first_chunk::<COUNT>() {
            let (these, others) = out.split_first_chunk_mut::<COUNT>().expect("as many");
            by.few::<FUSED, RATES, COUNT>(few, these, found, self.first);
            (now, out) = (rest, others);
            self.first += COUNT;
        }
        (self.now, self.out) = (now, out);
    }
}

/// Of what melts at one temperature or not at all.
impl Look for Combine {
    #[inline(always)]
    fn few<const FUSED: bool, const RATES: bool, const COUNT: usize>(
        self,
        now: &[f64; COUNT],
        out: &mut [f64; COUNT],
        found: &mut Vec<usize>,
        first: usize,
    ) {
        let (mut next, mut any) = (*out, 0);
        for x in 0..COUNT {
            if RATES {
                next[x] = multiply_add::<FUSED>(self.factor(now[x]), out[x], now[x]);
            }
            // Bits of signs, since a processor puts them together for several at once.
            any |= self.room(now[x]).to_bits() ^ self.room(next[x]).to_bits();
        }
        if RATES {
            *out = next;
        }
        if any >> 63 != 0 {
            let passes =
                |(now, next): (&f64, &f64)| self.room(*now).to_bits() ^ self.room(*next).to_bits();
            find(now.iter().zip(&*out).map(passes), found, first);
        }
    }
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
        let find = |of_rates: bool, mut out: Vec<f64>| {
            let middle = now.len() / 2;
            let runs = [0..middle, middle..now.len()]
                .map(|run| (7 + run.start..7 + run.end, course.step(dt)));
            let (runs, mut found) = (runs.into_iter(), Vec::new());
            wide::run(Crossings {
                runs,
                now,
                out: &mut out,
                of_rates,
                found: &mut found,
                first: 7,
            });
            (out, found.iter().map(|place| place - 7).collect::<Vec<_>>())
        };
        let mut by_operator = rates.clone();
        course.step(dt).phases.write(now, &mut by_operator);
        let ((after, found), (same, also_found)) = (find(true, rates), find(false, by_operator));
        assert_eq!(found, also_found, "of rates, and of what an operator wrote");
        let off = after.iter().zip(&same).map(|(one, other)| (one - other).abs());
        assert!(off.fold(0.0, f64::max) < 1e-11);
        (after, found)
    }

    #[test]
    fn potentials_go_where_their_enthalpies_do() {
        for (which, course) in courses().iter().enumerate() {
            let told = |enthalpy: &f64| course.tells(*enthalpy, course.potential(*enthalpy));
            let before: Vec<f64> = enthalpies().filter(told).collect();
            let now: Vec<f64> = before.iter().map(|h| course.potential(*h)).collect();
            // The second takes some from one side of what is mushy to the other, and beyond.
            for (dt, few) in [(0.5, 5), (40.0, 1)] {
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
    fn a_potential_that_is_no_number_stays_so() {
        for course in courses() {
            let mut now = vec![course.potential(300.0); 40];
            now[17] = f64::NAN;
            let mut out = vec![0.0; now.len()];
            let runs = [(0..now.len(), course.step(0.5))].into_iter();
            let (found, first) = (&mut Vec::new(), 0);
            wide::run(Crossings { runs, now: &now, out: &mut out, of_rates: true, found, first });
            assert!(out[17].is_nan() && out[16] == now[16] && out[18] == now[18]);
        }
    }
}
