//! How long work takes that is done again and again.

use std::time::{Duration, Instant};

/// Rounds that a measurement is cut into, about.
const ROUNDS: u32 = 7;

/// Rounds that a measurement has at least, unless it takes too long.
const LEAST_ROUNDS: usize = 3;

/// A measurement is over after this many times its least duration, however few its rounds.
const PATIENCE: u32 = 8;

/// Repetitions grow at most by this factor from one trial to the next.
const GROWTH: f64 = 16.0;

/// What one repetition takes, over several rounds of repetitions.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// Seconds a repetition in each round, ascending.
    seconds: Vec<f64>,
    /// Repetitions of a round.
    repetitions: u64,
}

impl Timing {
    /// Times `work(n)`, which does its work n times and waits for it, for `least` or longer: once
    /// to warm up, then until rounds are long enough to be timed, then those rounds.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn of<E>(least: Duration, mut work: impl FnMut(u64) -> Result<(), E>) -> Result<Self, E> {
        work(1)?;
        let round = (least / ROUNDS).as_secs_f64();
        let mut time = |count| {
            let clock = Instant::now();
            work(count).map(|()| clock.elapsed().as_secs_f64())
        };
        let started = Instant::now();
        let mut repetitions = 1;
        let mut took = time(repetitions)?;
        while took < 0.7 * round {
            let wanted = (round / took.max(1e-9)).clamp(1.0, GROWTH) * repetitions as f64;
            repetitions = (wanted.ceil() as u64).max(repetitions + 1);
            took = time(repetitions)?;
        }
        let mut seconds = vec![took / repetitions as f64];
        let is_over = |rounds: usize| {
            let elapsed = started.elapsed();
            (elapsed >= least && rounds >= LEAST_ROUNDS) || elapsed >= PATIENCE * least
        };
        while !is_over(seconds.len()) {
            seconds.push(time(repetitions)? / repetitions as f64);
        }
        seconds.sort_by(f64::total_cmp);
        Ok(Self { seconds, repetitions })
    }

    /// Seconds a repetition in the middle round.
    pub fn median(&self) -> f64 {
        let n = self.seconds.len();
        0.5 * (self.seconds[(n - 1) / 2] + self.seconds[n / 2])
    }

    /// Seconds a repetition in the fastest round.
    pub fn best(&self) -> f64 {
        self.seconds[0]
    }

    /// Seconds a repetition in the slowest round.
    pub fn worst(&self) -> f64 {
        self.seconds[self.seconds.len() - 1]
    }

    /// Repetitions of the rounds, all together.
    pub fn repetitions(&self) -> u64 {
        self.repetitions * self.seconds.len() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measurement_has_its_rounds_and_counts_its_work() {
        let mut done = 0;
        let work = |count| {
            done += count;
            std::thread::sleep(Duration::from_micros(200 * count));
            Ok::<_, ()>(())
        };
        let timing = Timing::of(Duration::from_millis(20), work).expect("work does not fail");
        assert!(timing.seconds.len() >= LEAST_ROUNDS && timing.repetitions > 0, "{timing:?}");
        // A sleep is never too short, so less would be a wrong count.
        assert!(timing.best() >= 200e-6 && timing.repetitions() < done, "{timing:?}");
        assert!(timing.best() <= timing.median() && timing.median() <= timing.worst());
    }

    #[test]
    fn slow_work_is_not_repeated_for_ever_and_failing_work_is_an_error() {
        let mut calls = 0;
        let slow = |_| {
            calls += 1;
            std::thread::sleep(Duration::from_millis(20));
            Ok::<_, ()>(())
        };
        let timing = Timing::of(Duration::from_millis(1), slow).expect("work does not fail");
        // The warm-up and one round, which already takes longer than patience lasts.
        assert_eq!((calls, timing.repetitions()), (2, 1));
        assert_eq!(Timing::of(Duration::from_millis(1), |_| Err::<(), _>("no")), Err("no"));
    }

    #[test]
    fn the_median_of_an_even_number_of_rounds_lies_between() {
        let timing = |seconds: &[f64]| Timing { seconds: seconds.to_vec(), repetitions: 2 };
        assert_eq!(timing(&[1.0, 2.0, 7.0]).median(), 2.0);
        assert_eq!(timing(&[1.0, 2.0, 4.0, 7.0]).median(), 3.0);
        assert_eq!(timing(&[1.0, 2.0, 4.0]).repetitions(), 6);
    }
}
