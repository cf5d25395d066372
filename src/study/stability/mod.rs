//! Numerical stability: where methods, steps and precisions break, and what holds.
//!
//! | file | what it does |
//! |---|---|
//! | `lattices`, `scenes` | what is looked at: lattices, and extreme scenes |
//! | `mode`, `scan` | the fastest mode, and how it grows with the step |
//! | `way`, `trial` | the ways in which a scene is run, and one run |
//! | `references`, `judge` | what a run should have come to, and what it is held to |

mod judge;
mod lattices;
mod mode;
mod references;
mod scan;
mod scenes;
mod trial;
mod trials;
mod way;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use crate::case::Scene;
use crate::model::{KernelKind, Problem};
use crate::report::run::DIFFUSPH_VERSION;
use crate::report::stability::{
    LeftOutTrial, STABILITY_VERSION, StabilityReport, StepScan, TrialReport, Verdict,
};
use crate::solver::{Machine, SolverError};

use lattices::LatticeKind;
use scan::{Bounds, Known};
use scenes::{ExtremeScene, Length};
use trials::Trials;

/// Places of a scan beside the first, of a lattice and of an extreme scene.
const PLACES: u32 = 28;
const PLACES_FEW: u32 = 14;

/// Safe steps of a case.
const CASE_STEPS: u64 = 200;

/// How long a scene may take in one way.
const PATIENCE: Duration = Duration::from_secs(120);
const PATIENCE_QUICK: Duration = Duration::from_secs(5);

/// Scenes of fewer particles are faster on one thread.
const WORTH_THREADS: usize = 1 << 15;

/// What is looked at.
#[derive(Debug)]
pub struct StabilityOptions<'a> {
    /// A case, instead of lattices and extreme scenes.
    pub scene: Option<&'a Scene>,
    /// Machines beside the CPU, a GPU in several precisions.
    pub machines: Vec<Machine>,
    /// Kernels of the lattices.
    pub kernels: Vec<KernelKind>,
    /// H / dx of the lattices.
    pub support_ratios: Vec<f64>,
    /// Dimensions of the lattices.
    pub dimensions: Vec<usize>,
    /// Whether to leave out what takes long.
    pub quick: bool,
    /// What is done to runs behind the back of the bounds: nothing but in tests.
    pub tampering: Tampering,
    /// The command, for the report.
    pub command: String,
}

/// A fault that tests put into runs, while bounds and references stay right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tampering {
    /// What the kernel's normalisation is multiplied by.
    pub kernel_factor: f64,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityOutcome {
    /// The report, up to where it was stopped.
    pub report: StabilityReport,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
}

/// Where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityProgress {
    /// Parts done.
    pub done: u64,
    /// All parts.
    pub all: u64,
    /// What comes next.
    pub what: String,
}

impl Tampering {
    /// None.
    pub const NONE: Self = Self { kernel_factor: 1.0 };

    /// `problem` with the fault.
    fn applied(self, mut problem: Problem) -> Problem {
        problem.kernel = problem.kernel.with_factor(self.kernel_factor);
        problem
    }
}

impl StabilityOptions<'_> {
    /// The kernels, values of H / dx and dimensions that are taken where none are asked for.
    pub fn default_lattices(quick: bool) -> (Vec<KernelKind>, Vec<f64>, Vec<usize>) {
        let kernels = if quick { vec![KernelKind::CubicSpline] } else { KernelKind::ALL.to_vec() };
        (kernels, if quick { vec![2.0] } else { vec![2.0, 3.0] }, vec![1, 2, 3])
    }
}

/// Scans the step on lattices and takes extreme scenes, or a case, through every method and precision.
/// `progress` is told what comes next, and may stop it.
///
/// # Errors
/// A scene whose bounds cannot be found: a device that fails, walls that make no sense.
pub fn stability(
    options: &StabilityOptions<'_>,
    progress: &mut (dyn FnMut(StabilityProgress) -> ControlFlow<()> + Send),
) -> Result<StabilityOutcome, SolverError> {
    let started = Instant::now();
    let mut study = Study::new(options, progress);
    let interrupted = on_threads(study.largest(), || study.run())?.is_break();
    let mut report = study.report;
    report.wall_s = started.elapsed().as_secs_f64();
    report.broken = broken(&report);
    Ok(StabilityOutcome { report, interrupted })
}

/// Does `work` with scenes of up to `particles` particles on one thread where handing work over to others
/// would take longer than the work.
fn on_threads<T: Send>(particles: usize, work: impl FnOnce() -> T + Send) -> T {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    match one {
        Ok(pool) if particles < WORTH_THREADS => pool.install(work),
        // Slower, and no different.
        _ => work(),
    }
}

/// Promises that did not hold, in words.
fn broken(report: &StabilityReport) -> Vec<String> {
    let of_scans = report.scans.iter().flat_map(|scan: &StepScan| {
        let checks = scan.checks.iter().filter(|check| check.is_broken());
        checks.map(|check| format!("{}: {}", scan.scene, check.in_words()))
    });
    let failed = |trial: &&TrialReport| trial.verdict == Verdict::Fail;
    let of_trials = report.trials.iter().filter(failed).map(|trial| {
        let TrialReport { scene, way, precision, backend, reason, .. } = trial;
        format!("{scene}, {way}, {backend} {precision}: {reason}")
    });
    of_scans.chain(of_trials).collect()
}

