//! The runs of a study: one of each setting, cheap ones first, then again while there is time.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::child::{self, Ended};
use super::plan::{self, Candidate};
use super::predict::{Predicted, Rates, predict};
use super::split::Space;
use super::{StudyError, StudyOptions, StudyProgress};
use crate::report::RunReport;
use crate::report::format::wall_time;
use crate::report::study::{Measured, Point, Skipped, Split, Spread, TimedRun, label};

/// A first run as short as this (s) warms up, and does not count where others follow.
const WARM_UP: f64 = 1.0;

/// A setting with what is known of it.
pub(super) struct Trial {
    candidate: Candidate,
    predicted: Predicted,
    label: String,
    runs: Vec<TimedRun>,
    report: Option<Box<RunReport>>,
    split: Option<Result<Split, String>>,
    failure: Option<String>,
    skipped: Option<(f64, String)>,
}

/// What came of all runs.
pub(super) struct Runs {
    pub(super) points: Vec<Point>,
    pub(super) skipped: Vec<Skipped>,
    pub(super) interrupted: bool,
}

/// Runs the settings of a study.
pub(super) struct Measuring<'a, 'b> {
    options: &'a StudyOptions<'b>,
    started: Instant,
    progress: &'a mut dyn FnMut(StudyProgress) -> ControlFlow<()>,
    rates: Rates,
    done: u64,
    all: u64,
    interrupted: bool,
    spaces: Spaces,
}

/// The splits up to the steps, by scene: settings that differ in their steps share one.
type Spaces = HashMap<String, Result<Space, String>>;

impl<'a, 'b> Measuring<'a, 'b> {
    pub(super) fn new(
        options: &'a StudyOptions<'b>,
        started: Instant,
        progress: &'a mut dyn FnMut(StudyProgress) -> ControlFlow<()>,
    ) -> Self {
        Self {
            options,
            started,
            progress,
            rates: Rates::default(),
            done: 0,
            all: 0,
            interrupted: false,
            spaces: Spaces::new(),
        }
    }

    /// The settings with what they are expected to take, the cheapest first. Of a default study, what
    /// does not suit the case is left out.
    pub(super) fn predict(
        &mut self,
        candidates: Vec<Candidate>,
        is_default: bool,
        remarks: &mut Vec<String>,
    ) -> Result<Vec<Trial>, StudyError> {
        let mut predicted = Vec::new();
        let mut loaded = Vec::new();
        for candidate in &candidates {
            if self.tell("reading the settings".to_owned()).is_break() {
                self.interrupted = true;
                break;
            }
            let scene = candidate.load(self.options.case);
            predicted.push(scene.as_ref().ok().map(|scene| {
                let backend = candidate.flag("backend").unwrap_or("cpu");
                predict(&scene.problem, candidate.flag("path"), backend)
            }));
            loaded.push(scene.map(|_| ()));
        }
        let faults = if is_default || self.interrupted {
            let of =
                |result: Result<(), _>| result.err().map(|e: crate::case::CaseError| e.to_string());
            loaded.into_iter().map(of).collect()
        } else {
            plan::check(&candidates, loaded)?
        };
        let unsuited = faults.iter().flatten().count();
        if is_default && unsuited == faults.len() && !self.interrupted {
            return Err(StudyError::Nothing);
        }
        if is_default && unsuited > 0 {
            remarks.push(format!("{unsuited} settings of the default sweep do not suit the case"));
        }
        let mut trials = Vec::new();
        for ((candidate, predicted), failure) in candidates.into_iter().zip(predicted).zip(faults) {
            if is_default && failure.is_some() {
                continue;
            }
            let none =
                || Predicted { particles: 0, spacing: f64::NAN, kind: String::new(), seconds: 0.0 };
            let predicted = predicted.unwrap_or_else(none);
            let label = label(&candidate.settings, predicted.spacing);
            trials.push(Trial {
                candidate,
                predicted,
                label,
                runs: Vec::new(),
                report: None,
                split: None,
                failure,
                skipped: None,
            });
        }
        trials.sort_by(|a, b| a.predicted.seconds.total_cmp(&b.predicted.seconds));
        Ok(trials)
    }

