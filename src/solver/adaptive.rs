//! Steps that follow a tolerance.

use super::advance::{Observer, Progress, Taken};
use super::integrator::{Controller, Integrator};
use super::{Backend, SolverError};
use crate::model::Problem;
use crate::model::integrator::Segment;

/// Steps below this part of the duration lead nowhere.
const SMALLEST: f64 = 1e-13;

/// A run whose steps follow a tolerance.
pub(super) struct Adaptive<'a, B: Backend> {
    pub(super) problem: &'a Problem,
    pub(super) integrator: &'a mut dyn Integrator<B>,
    pub(super) controller: &'a mut Controller,
    /// The step to start with, s, also where something changes at once.
    pub(super) first: f64,
    /// Time reached, s.
    pub(super) time: f64,
    pub(super) taken: &'a mut Taken,
}

impl<B: Backend> Adaptive<'_, B> {
    /// Goes to the end of `segment`.
    pub(super) fn segment<O: Observer>(
        &mut self,
        backend: &mut B,
        observer: &mut O,
        segment: &Segment,
    ) -> Result<(), O::Error> {
        self.time = segment.start;
        let end = segment.start + segment.dt;
        while self.time < end {
            let remaining = end - self.time;
            let dt = self.controller.step(remaining);
            if dt < SMALLEST * self.problem.time.end && dt < remaining {
                return self.stop(backend, observer, dt);
            }
            if !self.try_step(backend, dt)? {
                self.taken.refused += 1;
                self.look(backend, observer)?;
                continue;
            }
            self.time = if dt == remaining { end } else { self.time + dt };
            self.taken.steps += 1;
            self.taken.largest = self.taken.largest.max(dt);
            if dt < remaining || self.taken.steps == 1 {
                self.taken.note(dt);
            }
            self.look(backend, observer)?;
        }
        if segment.is_break {
            self.controller.restart(self.first);
        }
        Ok(())
    }

    /// Tells the observer where the run is, which may stop it here: also between steps that are refused, of
    /// which there may be many.
    fn look<O: Observer>(&self, backend: &mut B, observer: &mut O) -> Result<(), O::Error> {
        let left = (self.problem.time.end - self.time) / self.controller.step(f64::MAX);
        let steps = self.taken.steps + left.ceil() as u64;
        let (step, time) = (self.taken.steps, self.time);
        let progress = Progress { step, steps, time, still: None };
        if observer.progress(progress).is_break() && time < self.problem.time.end {
            observer.last_state(time, backend.read()?.as_ref())?;
            return Err(SolverError::Interrupted { step, time }.into());
        }
        Ok(())
    }

    /// Takes a step of `dt` (s), if its error allows it.
    fn try_step(&mut self, backend: &mut B, dt: f64) -> Result<bool, SolverError> {
        let limit = self.controller.limit(backend.largest_value()?);
        if limit == 0.0 {
            // Nothing has a size yet that an error could be compared with.
            self.integrator.propose(backend, self.time, dt)?;
            self.integrator.accept(backend)?;
            if backend.largest_value()? == 0.0 {
                // Nothing has come up yet.
                self.controller.judge(dt, 0.0);
            }
            return Ok(true);
        }
        self.integrator.aim(limit);
        let proposed = self.integrator.propose(backend, self.time, dt);
        let error = match proposed.and_then(|()| self.integrator.error(backend, limit)) {
            // A shorter step is easier to solve for.
            Err(SolverError::NotConverged { .. }) => f64::NAN,
            other => other?,
        };
        let is_good = self.controller.judge(dt, error / limit);
        if is_good {
            self.integrator.accept(backend)?;
        }
        Ok(is_good)
    }

    fn stop<O: Observer>(
        &self,
        backend: &mut B,
        observer: &mut O,
        dt: f64,
    ) -> Result<(), O::Error> {
        let state = backend.read()?;
        observer.last_state(self.time, state.as_ref())?;
        let (step, time) = (self.taken.steps, self.time);
        let known = SolverError::of_temperatures(self.problem, state.as_ref(), step, time);
        Err(known.unwrap_or(SolverError::StepTooSmall { step, time, dt }).into())
    }
}
