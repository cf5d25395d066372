//! A scene in every way and precision.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use super::Tampering;
use super::judge::{Judge, Range, above, is_documented};
use super::references::References;
use super::scan::Bounds;
use super::scenes::{ExtremeScene, Length};
use super::trial::{self, Trial, Watch};
use super::way::{ABOVE, Way};
use crate::model::integrator::Method;
use crate::model::{Problem, StepChoice};
use crate::report::format::{significant, wall_time};
use crate::report::stability::{Check, TrialReport, Verdict};
use crate::solver::{Machine, SolverError};

/// Growth is measured over so many steps of the mode.
const GROWTH_STEPS: f64 = 8.0;

/// A scene with what is known of it.
pub(super) struct Trials<'a> {
    scene: &'a ExtremeScene,
    bounds: &'a Bounds,
    tampering: Tampering,
    references: References,
    /// What the CPU came to, by way.
    in_f64: Vec<(Way, Vec<f64>)>,
}

/// Why a run has no result.
enum Lost {
    /// The user stopped it.
    Interrupted,
    /// It ended in an error.
    Error(SolverError),
    /// It panicked.
    Panic,
}

impl<'a> Trials<'a> {
    pub(super) fn new(scene: &'a ExtremeScene, bounds: &'a Bounds, tampering: Tampering) -> Self {
        Self { scene, bounds, tampering, references: References::default(), in_f64: Vec::new() }
    }

    /// The scene in `way` on `machine`, for no longer than `patience`; `None` if `ask` stopped it.
    pub(super) fn run(
        &mut self,
        way: Way,
        machine: &Machine,
        patience: Duration,
        ask: &mut Watch<'_>,
    ) -> Option<TrialReport> {
        let mut report = self.empty(way, machine);
        let (started, mut is_late) = (Instant::now(), false);
        let mut watch = || {
            is_late = started.elapsed() > patience;
            if is_late { ControlFlow::Break(()) } else { ask() }
        };
        let judged = match way {
            Way::EulerAbove => self.above(machine, &mut watch, &mut report),
            _ => self.below(way, machine, &mut watch, &mut report),
        };
        match judged {
            Ok(checks) => {
                report.verdict = Verdict::of(&checks);
                (report.figure, report.reason) = describe(way, &checks);
                report.checks = checks;
            }
            Err(Lost::Interrupted) if is_late => {
                report.verdict = Verdict::Degraded;
                report.figure = "slow".to_owned();
                report.reason = format!("stopped after {}", wall_time(patience.as_secs_f64()));
            }
            Err(Lost::Interrupted) => return None,
            Err(Lost::Error(error)) => {
                let documented = is_documented(&error);
                report.verdict = if documented { Verdict::Refused } else { Verdict::Fail };
                report.figure = "error".to_owned();
                report.reason = error.to_string();
            }
            Err(Lost::Panic) => {
                report.verdict = Verdict::Fail;
                report.figure = "panic".to_owned();
                report.reason = "the run panicked".to_owned();
            }
        }
        Some(report)
    }

    fn empty(&self, way: Way, machine: &Machine) -> TrialReport {
        let kind = machine.kind();
        TrialReport {
            scene: self.scene.name.clone(),
            group: self.scene.group.to_owned(),
            way: way.name().to_owned(),
            backend: kind.backend_name().to_owned(),
            precision: kind.precision().name().to_owned(),
            verdict: Verdict::Fail,
            figure: String::new(),
            reason: String::new(),
            method: None,
            steps: 0,
            operator_applications: 0,
            step_s: None,
            checks: Vec::new(),
        }
    }