    /// Runs them, and splits their errors.
    pub(super) fn run(mut self, mut trials: Vec<Trial>) -> Result<Runs, StudyError> {
        self.all = (trials.len() * (1 + self.options.repeat)) as u64;
        for round in 0..=self.options.repeat {
            for trial in &mut trials {
                if !self.interrupted && trial.is_open() && trial.wants(round, self.options.repeat) {
                    self.once(trial)?;
                }
                self.done += 1;
            }
        }
        let mut runs =
            Runs { points: Vec::new(), skipped: Vec::new(), interrupted: self.interrupted };
        for trial in trials {
            self.finish(trial, &mut runs);
        }
        Ok(runs)
    }

    /// One run of a setting, if there is time for it.
    fn once(&mut self, trial: &mut Trial) -> Result<(), StudyError> {
        let expected = match trial.runs.last() {
            Some(run) => run.command_s,
            None => self.rates.expect(&trial.predicted),
        };
        let left = self.left();
        if expected > left.as_secs_f64() {
            // What has run once is good enough.
            if trial.runs.is_empty() {
                let [needs, left] = [expected, left.as_secs_f64()].map(wall_time);
                let why = format!("expected to take {needs}, with {left} of the time allowed left");
                trial.skipped = Some((expected, why));
            }
            return Ok(());
        }
        let deadline = self.started + self.options.budget;
        let arguments = trial.candidate.arguments(self.options.case);
        let what = trial.label.clone();
        let program = self.options.program.clone();
        let ended = child::run(&program, &arguments, deadline, &mut || self.tell(what.clone()))
            .map_err(|source| StudyError::Start { program: program.clone(), source })?;
        match ended {
            Ended::Done(report, took) => {
                let seconds = took.as_secs_f64();
                self.rates.learn(&trial.predicted, seconds);
                let times = report.wall_s;
                trial.runs.push(TimedRun {
                    warm_up: false,
                    setup_s: times.setup,
                    solve_s: times.solve,
                    output_s: times.output,
                    updates_per_s: report.updates_per_s,
                    command_s: seconds,
                });
                // At once, so that it counts as time taken.
                if trial.split.is_none() {
                    trial.split = Some(self.split(&trial.candidate, &report));
                }
                trial.report = Some(report);
            }
            Ended::Failed(why) => trial.failure = Some(why),
            Ended::OutOfTime if trial.runs.is_empty() => {
                let why = "stopped, since the time allowed was over".to_owned();
                trial.skipped = Some((expected, why));
            }
            Ended::OutOfTime => {}
            Ended::Interrupted => self.interrupted = true,
        }
        Ok(())
    }

    /// The time left.
    fn left(&self) -> Duration {
        self.options.budget.saturating_sub(self.started.elapsed())
    }

    fn tell(&mut self, what: String) -> ControlFlow<()> {
        (self.progress)(StudyProgress { done: self.done, all: self.all, what })
    }

    fn finish(&self, mut trial: Trial, runs: &mut Runs) {
        let command = trial.candidate.command(self.options.case);
        if trial.report.is_none() && trial.failure.is_none() {
            let stopped = || (self.rates.expect(&trial.predicted), "stopped before it".to_owned());
            let (expected_s, why) = trial.skipped.take().unwrap_or_else(stopped);
            runs.skipped.push(Skipped { label: trial.label, command, expected_s, why });
            return;
        }
        let result = trial.report.take().zip(trial.split.take());
        let result = result.map(|(report, split)| measured(*report, trial.runs, split));
        runs.points.push(Point {
            number: runs.points.len() + 1,
            settings: trial.candidate.settings,
            label: trial.label,
            command,
            spacing: trial.predicted.spacing,
            particles: trial.predicted.particles,
            result,
            failure: trial.failure,
        });
    }

