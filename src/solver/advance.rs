//! The time loop: written once, over the backend trait.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::adaptive::Adaptive;
use super::integrator::{Kind, Stepper, Steps, solve_steady};
use super::{Backend, SolverError};
use crate::model::Problem;
use crate::model::integrator::{Schedule, Segment};

/// Steps taken before the first look at the clock.
const FIRST_CHUNK: u64 = 4;
/// Steps between two looks at the clock, the values and the user, at most.
const LARGEST_CHUNK: u64 = 1 << 12;
/// What a chunk should take: short enough to stop and to report at once.
const CHUNK_TIME: Duration = Duration::from_millis(300);

/// How much work may be lost to a value that is not finite: what is between two copies of the state,
/// which each cost as much as a step or two.
const SAVE_EVERY: Duration = Duration::from_secs(2);
/// A look at the values reads all of them, which costs a good part of a step on a large lattice: the
/// next one waits for so many times what the last one took.
const LOOK_EVERY: u32 = 50;

/// Where a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Steps taken.
    pub step: u64,
    /// Steps of the whole run, as far as that is known.
    pub steps: u64,
    /// Time reached, s.
    pub time: f64,
    /// Since when nothing has changed.
    pub still: Option<Still>,
}

/// Who is told of a run as it goes.
pub trait Observer {
    /// What makes the observer's part fail; solver errors become one too.
    type Error: From<SolverError>;

    /// Called every so often between steps; a break stops the run at this step.
    fn progress(&mut self, progress: Progress) -> ControlFlow<()>;

    /// The state at a time of output or probe (`segment.output`, `segment.probe`), in the
    /// problem's order.
    fn record(&mut self, segment: &Segment, state: &[f64]) -> Result<(), Self::Error>;

    /// The last finite state of a run that stops early, at `time` (s).
    fn last_state(&mut self, time: f64, state: &[f64]) -> Result<(), Self::Error>;
}

/// Since when a run has changed nothing, as far as it was looked at: a look compares the states before
/// and after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Still {
    /// Steps taken at the last look that saw a change, or at none.
    pub step: u64,
    /// The time then, s.
    pub time: f64,
}

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// Steps.
    pub steps: u64,
    /// Steps that a tolerance refused.
    pub refused: u64,
    /// The smallest step, s, but for those that a tolerance would have had longer and an output cut short.
    pub smallest: f64,
    /// The largest step, s.
    pub largest: f64,
}

impl Taken {
    /// No steps.
    pub const NONE: Self = Self { steps: 0, refused: 0, smallest: f64::INFINITY, largest: 0.0 };

    /// Takes note of the length of a step, s.
    pub(super) fn note(&mut self, dt: f64) {
        self.smallest = self.smallest.min(dt);
        self.largest = self.largest.max(dt);
    }
}

/// Runs `problem` from its start to its end on `backend` with the steps of `stepper`, whose equal steps are
/// at most `dt` (s). A value that is not finite stops the run with the step, time and particle where it
/// came up; the last state known to be finite goes to the observer first. `taken` follows what is done.
pub fn advance<B: Backend, O: Observer>(
    backend: &mut B,
    problem: &Problem,
    stepper: &mut Stepper<B>,
    dt: f64,
    observer: &mut O,
    taken: &mut Taken,
) -> Result<(), O::Error> {
    let mut last = Ok(());
    match &mut stepper.kind {
        Kind::Equal(steps) => {
            let schedule = Schedule::new(&problem.time, dt);
            let total = schedule.total_steps();
            let mut run = Run {
                steps: total,
                step: 0,
                chunk: FIRST_CHUNK,
                look: Duration::ZERO,
                still: None,
                problem,
            };
            for segment in schedule {
                taken.note(segment.dt);
                last = run.segment(backend, &mut **steps, observer, &segment);
                taken.steps = run.step;
                if last.is_err() {
                    break;
                }
                record(backend, observer, &segment)?;
            }
        }
        Kind::Adaptive(integrator, controller) => {
            let schedule = Schedule::new(&problem.time, f64::INFINITY);
            let integrator = &mut **integrator;
            let mut run = Adaptive { problem, integrator, controller, first: dt, time: 0.0, taken };
            for segment in schedule {
                run.segment(backend, observer, &segment)?;
                record(backend, observer, &segment)?;
            }
        }
        Kind::Steady { reduction, rounding, applications } => {
            let at_start = Progress { step: 0, steps: 1, time: 0.0, still: None };
            let mut watch = || observer.progress(at_start);
            let solved = solve_steady(backend, problem, *reduction, *rounding, &mut watch);
            if let Err(SolverError::Interrupted { .. }) = solved {
                observer.last_state(0.0, backend.read()?.as_ref())?;
            }
            *applications = solved?;
            for segment in Schedule::new(&problem.time, f64::INFINITY) {
                record(backend, observer, &segment)?;
            }
        }
    }
    last
}

/// Hands the state at the end of a segment to the observer, if that is wanted.
fn record<B: Backend, O: Observer>(
    backend: &mut B,
    observer: &mut O,
    segment: &Segment,
) -> Result<(), O::Error> {
    if segment.output || segment.probe {
        observer.record(segment, backend.read()?.as_ref())?;
    }
    Ok(())
}

struct Run<'a> {
    steps: u64,
    step: u64,
    chunk: u64,
    /// What the last look at the values took.
    look: Duration,
    still: Option<Still>,
    problem: &'a Problem,
}