struct Study<'a> {
    options: &'a StabilityOptions<'a>,
    progress: &'a mut (dyn FnMut(StabilityProgress) -> ControlFlow<()> + Send),
    lattices: Vec<LatticeKind>,
    scenes: Vec<ExtremeScene>,
    done: u64,
    report: StabilityReport,
}

impl<'a> Study<'a> {
    fn new(
        options: &'a StabilityOptions<'a>,
        progress: &'a mut (dyn FnMut(StabilityProgress) -> ControlFlow<()> + Send),
    ) -> Self {
        let (lattices, scenes) = match options.scene {
            Some(scene) => (Vec::new(), vec![of_case(scene)]),
            None => (lattices::asked_for(options), scenes::all()),
        };
        let adapter = options.machines.iter().find_map(|machine| machine.adapter());
        let report = StabilityReport {
            stability_version: STABILITY_VERSION,
            diffusph_version: DIFFUSPH_VERSION.to_owned(),
            command: options.command.clone(),
            case: options.scene.map(|scene| scene.name.clone()),
            adapter: adapter.map(str::to_owned),
            threads: rayon::current_num_threads(),
            ..StabilityReport::default()
        };
        let mut study = Self { options, progress, lattices, scenes, done: 0, report };
        if options.machines.is_empty() {
            study.leave_out("f32 and compensated", "no GPU was asked for (--backend gpu)");
        }
        study
    }

    /// Particles of the largest scene that is no lattice.
    fn largest(&self) -> usize {
        self.scenes.iter().map(|scene| scene.problem.particles.len()).max().unwrap_or(0)
    }

    fn leave_out(&mut self, what: impl Into<String>, why: &str) {
        let left = LeftOutTrial { what: what.into(), why: why.to_owned() };
        self.report.left_out.push(left);
    }

    fn tell(&mut self, what: &str) -> ControlFlow<()> {
        let machines = 1 + self.options.machines.len();
        let of_scene = 1 + machines * way::Way::ALL.len();
        let all = (self.lattices.len() + of_scene * self.scenes.len()) as u64;
        (self.progress)(StabilityProgress { done: self.done, all, what: what.to_owned() })
    }

    fn run(&mut self) -> Result<ControlFlow<()>, SolverError> {
        for kind in self.lattices.clone() {
            if self.tell(&kind.name()).is_break() {
                return Ok(ControlFlow::Break(()));
            }
            let lattice = kind.build();
            let bounds = Bounds::of(&lattice.problem)?;
            self.scan(lattice.name, &lattice.problem, &bounds, lattice.known, PLACES)?;
        }
        for scene in self.scenes.clone() {
            if self.tell(&scene.name).is_break() {
                return Ok(ControlFlow::Break(()));
            }
            let bounds = Bounds::of(&scene.problem)?;
            let places = if self.options.scene.is_some() { PLACES } else { PLACES_FEW };
            self.scan(scene.name.clone(), &scene.problem, &bounds, Known::default(), places)?;
            if self.trials(&scene, &bounds).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    fn scan(
        &mut self,
        name: String,
        problem: &Problem,
        bounds: &Bounds,
        known: Known,
        places: u32,
    ) -> Result<(), SolverError> {
        let found = scan::scan(name, problem, bounds, known, places, self.options.tampering)?;
        self.report.scans.push(found);
        self.done += 1;
        Ok(())
    }

    /// Every way in every precision.
    fn trials(&mut self, scene: &ExtremeScene, bounds: &Bounds) -> ControlFlow<()> {
        let options = self.options;
        let mut trials = Trials::new(scene, bounds, options.tampering);
        for machine in std::iter::once(&Machine::Cpu).chain(&options.machines) {
            for way in way::Way::ALL {
                let kind = machine.kind();
                let precision = kind.precision().name();
                let what = format!("{}, {}, {precision}", scene.name, way.name());
                if self.tell(&what).is_break() {
                    return ControlFlow::Break(());
                }
                let why = way.why_not(bounds, scene.length);
                let why = why.or_else(|| self.why_too_long(scene, way, machine));
                match why {
                    Some(why) => self.leave_out(what, why),
                    None => {
                        let patience = if options.quick { PATIENCE_QUICK } else { PATIENCE };
                        let (done, progress) = (self.done, &mut *self.progress);
                        let mut ask =
                            || progress(StabilityProgress { done, all: 0, what: what.clone() });
                        match trials.run(way, machine, patience, &mut ask) {
                            Some(trial) => self.report.trials.push(trial),
                            None => return ControlFlow::Break(()),
                        }
                    }
                }
                self.done += 1;
            }
        }
        ControlFlow::Continue(())
    }

    /// Why a way takes longer than is asked for.
    fn why_too_long(
        &self,
        scene: &ExtremeScene,
        way: way::Way,
        machine: &Machine,
    ) -> Option<&'static str> {
        if !self.options.quick {
            return None;
        }
        let is_gpu = matches!(machine, Machine::Gpu { .. });
        let is_long = matches!(scene.length, Length::EqualSteps(_));
        let is_short = way == way::Way::Steady || way == way::Way::EulerSafe && !is_gpu;
        // A linear system that rounding keeps from its goal takes many iterations, between which a run cannot
        // be stopped.
        let is_slow = is_gpu && way.solves();
        (is_long && !is_short || is_slow).then_some("--quick: it takes long")
    }
}

/// A case as a scene that is looked at.
fn of_case(scene: &Scene) -> ExtremeScene {
    ExtremeScene {
        name: scene.name.clone(),
        group: "case",
        problem: scene.problem.clone(),
        length: Length::Steps(CASE_STEPS),
    }
}
