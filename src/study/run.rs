//! One run of a scene: set-up, solution, output and report.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use glam::DVec3;

use super::pictures;
use super::prepare::{Driver, Prepared, start};
use super::recorder::Recorder;
use super::stagnated::stagnated;
use crate::case::Scene;
use crate::model::Problem;
use crate::model::integrator::Method;
use crate::model::operator::floating_bodies;
use crate::report::format::simulated_time;
use crate::report::run::{
    Conserved, DIFFUSPH_VERSION, ErrorReport, FieldRange, LeftOut, REPORT_VERSION, Range,
    RunReport, WallTimes,
};
use crate::report::{Norms, OutputError, OutputFolder, total};
use crate::solver::{
    Backend, Machine, Path, PathChoice, PathWish, Progress, SolverError, Stepper, Taken, advance,
};

/// What the user asked of a run beyond the case.
#[derive(Debug)]
pub struct RunOptions<'a> {
    /// Where it runs.
    pub machine: &'a Machine,
    /// Why in the machine's precision, where the scene decided.
    pub why_precision: Option<String>,
    /// Which path it takes.
    pub path: PathWish,
    /// Whether a step above the stability limit may run.
    pub allow_unstable: bool,
    /// Where files go; none are written without it.
    pub folder: Option<&'a OutputFolder>,
    /// When the set-up began, so that reading the case counts.
    pub started: Instant,
}

impl<'a> RunOptions<'a> {
    /// A run on `machine` that starts now, writes no files and refuses an unstable step.
    pub fn new(machine: &'a Machine) -> Self {
        Self {
            machine,
            why_precision: None,
            path: PathWish::Auto,
            allow_unstable: false,
            folder: None,
            started: Instant::now(),
        }
    }
}

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// The report, up to the last good state.
    pub report: RunReport,
    /// The last good state, in the problem's order: an enthalpy where values are not the state.
    pub state: Vec<f64>,
    /// Why the run stopped before its end, if it did.
    pub stopped: Option<SolverError>,
}

/// A run that could not be carried out.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The solver failed.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// No particle is near a probe.
    #[error("probe \"{name}\" at {at}: no particle within the support radius")]
    ProbeInVoid {
        /// The probe's name.
        name: String,
        /// Its position, m.
        at: DVec3,
    },
}

impl RunError {
    /// Whether the case or the flags are at fault, not the run.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Solver(error) => error.is_usage(),
            Self::Output(_) => false,
            Self::ProbeInVoid { .. } => true,
        }
    }
}

/// Runs `scene`. `progress` is told between steps where the run is, and may stop it.
///
/// A run that diverges or is stopped still has an outcome, with the state and files up to its last
/// good step and [`Outcome::stopped`] set.
///
/// # Errors
/// A step above the stability limit, a device that fails, a file that cannot be written.
pub fn run(
    scene: &Scene,
    options: &RunOptions<'_>,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let problem = &scene.problem;
    let machine = options.machine;
    let choice = PathChoice::new(problem, machine.kind(), options.path)?;
    // Nobody has asked for a lattice with stored rows: where a device has no room for those, it has a list in chunks.
    let may_change = options.path == PathWish::Auto && choice.path() == Path::Mixed;
    let solve = Solve { scene, options, progress: &mut *progress };
    match start(problem, machine, choice, options.allow_unstable, solve) {
        Err(error) if may_change && error.is_lack_of_room() => {
            let choice = PathChoice::List(Some("the device has no room for the stored rows"));
            let solve = Solve { scene, options, progress };
            start(problem, machine, choice, options.allow_unstable, solve)?
        }
        done => done?,
    }
}

/// Solves a scene.
struct Solve<'a, 'b> {
    scene: &'a Scene,
    options: &'a RunOptions<'b>,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
}

impl Driver for Solve<'_, '_> {
    type Output = Result<Outcome, RunError>;

    fn drive<B: Backend + 'static>(self, prepared: Prepared, mut backend: B) -> Self::Output {
        let Self { scene, options, progress } = self;
        let setup = &Setup { scene, options, prepared: &prepared };
        let ready = options.started.elapsed();
        let mut recorder = Recorder::start(scene, options.folder, progress)?;
        let first_output = recorder.spent;
        let clock = Instant::now();
        let (problem, step) = (&scene.problem, &prepared.step);
        let precision = options.machine.kind().precision();
        let mut stepper = Stepper::new(&mut backend, problem, step, precision)?;
        let mut taken = Taken::NONE;
        let done = advance(&mut backend, problem, &mut stepper, step.dt, &mut recorder, &mut taken);
        let stopped = match done {
            Ok(()) => None,
            Err(RunError::Solver(error)) if error.leaves_a_state() => {
                taken.steps = error.good_steps();
                Some(error)
            }
            Err(error) => return Err(error),
        };
        if taken.steps == 0 {
            // What it would have been.
            let dt = if step.method == Method::Steady { 0.0 } else { step.taken(problem) };
            taken = Taken { smallest: dt, largest: dt, ..taken };
        }
        let solving = clock.elapsed() + first_output - recorder.spent;
        let measured = Measured {
            ready,
            solving,
            taken,
            applications: stepper.applications(),
            exchange: backend.exchange()?,
            memory_bytes: backend.memory_bytes(),
        };
        drop(backend);
        finish(setup, recorder, &measured, stopped)
    }
}

