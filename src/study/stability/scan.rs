//! How the fastest mode of a scene grows with the step of explicit Euler.

use super::Tampering;
use super::mode::{FastestMode, homogeneous};
use crate::model::integrator::{Method, MethodChoice};
use crate::model::stability::ReportBounds;
use crate::model::{Problem, StepChoice};
use crate::report::stability::{Check, GrowthPoint, StepScan};
use crate::solver::{Backend, Machine, PathChoice, PathWish, SolverError};
use crate::study::prepare::{Driver, Prepared, start};

/// Steps over the limit that are scanned lie between these.
const RANGE: [f64; 2] = [0.2, 3.0];

/// Steps over which growth is measured: at three times the limit 5^8, far from the end of any range.
const STEPS: u64 = 8;

/// The same near the limit.
const STEPS_NEAR: u64 = 16;

/// The limit of the run is looked for this far from the expected one, either way.
const BESIDE: f64 = 0.2;

/// What measured limits may be off.
const LIMIT_OFF: f64 = 5e-3;

/// What rounding may make of a growth of 1.
const ROUNDING: f64 = 1e-6;

/// What a scene has in store for a step of explicit Euler.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    /// The safe bound, s; infinite where nothing limits the step.
    pub(super) safe: f64,
    /// 2 / lambda_max, s; infinite where nothing limits the step.
    pub(super) limit: f64,
    /// Whether the matrix is symmetric.
    pub(super) symmetric: bool,
    /// The most neighbours of a particle, itself included.
    pub(super) neighbors: usize,
    /// The fastest mode, its largest value 1, in the problem's order.
    pub(super) mode: Vec<f64>,
}

impl Bounds {
    /// Those of `problem`.
    pub(super) fn of(problem: &Problem) -> Result<Self, SolverError> {
        let problem = &homogeneous(&by_euler(problem));
        begin(problem, FindMode(problem))?
    }
}

/// The same scene by explicit Euler at the safe bound.
fn by_euler(problem: &Problem) -> Problem {
    let mut problem = problem.clone();
    problem.time.method = MethodChoice::Given(Method::Euler);
    problem.time.step = StepChoice::Automatic;
    problem.time.end = 1.0;
    problem.time.breaks.clear();
    [problem.time.output_every, problem.time.probe_every] = [f64::INFINITY; 2];
    problem
}

fn begin<D: Driver>(problem: &Problem, driver: D) -> Result<D::Output, SolverError> {
    let choice = PathChoice::new(problem, Machine::Cpu.kind(), PathWish::Auto)?;
    start(problem, &Machine::Cpu, choice, true, driver)
}

/// Finds the fastest mode.
struct FindMode<'a>(&'a Problem);

impl Driver for FindMode<'_> {
    type Output = Result<Bounds, SolverError>;

    fn drive<B: Backend + 'static>(self, prepared: Prepared, mut backend: B) -> Self::Output {
        let symmetric = prepared.survey.symmetric;
        let found = match symmetric {
            true => FastestMode::of(&mut backend, self.0)?,
            false => FastestMode::by_power(&mut backend, self.0)?,
        };
        // The state was 0.
        backend.add(&found.mode)?;
        let mut mode = backend.read()?.as_ref().to_vec();
        let largest = mode.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        mode.iter_mut().for_each(|value| *value /= largest);
        let limit = if found.rate > 0.0 { 2.0 / found.rate } else { f64::INFINITY };
        let safe = prepared.step.limits.safe;
        let neighbors = prepared.survey.most_neighbors + 1;
        Ok(Bounds { safe, limit, symmetric, neighbors, mode })
    }
}

/// Growth of the mode at several steps, and where it begins.
struct Grow<'a> {
    bounds: &'a Bounds,
    volume: &'a [f64],
    count: u32,
}

/// What a run of the mode told.
struct Grown {
    points: Vec<GrowthPoint>,
    measured_limit: Option<f64>,
}

