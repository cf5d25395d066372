//! How much work goes into a submission.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::{Device, GpuError, Submission};

/// What a submission should take. Drivers stop one that takes seconds, and a user waits for one to
/// end before a run can be interrupted.
const TARGET: Duration = Duration::from_millis(100);

/// Submissions that the device may have at once: one to work on, and one so that it does not wait.
const IN_FLIGHT: usize = 2;

/// Repetitions in the first submission, before any has been timed.
const FIRST: u64 = 4;

/// Bounds the length of submissions that repeat the same work, by timing them.
#[derive(Debug)]
pub struct Pace {
    most: u64,
    repetitions: u64,
    in_flight: VecDeque<(Submission, u64, Instant)>,
    last_done: Option<Instant>,
}

impl Pace {
    /// For submissions of at most `most` repetitions.
    pub fn new(most: u64) -> Self {
        Self {
            most: most.max(1),
            repetitions: FIRST.min(most.max(1)),
            in_flight: VecDeque::new(),
            last_done: None,
        }
    }

    /// How many of the `remaining` repetitions the next submission should have; before it returns,
    /// it waits until the device is free to take one.
    pub fn next(&mut self, device: &Device, remaining: u64) -> Result<u64, GpuError> {
        while self.in_flight.len() >= IN_FLIGHT {
            self.finish_oldest(device)?;
        }
        Ok(self.repetitions.min(remaining))
    }

    /// Notes that `submission` has `repetitions`.
    pub fn submitted(&mut self, submission: Submission, repetitions: u64) {
        let entry = (submission, repetitions, Instant::now());
        self.in_flight.push_back(entry);
    }

    fn finish_oldest(&mut self, device: &Device) -> Result<(), GpuError> {
        let Some((submission, repetitions, submitted)) = self.in_flight.pop_front() else {
            return Ok(());
        };
        device.wait(&submission)?;
        let now = Instant::now();
        let begun = self.last_done.map_or(submitted, |done| done.max(submitted));
        self.last_done = Some(now);
        self.adapt(now - begun, repetitions);
        Ok(())
    }

    /// Aims at the target, at most doubling at once: short submissions measure poorly.
    fn adapt(&mut self, took: Duration, repetitions: u64) {
        let each = took.as_secs_f64() / repetitions as f64;
        let fitting = (TARGET.as_secs_f64() / each.max(1e-9)) as u64;
        self.repetitions = fitting.min(2 * self.repetitions).clamp(1, self.most);
    }
}

#[cfg(test)]
mod tests {
    use super::{FIRST, Pace, TARGET};

    #[test]
    fn pace_approaches_the_target_from_both_sides_within_its_bounds() {
        let mut pace = Pace::new(1000);
        for _ in 0..20 {
            pace.adapt(TARGET / 50 * pace.repetitions as u32, pace.repetitions);
        }
        assert!((49..=50).contains(&pace.repetitions));
        pace.adapt(TARGET * 100, 50);
        assert_eq!(pace.repetitions, 1);
        let mut quick = Pace::new(10);
        assert_eq!(quick.repetitions, FIRST);
        quick.adapt(TARGET / 1_000_000, 4);
        quick.adapt(TARGET / 1_000_000, 8);
        assert_eq!(quick.repetitions, 10);
    }
}
