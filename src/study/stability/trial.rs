//! One run of a scene, looked at as it goes.

use std::ops::ControlFlow;

use crate::model::Problem;
use crate::model::integrator::{Method, Segment};
use crate::model::operator::floating_bodies;
use crate::report::run::Conserved;
use crate::report::total;
use crate::solver::{
    Backend, Machine, Observer, PathChoice, PathWish, Progress, SolverError, Stepper, Taken,
    advance,
};
use crate::study::prepare::{Driver, Prepared, start};

/// Who may stop a run.
pub(super) type Watch<'a> = dyn FnMut() -> ControlFlow<()> + 'a;

/// What became of a run.
#[derive(Debug)]
pub(super) struct Trial {
    /// The last good state, in the problem's order.
    pub(super) state: Vec<f64>,
    /// The least and the largest value of any state that was looked at.
    pub(super) seen: [f64; 2],
    /// The total and what became of it.
    pub(super) conserved: Conserved,
    /// The method that was taken.
    pub(super) method: Method,
    /// Steps taken.
    pub(super) steps: u64,
    /// The smallest step, s.
    pub(super) smallest: f64,
    /// Operator applications.
    pub(super) applications: u64,
    /// Why the run stopped before its end, if it did.
    pub(super) stopped: Option<SolverError>,
}

/// Runs `problem` on `machine`; `watch` is asked between steps whether to go on.
///
/// # Errors
/// Those of a run that cannot start.
pub(super) fn run(
    problem: &Problem,
    machine: &Machine,
    allow_unstable: bool,
    watch: &mut Watch<'_>,
) -> Result<Trial, SolverError> {
    let choice = PathChoice::new(problem, machine.kind(), PathWish::Auto)?;
    start(problem, machine, choice, allow_unstable, Look { problem, machine, watch })?
}

struct Look<'a, 'b> {
    problem: &'a Problem,
    machine: &'a Machine,
    watch: &'a mut Watch<'b>,
}

impl Driver for Look<'_, '_> {
    type Output = Result<Trial, SolverError>;

    fn drive<B: Backend + 'static>(self, prepared: Prepared, mut backend: B) -> Self::Output {
        let (problem, step) = (self.problem, &prepared.step);
        let precision = self.machine.kind().precision();
        let mut seen = Seen::new(self.watch, &problem.initial);
        let mut taken = Taken::NONE;
        let mut stepper = Stepper::new(&mut backend, problem, step, precision)?;
        let done = advance(&mut backend, problem, &mut stepper, step.dt, &mut seen, &mut taken);
        let stopped = match done {
            Err(error) if error.leaves_a_state() => Some(error),
            done => done.map(|()| None)?,
        };
        let volume = &problem.particles.volume;
        let [initial, last] = [&problem.initial, &seen.state].map(|state| total(state, volume));
        let magnitude: Vec<f64> = problem.initial.iter().map(|value| value.abs()).collect();
        let exchange = match step.method {
            // No time passes on the way there: what came in is what the change took.
            Method::Steady if !is_floating(problem) => last - initial,
            _ => backend.exchange()?,
        };
        Ok(Trial {
            conserved: Conserved::new(initial, last, exchange, total(&magnitude, volume)),
            state: seen.state,
            seen: seen.range,
            method: step.method,
            steps: taken.steps,
            smallest: taken.smallest,
            applications: stepper.applications(),
            stopped,
        })
    }
}

/// Whether nothing holds a value anywhere.
fn is_floating(problem: &Problem) -> bool {
    let floating: usize = floating_bodies(problem).iter().map(Vec::len).sum();
    floating == problem.particles.len()
}

/// Keeps the last state, and the range of all.
struct Seen<'a, 'b> {
    watch: &'a mut Watch<'b>,
    state: Vec<f64>,
    range: [f64; 2],
}

impl<'a, 'b> Seen<'a, 'b> {
    fn new(watch: &'a mut Watch<'b>, initial: &[f64]) -> Self {
        let mut seen = Self { watch, state: Vec::new(), range: [f64::INFINITY, f64::NEG_INFINITY] };
        seen.keep(initial);
        seen
    }

    fn keep(&mut self, state: &[f64]) {
        for value in state {
            self.range = [self.range[0].min(*value), self.range[1].max(*value)];
        }
        state.clone_into(&mut self.state);
    }
}

impl Observer for Seen<'_, '_> {
    type Error = SolverError;

    fn progress(&mut self, _progress: Progress) -> ControlFlow<()> {
        (self.watch)()
    }

    fn record(&mut self, _segment: &Segment, state: &[f64]) -> Result<(), SolverError> {
        self.keep(state);
        Ok(())
    }

    fn last_state(&mut self, _time: f64, state: &[f64]) -> Result<(), SolverError> {
        self.keep(state);
        Ok(())
    }
}
