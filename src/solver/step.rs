//! Which method and step a run takes, and whether it may.

use super::SolverError;
use super::method::ChosenMethod;
use super::plan::Path;
use crate::model::integrator::{Method, Schedule, Tolerance};
use crate::model::operator::FoldNeeds;
use crate::model::operator::rows::{Rows, Survey};
use crate::model::stability::{LargestEigenvalue, ReportBounds, largest_eigenvalue, safe_step};
use crate::model::{Problem, StepChoice};

/// The bounds that a step is judged by, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// The report's (116) and (117).
    pub report: ReportBounds,
    /// 1 / max|A_aa|: safe, and keeps the maximum principle.
    pub safe: f64,
    /// 2 / lambda_max, where it was measured.
    pub measured: Option<f64>,
}

/// The method and the steps of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The method.
    pub method: Method,
    /// Why it, where the case leaves it open.
    pub why_method: Option<String>,
    /// The step asked for or chosen, s, the first one where they follow a tolerance. Infinite where
    /// nothing limits it.
    pub dt: f64,
    /// What the steps follow, if they are not equal.
    pub tolerance: Option<Tolerance>,
    /// Whether the matrix is symmetric once scaled by volume.
    pub symmetric: bool,
    /// What it was judged by.
    pub limits: StepLimits,
    /// Operator applications that measuring the limit took.
    pub applications: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl Step {
    /// The smallest of equal steps that is really taken: `dt`, or less so that a whole number of steps
    /// lands on every output (s).
    pub fn taken(&self, problem: &Problem) -> f64 {
        let segments = Schedule::new(&problem.time, self.dt);
        segments.map(|segment| segment.dt).reduce(f64::min).unwrap_or(self.dt)
    }

    /// Vectors that the method holds beside the state, where walls do not change.
    pub fn vectors(&self) -> u64 {
        match self.method {
            Method::Euler => 0,
            Method::Heun | Method::Rkl2 => 4,
            Method::TrBdf2 => 7,
            Method::Steady => 6,
        }
    }

    /// What to say where a given step has to be lowered.
    fn lowered(&self, problem: &Problem) -> Option<String> {
        let taken = self.taken(problem);
        let StepChoice::Given(step) = problem.time.step else { return None };
        (taken < step).then(|| {
            format!(
                "step {step:.6e} s lowered to as little as {taken:.6e} s, so that a whole number of \
                 steps lands on every output"
            )
        })
    }
}

impl StepLimits {
    /// The largest step known to be stable, s: the measured limit if there is one.
    pub fn stable(&self) -> f64 {
        self.measured.unwrap_or(self.safe)
    }
}

/// Chooses the method of `problem` on `path` where the case leaves it open, and its step: the given one,
/// what a tolerance allows, or for explicit Euler the safe bound. A given step of an explicit method of
/// few stages above the safe bound has the true limit measured, and only then; above that it is refused
/// unless `allow_unstable`. The measurement needs a symmetric matrix: of another, the safe bound counts as
/// the limit.
///
/// # Errors
/// [`SolverError::UnstableStep`]; [`SolverError::NotSymmetric`]; [`SolverError::NeverSteady`]; [`SolverError::SteadyOfCurves`].
pub fn choose_step(
    problem: &Problem,
    path: Path,
    survey: &Survey,
    allow_unstable: bool,
    measure: impl FnOnce() -> LargestEigenvalue,
) -> Result<Step, SolverError> {
    // Potentials may change faster than the state: what the matrix allows is for them.
    let slope = problem.largest_slope();
    let rate_bound = slope * survey.rate_bound;
    let safe = safe_step(rate_bound);
    let limits = StepLimits { report: ReportBounds::of(problem), safe, measured: None };
    let ChosenMethod { method, why } =
        ChosenMethod::of(problem, path, 2.0 * rate_bound, survey.symmetric);
    if method.is_implicit() && !survey.symmetric {
        return Err(SolverError::NotSymmetric { method: method.name() });
    }
    if method == Method::Steady && FoldNeeds::of(problem) == FoldNeeds::Changing {
        return Err(SolverError::NeverSteady);
    }
    if method == Method::Steady && !problem.has_one_curve() {
        return Err(SolverError::SteadyOfCurves);
    }
    let (dt, tolerance) = match problem.time.step {
        StepChoice::Given(step) => (step, None),
        StepChoice::Tolerance(tolerance) => (safe, Some(tolerance)),
        StepChoice::Automatic => (safe, method.has_estimate().then_some(Tolerance::DEFAULT)),
    };
    let mut step = Step {
        method,
        why_method: why,
        dt,
        tolerance,
        symmetric: survey.symmetric,
        limits,
        applications: 0,
        warnings: Vec::new(),
    };
    if tolerance.is_some() || method == Method::Steady {
        return Ok(step);
    }
    step.warnings.extend(step.lowered(problem));
    // The bound carries the rounding of a sum over the neighbours.
    if !method.is_limited() || dt <= safe * (1.0 + 1e-12) || problem.time.end == 0.0 {
        return Ok(step);
    }
    let limit = if survey.symmetric {
        let found = measure();
        step.applications = found.applications;
        // Where everything grows, no step is too long for what decays.
        let limit = if found.bound > 0.0 { 2.0 / (slope * found.bound) } else { f64::INFINITY };
        *step.limits.measured.insert(limit)
    } else {
        safe
    };
    if dt > limit && !allow_unstable {
        return Err(SolverError::UnstableStep { step: dt, limit });
    }
    let verdict = if dt > limit {
        format!("{:.3} times ABOVE the limit {limit:.6e} s: it will grow", dt / limit)
    } else {
        format!(
            "{:.1} % below the measured limit {limit:.6e} s; values may leave the initial range",
            100.0 * (1.0 - dt / limit)
        )
    };
    step.warnings.push(format!(
        "step {dt:.6e} s is {:.3} times the safe bound {safe:.6e} s and {verdict}",
        dt / safe
    ));
    Ok(step)
}

/// Measures the largest eigenvalue of the assembled matrix of `problem`; `order` is the grid's.
pub fn measure_limit(problem: &Problem, order: &[u32], rows: &Rows) -> LargestEigenvalue {
    let volume: Vec<f64> = order.iter().map(|&p| problem.capacity(p as usize)).collect();
    largest_eigenvalue(rows, &volume)
}
