//! One measurement: set-up, steps, and what they come to beside the limits.

use std::time::{Duration, Instant};

use super::cost::{Cost, sum};
use super::{Bench, Progressing};
use crate::model::Problem;
use crate::report::bench::Measurement;
use crate::solver::{Backend, Limits, PathChoice, SolverError, Timing};
use crate::study::prepare::{Driver, Prepared, start};

impl Bench<'_> {
    /// Measures a series on `problem`, which took `build_s` (s) to build; one that cannot be had
    /// here, or a scene that the device has no room for, is left out.
    pub(super) fn measure(
        &mut self,
        index: usize,
        problem: &Problem,
        size: u64,
        build_s: f64,
    ) -> Result<(), SolverError> {
        let of = &mut self.all_series[index];
        match of.measure(problem, self.options.least) {
            Ok((run, cost)) => {
                if !run.is_finite {
                    let what = of.series.at(size);
                    self.report.warnings.push(format!("{what}: a value is not finite"));
                }
                of.last = Some((problem.particles.len() as u64, run.setup_s));
                let measurement = Measurement { size, build_s, ..run.against(&of.limits, cost) };
                of.report.measurements.push(measurement);
                Ok(())
            }
            // The path or the precision cannot be had, whatever the size.
            Err(error) if error.is_usage() => {
                of.closed = true;
                let why = match error {
                    SolverError::NoLattice { why } => why.to_owned(),
                    error => error.to_string(),
                };
                of.leave_out(None, why);
                Ok(())
            }
            Err(error) if error.is_lack_of_room() => {
                of.leave_out(Some(size), error.to_string());
                Ok(())
            }
            Err(error) => Err(error),
        }
    }
}

impl Progressing {
    fn measure(&self, problem: &Problem, least: Duration) -> Result<(Run, Cost), SolverError> {
        let started = Instant::now();
        let machine = self.machine.kind();
        let choice = PathChoice::new(problem, machine, self.series.path)?;
        let sum = sum(problem, &choice, machine);
        let watch = Stopwatch { started, least, particles: problem.particles.len() as f64 };
        let run = start(problem, &self.machine, choice, false, watch)??;
        let cost = Cost::new(machine, run.neighbors, sum);
        Ok((run, cost))
    }
}

/// Times the steps of a scene that is ready.
struct Stopwatch {
    /// When its set-up began.
    started: Instant,
    least: Duration,
    particles: f64,
}

/// What the steps of a scene told.
struct Run {
    particles: f64,
    neighbors: f64,
    setup_s: f64,
    timing: Timing,
    memory_bytes: u64,
    is_finite: bool,
}

impl Driver for Stopwatch {
    type Output = Result<Run, SolverError>;

    fn drive<B: Backend + 'static>(self, prepared: Prepared, mut backend: B) -> Self::Output {
        backend.wait()?;
        let setup_s = self.started.elapsed().as_secs_f64();
        let dt = prepared.step.dt;
        let mut steps = 0;
        let timing = Timing::of(self.least, |count| {
            backend.euler(steps as f64 * dt, dt, count)?;
            steps += count;
            backend.wait()
        })?;
        let particles = self.particles;
        Ok(Run {
            particles,
            neighbors: prepared.survey.entries as f64 / particles,
            setup_s,
            timing,
            memory_bytes: backend.memory_bytes(),
            is_finite: backend.is_finite()?,
        })
    }
}

impl Run {
    /// The measurement beside the limits; which size it was and what its scene took is left open.
    fn against(&self, limits: &Limits, cost: Cost) -> Measurement {
        let updates = |seconds: f64| self.particles / seconds;
        let rate = updates(self.timing.median());
        let (by_copy, by_arithmetic) =
            (limits.copy / cost.bytes, limits.arithmetic / cost.operations);
        let by_read = limits.read.map(|read| read / cost.read);
        let all = [("copy", Some(by_copy)), ("read", by_read), ("arithmetic", Some(by_arithmetic))];
        let known = all.into_iter().filter_map(|(name, limit)| Some((name, limit?)));
        // Of equal ones the first.
        let lower = |a: (&'static str, f64), b: (&'static str, f64)| if b.1 < a.1 { b } else { a };
        let (bound_by, limit) = known.fold(("copy", by_copy), lower);
        Measurement {
            size: 0,
            particles: self.particles as u64,
            neighbors: self.neighbors,
            build_s: 0.0,
            setup_s: self.setup_s,
            steps: self.timing.repetitions(),
            updates_per_s: rate,
            slowest_updates_per_s: updates(self.timing.worst()),
            fastest_updates_per_s: updates(self.timing.best()),
            bytes_per_update: cost.bytes,
            bytes_per_s: rate * cost.bytes,
            copy_fraction: rate / by_copy,
            read_bytes_per_update: cost.read,
            read_fraction: by_read.map(|limit| rate / limit),
            operations_per_update: cost.operations,
            operations_per_s: rate * cost.operations,
            arithmetic_fraction: rate / by_arithmetic,
            bound_by: bound_by.to_owned(),
            limit_updates_per_s: limit,
            limit_fraction: rate / limit,
            memory_bytes: self.memory_bytes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_of_the_limits_binds() {
        let timing = Timing::of(Duration::ZERO, |_| Ok::<_, ()>(())).expect("nothing fails");
        let seconds = timing.median();
        let run = Run {
            particles: 1000.0,
            neighbors: 26.0,
            setup_s: 0.0,
            timing,
            memory_bytes: 0,
            is_finite: true,
        };
        let cost = Cost { bytes: 16.0, read: 8.0, operations: 32.0 };
        let with = |read, arithmetic| {
            let limits = Limits { copy: 1e9, copy_one_thread: None, read, arithmetic };
            run.against(&limits, cost)
        };
        let (memory, processor) = (with(None, 3e9), with(Some(1e9), 1e9));
        let reading = with(Some(4e8), 3e9);
        assert_eq!((&*reading.bound_by, reading.limit_updates_per_s), ("read", 5e7));
        assert_eq!(Some(reading.limit_fraction), reading.read_fraction);
        assert!(memory.read_fraction.is_none() && reading.copy_fraction < reading.limit_fraction);
        assert_eq!((&*memory.bound_by, memory.limit_updates_per_s), ("copy", 6.25e7));
        assert_eq!((&*processor.bound_by, processor.limit_updates_per_s), ("arithmetic", 3.125e7));
        assert_eq!(memory.updates_per_s, 1000.0 / seconds);
        assert_eq!(memory.limit_fraction, memory.copy_fraction);
        assert_eq!(processor.limit_fraction, processor.arithmetic_fraction);
        assert!(memory.arithmetic_fraction < memory.copy_fraction);
    }
}