    /// Runs what must work.
    fn below(
        &mut self,
        way: Way,
        machine: &Machine,
        watch: &mut Watch<'_>,
        report: &mut TrialReport,
    ) -> Result<Vec<Check>, Lost> {
        let problem = way.problem(self.scene, self.bounds);
        let trial = self.attempt(&problem, machine, watch)?;
        report.method = Some(trial.method.name().to_owned());
        report.steps = trial.steps;
        report.operator_applications = trial.applications;
        report.step_s = Some(trial.smallest).filter(|step| step.is_finite());
        let halved = match (way, self.scene.length) {
            (Way::EulerSafe, Length::Steps(_) | Length::Jump(_)) => {
                Some(self.attempt(&half(problem.clone()), machine, watch)?.state)
            }
            _ => None,
        };
        let judge = Judge {
            problem: &problem,
            bounds: self.bounds,
            precision: machine.kind().precision(),
            range: Range::of(&problem),
        };
        let in_f64 = match machine {
            Machine::Cpu => None,
            Machine::Gpu { .. } => self.in_f64.iter().find(|(of, _)| *of == way),
        };
        let in_f64 = in_f64.map(|(_, state)| &state[..]);
        let reference = self.references.of(way, self.scene, self.bounds, watch);
        let mut checks = judge.checks(way, &trial, reference, halved.as_deref(), in_f64);
        if way == Way::EulerBelow {
            checks.push(judge.bounded_by_norm(&trial));
        }
        if matches!(machine, Machine::Cpu) {
            self.in_f64.push((way, trial.state));
        }
        Ok(checks)
    }

    /// Runs what must not work, and must say so.
    fn above(
        &self,
        machine: &Machine,
        watch: &mut Watch<'_>,
        report: &mut TrialReport,
    ) -> Result<Vec<Check>, Lost> {
        let problem = Way::EulerAbove.problem(self.scene, self.bounds);
        let refused = trial::run(&problem, machine, false, watch);
        let runs = self.tampering.applied(problem.clone());
        let ended = trial::run(&runs, machine, true, watch);
        if let Ok(Trial { stopped: Some(SolverError::Interrupted { .. }), .. }) = &ended {
            return Err(Lost::Interrupted);
        }
        if let Ok(trial) = &ended {
            report.method = Some(Method::Euler.name().to_owned());
            report.steps = trial.steps;
            report.operator_applications = trial.applications;
        }
        report.step_s = Some(ABOVE * self.bounds.limit);
        let growth = self.growth(&problem, machine, watch)?;
        Ok(above(&refused, Some(growth), &ended, ABOVE))
    }

    /// How the mode grows in a step of `problem`, over few steps.
    fn growth(
        &self,
        problem: &Problem,
        machine: &Machine,
        watch: &mut Watch<'_>,
    ) -> Result<f64, Lost> {
        let mut few = super::mode::homogeneous(problem);
        few.initial.clone_from(&self.bounds.mode);
        few.time.end = GROWTH_STEPS * ABOVE * self.bounds.limit;
        few.time.breaks.clear();
        let trial = self.attempt(&few, machine, watch)?;
        let size = |field: &[f64]| field.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        Ok((size(&trial.state) / size(&few.initial)).powf(1.0 / GROWTH_STEPS))
    }

    /// A run that must come to its end.
    fn attempt(
        &self,
        problem: &Problem,
        machine: &Machine,
        watch: &mut Watch<'_>,
    ) -> Result<Trial, Lost> {
        let problem = self.tampering.applied(problem.clone());
        let run = || trial::run(&problem, machine, true, watch);
        let trial = catch_unwind(AssertUnwindSafe(run)).map_err(|_| Lost::Panic)?;
        match trial.map_err(Lost::Error)? {
            Trial { stopped: Some(SolverError::Interrupted { .. }), .. } => Err(Lost::Interrupted),
            Trial { stopped: Some(error), .. } => Err(Lost::Error(error)),
            trial => Ok(trial),
        }
    }
}

/// The same with half the step.
fn half(mut problem: Problem) -> Problem {
    if let StepChoice::Given(step) = &mut problem.time.step {
        *step *= 0.5;
    }
    problem.time.output_every = f64::INFINITY;
    problem
}

/// The figure that decides, and what it says: that of what fails, else the one that tells most.
fn describe(way: Way, checks: &[Check]) -> (String, String) {
    let broken = checks.iter().find(|check| check.is_broken());
    let failing = broken.or_else(|| checks.iter().find(|check| !check.holds));
    let telling = match way {
        Way::EulerSafe | Way::EulerBelow => "leaves the range by",
        Way::EulerAbove => "growth off |1 - dt lambda|",
        Way::Tolerant(_) | Way::Steady | Way::Slow => "error",
    };
    let telling = checks.iter().find(|check| check.what == telling);
    let Some(check) = failing.or(telling).or(checks.first()) else {
        return (String::new(), "nothing was checked".to_owned());
    };
    let figure = check.value.map_or("not finite".to_owned(), |value| significant(value, 2));
    (figure, check.in_words())
}