impl Run<'_> {
    fn segment<B: Backend, O: Observer>(
        &mut self,
        backend: &mut B,
        stepper: &mut dyn Steps<B>,
        observer: &mut O,
        segment: &Segment,
    ) -> Result<(), O::Error> {
        let (first, end) = (self.step, self.step + segment.steps);
        let time_at = |step: u64| segment.start + (step - first) as f64 * segment.dt;
        // The steps of the states last saved and last looked at.
        let (mut saved, mut looked) = (first, first);
        let (mut since_saved, mut since_look) = (SAVE_EVERY, Duration::ZERO);
        while self.step < end {
            if since_saved >= SAVE_EVERY && looked == self.step {
                backend.save()?;
                (saved, since_saved) = (self.step, Duration::ZERO);
            }
            let clock = Instant::now();
            let count = self.chunk.min(end - self.step);
            if let Err(error) = stepper.take(backend, time_at(self.step), segment.dt, count) {
                return self.failed(backend, observer, error, time_at(self.step));
            }
            backend.wait()?;
            let elapsed = clock.elapsed();
            self.adapt(count, elapsed);
            self.step += count;
            since_saved += elapsed;
            since_look += elapsed;
            let time = time_at(self.step);
            // Beside so many steps a look costs nothing, however long it takes.
            let is_due = since_look >= self.look * LOOK_EVERY
                || since_saved >= SAVE_EVERY
                || self.step - looked >= LARGEST_CHUNK;
            if is_due || self.step == end {
                let clock = Instant::now();
                if !backend.is_finite()? {
                    let count = self.step - saved;
                    self.step = saved;
                    return self.diverged(
                        backend,
                        stepper,
                        observer,
                        time_at(saved),
                        segment.dt,
                        count,
                    );
                }
                let before = Still { step: looked, time: time_at(looked) };
                self.still = backend.is_still()?.then(|| self.still.unwrap_or(before));
                looked = self.step;
                (self.look, since_look) = (clock.elapsed(), Duration::ZERO);
            }
            let progress = Progress { step: self.step, steps: self.steps, time, still: self.still };
            if observer.progress(progress).is_break() && self.step < self.steps {
                if looked < self.step && !backend.is_finite()? {
                    let count = self.step - saved;
                    self.step = saved;
                    let start = time_at(saved);
                    return self.diverged(backend, stepper, observer, start, segment.dt, count);
                }
                observer.last_state(time, backend.read()?.as_ref())?;
                return Err(SolverError::Interrupted { step: self.step, time }.into());
            }
        }
        Ok(())
    }

    /// Steps that could not be taken, from about `time` (s) on: where a system did not converge since a
    /// conductivity is not known, it says so.
    fn failed<B: Backend, O: Observer>(
        &self,
        backend: &mut B,
        observer: &mut O,
        error: SolverError,
        time: f64,
    ) -> Result<(), O::Error> {
        if matches!(error, SolverError::NotConverged { .. }) && self.problem.has_curves() {
            let state = backend.read()?;
            let step = self.step;
            let known = SolverError::of_temperatures(self.problem, state.as_ref(), step, time);
            if let Some(known) = known {
                observer.last_state(time, state.as_ref())?;
                return Err(known.into());
            }
        }
        Err(error.into())
    }

    /// Aims the next chunk at [`CHUNK_TIME`].
    fn adapt(&mut self, count: u64, elapsed: Duration) {
        let wanted = count as f64 * CHUNK_TIME.as_secs_f64() / elapsed.as_secs_f64().max(1e-9);
        self.chunk = (wanted as u64).clamp(1, (self.chunk * 4).min(LARGEST_CHUNK));
    }

    /// Finds the first of the `count` steps since the state was saved at `start` (s) whose result is
    /// not finite, by bisection from there, and leaves the backend at the step before.
    fn diverged<B: Backend, O: Observer>(
        &self,
        backend: &mut B,
        stepper: &mut dyn Steps<B>,
        observer: &mut O,
        start: f64,
        dt: f64,
        count: u64,
    ) -> Result<(), O::Error> {
        let (mut good, mut bad) = (0, count);
        while bad - good > 1 {
            let middle = good + (bad - good) / 2;
            backend.restore()?;
            stepper.take(backend, start + good as f64 * dt, dt, middle - good)?;
            if backend.is_finite()? {
                backend.save()?;
                good = middle;
            } else {
                bad = middle;
            }
        }
        backend.restore()?;
        stepper.take(backend, start + good as f64 * dt, dt, bad - good)?;
        let state = backend.read()?;
        backend.restore()?;
        let time = start + good as f64 * dt;
        let last = backend.read()?;
        observer.last_state(time, last.as_ref())?;
        let step = self.step + good;
        if let Some(error) = SolverError::of_temperatures(self.problem, last.as_ref(), step, time) {
            return Err(error.into());
        }
        let not_finite = state.as_ref().iter().position(|x| !x.is_finite());
        Err(match not_finite {
            None => SolverError::NotRepeatable { step: self.step },
            Some(particle) => SolverError::Diverged {
                step: self.step + bad,
                time: start + bad as f64 * dt,
                particle,
                position: self.problem.particles.position[particle],
                value: state.as_ref()[particle],
            },
        }
        .into())
    }
}
