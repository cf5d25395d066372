//! A study: many settings of one case, each run in a process of its own, cheap ones first.

mod analysis;
mod child;
mod default;
mod machine;
mod modes;
mod plan;
mod predict;
mod reference;
mod rounds;
mod split;
mod vary;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::case::{self, CaseError, Override};
use crate::report::StudyReport;
use crate::report::run::DIFFUSPH_VERSION;
use crate::report::study::{Peers, Point, ReferenceLaw, STUDY_VERSION, StudyMachine};

pub use machine::study_machine;
pub use vary::Vary;

use plan::Sweep;
use rounds::Measuring;

/// What is studied, and for how long.
#[derive(Debug)]
pub struct StudyOptions<'a> {
    /// The program that runs the settings: this one.
    pub program: PathBuf,
    /// A case file or the name of a shipped case.
    pub case: &'a str,
    /// Changes of the case in every setting, as `--set` has them.
    pub set: Vec<String>,
    /// Flags of every run and their values.
    pub flags: Vec<(String, String)>,
    /// What is varied; the default of the case where that is nothing.
    pub vary: Vec<Vary>,
    /// How often each setting runs, a warm-up apart.
    pub repeat: usize,
    /// The time allowed.
    pub budget: Duration,
    /// Where it runs.
    pub machine: StudyMachine,
    /// What other programs took.
    pub peers: Option<Peers>,
}

impl<'a> StudyOptions<'a> {
    /// The default study of `case` on the CPU, by this program, in a minute.
    pub fn new(case: &'a str) -> Self {
        let machine = StudyMachine {
            processor: String::new(),
            threads: 1,
            backend: "cpu".to_owned(),
            adapter: None,
        };
        Self {
            program: PathBuf::from("diffusph"),
            case,
            set: Vec::new(),
            flags: Vec::new(),
            vary: Vec::new(),
            repeat: 3,
            budget: Duration::from_secs(60),
            machine,
            peers: None,
        }
    }
}

/// Where a study is.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyProgress {
    /// Runs done or left out.
    pub done: u64,
    /// All runs.
    pub all: u64,
    /// What runs next.
    pub what: String,
}

/// A study that could not be carried out.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The case, or a setting that works with nothing else, is at fault.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// What is varied is not written as it should be.
    #[error("\"{text}\": what is varied is written name=value,value,...")]
    VarySyntax {
        /// The text as given.
        text: String,
    },
    /// A name that stands for nothing.
    #[error(
        "{what}: unknown name \"{text}\"{} (known: {known})",
        .nearest.as_ref().map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_default())]
    UnknownName {
        /// Where it stands.
        what: String,
        /// The name as given.
        text: String,
        /// The known name that looks most like it.
        nearest: Option<String>,
        /// The names that may stand there.
        known: String,
    },
    /// A default sweep of ours that cannot be read.
    #[error("cases/sweeps/{name}.json: {why}")]
    Sweep {
        /// The case.
        name: &'static str,
        /// What is wrong.
        why: String,
    },
    /// No setting can run.
    #[error("no setting of the study can run: no two of the values that are varied go together")]
    Nothing,
    /// No process can be started.
    #[error("cannot start {}: {source}", .program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl StudyError {
    /// Whether the case or the flags are at fault, not the study.
    pub fn is_usage(&self) -> bool {
        !matches!(self, Self::Start { .. } | Self::Sweep { .. })
    }
}

/// Runs every setting, cheap ones first and again as often as the time allows, and says what came of
/// it. `progress` is told what runs next, and may stop it.
///
/// # Errors
/// A case or a value that makes no sense; a process that cannot be started.
pub fn study(
    options: &StudyOptions<'_>,
    progress: &mut dyn FnMut(StudyProgress) -> ControlFlow<()>,
) -> Result<StudyReport, StudyError> {
    let started = Instant::now();
    let overrides = options.set.iter().map(|text| Override::parse(text));
    let scene = case::load(options.case, &overrides.collect::<Result<Vec<_>, _>>()?)?;
    let is_default = options.vary.is_empty();
    let sweeps = match is_default {
        true => default::sweeps(&scene, options)?,
        false => vec![Sweep { vary: options.vary.clone(), ..Sweep::default() }],
    };
    let (case, title) = (scene.name.clone(), scene.title.clone());
    let dimension = scene.problem.dimension;
    drop(scene);
    let mut reference_laws: Vec<ReferenceLaw> = Vec::new();
    for law in sweeps.iter().flat_map(|sweep| &sweep.reference_laws) {
        if !reference_laws.contains(law) {
            reference_laws.push(law.clone());
        }
    }
    let mut remarks = Vec::new();
    let mut measuring = Measuring::new(options, started, progress);
    let trials = measuring.predict(plan::candidates(&sweeps, options), is_default, &mut remarks)?;
    let outcome = measuring.run(trials)?;
    let machine = machine_of(&options.machine, &outcome.points);
    let interrupted = outcome.interrupted;
    let mut report = StudyReport {
        study_version: STUDY_VERSION,
        diffusph_version: DIFFUSPH_VERSION.to_owned(),
        case,
        title,
        dimension,
        machine,
        against: None,
        repeat: options.repeat,
        budget_s: options.budget.as_secs_f64(),
        elapsed_s: 0.0,
        interrupted,
        points: outcome.points,
        skipped: outcome.skipped,
        orders: Vec::new(),
        recommendations: Vec::new(),
        reference_laws,
        peers: options.peers.clone(),
        peers_ahead: Vec::new(),
        remarks,
    };
    reference::compare(&mut report);
    analysis::analyse(&mut report);
    report.elapsed_s = started.elapsed().as_secs_f64();
    Ok(report)
}

/// The machine, with the adapter of the points that had one where it has none itself.
fn machine_of(machine: &StudyMachine, points: &[Point]) -> StudyMachine {
    let used = points.iter().find_map(|point| point.result.as_ref()?.adapter.clone());
    StudyMachine { adapter: machine.adapter.clone().or(used), ..machine.clone() }
}