/// What a run starts from.
struct Setup<'a> {
    scene: &'a Scene,
    options: &'a RunOptions<'a>,
    prepared: &'a Prepared,
}

/// What the run itself told.
struct Measured {
    ready: Duration,
    solving: Duration,
    taken: Taken,
    /// Operator applications.
    applications: u64,
    exchange: f64,
    memory_bytes: u64,
}

/// Compares with the exact solution, writes what is left to write and fills the report.
fn finish(
    setup: &Setup<'_>,
    recorder: Recorder<'_>,
    measured: &Measured,
    stopped: Option<SolverError>,
) -> Result<Outcome, RunError> {
    let clock = Instant::now();
    let exact = recorder.exact();
    let mut report = report(setup, &recorder, exact.as_deref(), measured);
    if let Some(still) = recorder.still {
        let problem = &setup.scene.problem;
        report.warnings.extend(stagnated(problem, &recorder.state, recorder.time, still));
    }
    if let Some(error) = &stopped {
        report.warnings.push(format!("stopped early: {error}"));
    }
    if let Some(folder) = setup.options.folder {
        let is_steady = setup.prepared.step.method == Method::Steady;
        pictures::write(setup.scene, &recorder, exact.as_deref(), folder, is_steady)?;
        folder.write_json("case.json", &setup.scene.resolved)?;
        report.wall_s.output = (recorder.spent + clock.elapsed()).as_secs_f64();
        folder.write_json("report.json", &report)?;
    }
    Ok(Outcome { report, state: recorder.state.into_owned(), stopped })
}

fn report(
    setup: &Setup<'_>,
    recorder: &Recorder<'_>,
    exact: Option<&[f64]>,
    measured: &Measured,
) -> RunReport {
    let problem = &setup.scene.problem;
    let volume = &problem.particles.volume;
    let Prepared { survey, step, plan } = setup.prepared;
    let particles = problem.particles.len() as u64;
    let magnitude: Vec<f64> = problem.initial.iter().map(|value| value.abs()).collect();
    let solve = measured.solving.as_secs_f64();
    let values = recorder.values();
    let capacity = problem.capacities();
    let [initial, last] = [&problem.initial, &*recorder.state].map(|state| total(state, &capacity));
    // No time passes on the way to a steady state: what came in where something holds a value is what the
    // change took. Bodies where nothing does keep what they have.
    let exchange = match step.method {
        Method::Steady if !is_floating(problem) => last - initial,
        _ => measured.exchange,
    };
    let mut warnings = setup.scene.warnings.clone();
    warnings.extend(step.warnings.iter().cloned());
    if step.method == Method::Steady && exact.is_some() {
        let end = simulated_time(problem.time.end);
        warnings.push(format!("the exact solution is that at time.end, {end}"));
    }
    RunReport {
        report_version: REPORT_VERSION,
        case: setup.scene.name.clone(),
        title: setup.scene.title.clone(),
        diffusph_version: DIFFUSPH_VERSION.to_owned(),
        backend: plan.machine.backend_name().to_owned(),
        adapter: setup.options.machine.adapter().map(str::to_owned),
        precision: plan.machine.precision().name().to_owned(),
        dimension: problem.dimension,
        particles,
        path: plan.path.name().to_owned(),
        why_precision: setup.options.why_precision.clone(),
        method: step.method.name().to_owned(),
        why_method: step.why_method.clone(),
        steps: measured.taken.steps,
        steps_refused: measured.taken.refused,
        operator_applications: measured.applications + step.applications,
        dt: measured.taken.smallest,
        dt_largest: measured.taken.largest,
        dt_limit: match step.method.is_limited() {
            true => step.limits.stable(),
            false => f64::INFINITY,
        },
        simulated_s: recorder.time,
        wall_s: WallTimes { setup: measured.ready.as_secs_f64(), solve, output: 0.0 },
        updates_per_s: (particles * measured.applications) as f64 / solve.max(f64::MIN_POSITIVE),
        memory_bytes: measured.memory_bytes,
        field: FieldRange::of(&values),
        conserved: Conserved::new(initial, last, exchange, total(&magnitude, &capacity)),
        front: pictures::front(setup.scene, &recorder.state, recorder.time),
        density: Range { min: survey.min_density, max: survey.max_density },
        error: setup.scene.exact.as_ref().zip(exact).map(|(solution, exact)| {
            ErrorReport::new(solution.name(), Norms::new(&values, exact, volume))
        }),
        probes: recorder.probes(),
        left_out: plan
            .left_out
            .iter()
            .map(|left| LeftOut {
                what: left.what.to_owned(),
                why: left.why.clone(),
                bytes_saved: left.bytes_saved,
            })
            .collect(),
        warnings,
    }
}

/// Whether no body of a scene has its value held anywhere.
fn is_floating(problem: &Problem) -> bool {
    let floating: usize = floating_bodies(problem).iter().map(Vec::len).sum();
    floating == problem.particles.len()
}