impl Driver for Grow<'_> {
    type Output = Result<Grown, SolverError>;

    fn drive<B: Backend + 'static>(self, _prepared: Prepared, mut backend: B) -> Self::Output {
        backend.save()?;
        let start = self.norm(&self.bounds.mode);
        let mut growth = |step: f64, steps: u64| -> Result<f64, SolverError> {
            backend.restore()?;
            backend.euler(0.0, step, steps)?;
            let norm = self.norm(backend.read()?.as_ref());
            Ok((norm / start).powf(1.0 / steps as f64))
        };
        let limit = self.bounds.limit;
        let mut points = Vec::new();
        for number in 0..=self.count {
            let share = f64::from(number) / f64::from(self.count);
            let ratio = RANGE[0] + (RANGE[1] - RANGE[0]) * share;
            let (step_s, steps) = (ratio * limit, STEPS);
            let expected = (1.0 - 2.0 * ratio).abs();
            let growth = growth(step_s, steps)?;
            points.push(GrowthPoint { ratio, step_s, steps, growth, expected });
        }
        let [mut low, mut high] = [limit * (1.0 - BESIDE), limit * (1.0 + BESIDE)];
        let is_between = growth(low, STEPS_NEAR)? < 1.0 && growth(high, STEPS_NEAR)? > 1.0;
        while is_between && high - low > 1e-6 * limit {
            let middle = 0.5 * (low + high);
            if growth(middle, STEPS_NEAR)? > 1.0 { high = middle } else { low = middle }
        }
        Ok(Grown { points, measured_limit: is_between.then_some(0.5 * (low + high)) })
    }
}

impl Grow<'_> {
    /// The norm of a field, sqrt(sum V C^2).
    fn norm(&self, field: &[f64]) -> f64 {
        let terms = field.iter().zip(self.volume).map(|(value, volume)| volume * value * value);
        terms.sum::<f64>().sqrt()
    }
}

/// What is known of the limit beforehand.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    /// From plane waves, s.
    pub(super) waves: Option<f64>,
    /// Published, over dx^2 / D.
    pub(super) published: Option<f64>,
}

/// Scans the step of `problem` from 0.2 to 3 times its limit, at `count` + 1 places.
pub(super) fn scan(
    scene: String,
    problem: &Problem,
    bounds: &Bounds,
    known: Known,
    count: u32,
    tampering: Tampering,
) -> Result<StepScan, SolverError> {
    let unit_s = problem.spacing * problem.spacing / problem.max_diffusivity();
    let report = ReportBounds::of(problem);
    let of_limit = |step: f64| step.is_finite().then_some(step);
    let mut found = StepScan {
        scene,
        is_lattice: known.waves.is_some(),
        dimension: problem.dimension,
        kernel: problem.kernel.kind().name().to_owned(),
        support_ratio: problem.kernel.support_radius() / problem.spacing,
        correction: problem.correction.name().to_owned(),
        particles: problem.particles.len() as u64,
        unit_s,
        cfl_s: report.cfl,
        cfl_third_s: report.cfl_third,
        safe_s: of_limit(bounds.safe),
        limit_s: of_limit(bounds.limit),
        measured_limit_s: None,
        wave_limit_s: known.waves,
        published: known.published,
        points: Vec::new(),
        checks: Vec::new(),
    };
    if bounds.limit.is_finite() {
        let mut runs = tampering.applied(homogeneous(&by_euler(problem)));
        runs.initial.clone_from(&bounds.mode);
        let grow = Grow { bounds, volume: &problem.particles.volume, count };
        let grown = begin(&runs, grow)??;
        found.points = grown.points;
        found.measured_limit_s = grown.measured_limit;
    }
    found.checks = checks(&found, bounds);
    Ok(found)
}

fn checks(scan: &StepScan, bounds: &Bounds) -> Vec<Check> {
    if bounds.limit.is_infinite() {
        // No pairs: whatever the step, nothing changes.
        return vec![Check::that("no pairs, and no bound", bounds.safe.is_infinite(), true)];
    }
    let over = bounds.safe / bounds.limit;
    let mut checks = vec![Check::at_most("safe bound over limit", over, 1.0 + 1e-9, true)];
    let measured = scan.measured_limit_s.unwrap_or(f64::NAN);
    let mut off = |what: &str, limit: f64| {
        checks.push(Check::at_most(what, (measured / limit - 1.0).abs(), LIMIT_OFF, true));
    };
    off("measured limit off 2 / lambda_max", bounds.limit);
    if let Some(waves) = scan.wave_limit_s {
        off("measured limit off that of plane waves", waves);
    }
    if let Some(published) = scan.published {
        off("measured limit off the published one", published * scan.unit_s);
    }
    let upto = scan.points.iter().filter(|point| point.ratio <= 1.0 + 1e-12);
    let largest = upto.map(|point| point.growth).fold(0.0, f64::max);
    checks.push(Check::at_most("growth up to the limit", largest, 1.0 + ROUNDING, true));
    let above = scan.points.iter().filter(|point| point.ratio > 1.0 + 1e-12);
    let grows = above.clone().all(|point| point.growth > 1.0 && point.growth.is_finite());
    checks.push(Check::that("growth above the limit", grows, true));
    checks
}