    /// What the error of a setting consists of, or why that is not known.
    fn split(&mut self, candidate: &Candidate, report: &RunReport) -> Result<Split, String> {
        if report.probes.is_empty() {
            return Err("the case has no probe".to_owned());
        }
        let scene = candidate.load(self.options.case).map_err(|error| error.to_string())?;
        let mut key = scene.resolved.clone();
        for step in ["step", "tolerance", "method", "linear_tolerance", "preconditioner"] {
            if let Some(time) = key["time"].as_object_mut() {
                time.remove(step);
            }
        }
        let key = format!("{} {key}", report.method == "steady");
        let space = self.spaces.entry(key).or_insert_with(|| Space::of(&scene));
        space.as_ref().map(|space| space.with(&report.probes)).map_err(|why| why.clone())
    }
}

impl Trial {
    fn is_open(&self) -> bool {
        self.failure.is_none() && self.skipped.is_none()
    }

    /// Whether it is to run in a round: one more time than asked for where the first only warms up.
    fn wants(&self, round: usize, repeat: usize) -> bool {
        let warms_up = self.runs.first().is_some_and(|run| run.command_s < WARM_UP);
        round < repeat + usize::from(warms_up)
    }
}

/// What came of a setting, from its last report and the times of all its runs.
fn measured(report: RunReport, mut runs: Vec<TimedRun>, split: Result<Split, String>) -> Measured {
    if let [first, _, ..] = &mut runs[..] {
        first.warm_up = first.command_s < WARM_UP;
    }
    let counted =
        |of: fn(&TimedRun) -> f64| Spread::of(runs.iter().filter(|run| !run.warm_up).map(of));
    let [setup_s, solve_s, output_s] =
        [counted(|run| run.setup_s), counted(|run| run.solve_s), counted(|run| run.output_s)];
    let total_s = counted(|run| run.setup_s + run.solve_s);
    let updates_per_s = counted(|run| run.updates_per_s).median;
    let (split, no_split) = match split {
        Ok(split) => (Some(split), None),
        Err(why) => (None, Some(why)),
    };
    Measured {
        backend: report.backend,
        adapter: report.adapter,
        precision: report.precision,
        path: report.path,
        method: report.method,
        steps: report.steps,
        dt: (report.dt.is_finite() && report.dt > 0.0).then_some(report.dt),
        operator_applications: report.operator_applications,
        updates_per_s,
        memory_bytes: report.memory_bytes,
        runs,
        setup_s,
        solve_s,
        output_s,
        total_s,
        error: report.error,
        probes: report.probes,
        split,
        no_split,
        pareto: false,
        warnings: report.warnings,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::example;

    fn run(command_s: f64, solve_s: f64) -> TimedRun {
        let (setup_s, output_s) = (0.1, 0.0);
        TimedRun { warm_up: false, setup_s, solve_s, output_s, updates_per_s: 1.0, command_s }
    }

    #[test]
    fn a_short_first_run_warms_up_and_a_long_one_counts() {
        let of = |runs: Vec<TimedRun>| measured(example(), runs, Err(String::new()));
        let short = of(vec![run(0.5, 9.0), run(0.4, 3.0), run(0.4, 1.0), run(0.4, 2.0)]);
        assert_eq!(short.solve_s, Spread { median: 2.0, least: 1.0, greatest: 3.0 });
        assert!((short.total_s.median - 2.1).abs() < 1e-12);
        assert_eq!(short.runs.len(), 4, "every time is kept");
        let long = of(vec![run(5.0, 4.0), run(5.0, 2.0)]);
        assert_eq!(long.solve_s, Spread { median: 3.0, least: 2.0, greatest: 4.0 });
        let only = of(vec![run(0.5, 9.0)]);
        assert_eq!(only.solve_s.median, 9.0, "a single run counts");
    }
}
