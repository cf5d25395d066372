//! The ways in which a scene is run, and for how long.

use super::scan::Bounds;
use super::scenes::{ExtremeScene, Length};
use crate::model::integrator::{Method, MethodChoice, Tolerance};
use crate::model::{Problem, ScalarField, StepChoice};

/// The part of the limit that a step just below it has.
const BELOW: f64 = 0.99;

/// The same of a step above it.
pub(super) const ABOVE: f64 = 1.5;

/// Steps after which a field that doubles in each of them is no number any more, from whatever was in it.
const TO_OVERFLOW: f64 = 2500.0;

/// Times the slowest diffusivity takes over the body that a slow run lasts.
const SLOW: f64 = 0.1;

/// Looks at a run whose steps follow a tolerance.
const LOOKS: f64 = 4.0;

/// A way to run a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Explicit Euler at the safe bound, looked at after every step.
    EulerSafe,
    /// Explicit Euler just below the limit.
    EulerBelow,
    /// Explicit Euler above the limit.
    EulerAbove,
    /// A method at its default tolerance.
    Tolerant(Method),
    /// Straight to the steady state.
    Steady,
    /// The automatic choice, over a time in which the slowest material changes.
    Slow,
}

impl Way {
    /// Every way, in the order of tables.
    pub(super) const ALL: [Self; 8] = [
        Self::EulerSafe,
        Self::EulerBelow,
        Self::EulerAbove,
        Self::Tolerant(Method::Heun),
        Self::Tolerant(Method::Rkl2),
        Self::Tolerant(Method::TrBdf2),
        Self::Steady,
        Self::Slow,
    ];

    /// The name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::EulerSafe => "euler, safe bound",
            Self::EulerBelow => "euler, 0.99 limit",
            Self::EulerAbove => "euler, 1.5 limit",
            Self::Tolerant(method) => method.name(),
            Self::Steady => "steady",
            Self::Slow => "auto, slow time",
        }
    }

    /// Whether it solves linear systems, or may.
    pub(super) fn solves(self) -> bool {
        match self {
            Self::Tolerant(method) => method.is_implicit(),
            Self::Steady | Self::Slow => true,
            Self::EulerSafe | Self::EulerBelow | Self::EulerAbove => false,
        }
    }

    /// Whether the scene has it at all, and if not, why not.
    pub(super) fn why_not(self, bounds: &Bounds, length: Length) -> Option<&'static str> {
        match self {
            Self::EulerBelow | Self::EulerAbove if bounds.limit.is_infinite() => {
                Some("nothing limits the step")
            }
            Self::EulerBelow | Self::EulerAbove if !bounds.symmetric => {
                Some("the matrix is not symmetric: the safe bound counts as the limit")
            }
            Self::EulerBelow | Self::EulerAbove | Self::Slow
                if matches!(length, Length::EqualSteps(_)) =>
            {
                Some("the scene is about equal steps of the safe bound")
            }
            Self::Steady if matches!(length, Length::Jump(_)) => {
                Some("what is imposed changes: there is no steady state")
            }
            Self::Steady if !bounds.symmetric => Some("the matrix is not symmetric"),
            _ => None,
        }
    }

    /// `scene` as it is run in this way.
    pub(super) fn problem(self, scene: &ExtremeScene, bounds: &Bounds) -> Problem {
        let safe = if bounds.safe.is_finite() { bounds.safe } else { slow_time(&scene.problem) };
        let mut problem = scene.problem.clone();
        let time = &mut problem.time;
        time.end = safe * scene.length.steps() as f64;
        time.breaks.clear();
        time.probe_every = f64::INFINITY;
        time.linear_tolerance = None;
        time.method = MethodChoice::Given(self.method());
        (time.step, time.output_every) = match self {
            Self::EulerSafe => (StepChoice::Given(safe), safe),
            Self::EulerBelow => (StepChoice::Given(BELOW * bounds.limit), BELOW * bounds.limit),
            Self::EulerAbove => (StepChoice::Given(ABOVE * bounds.limit), f64::INFINITY),
            Self::Tolerant(_) => (StepChoice::Tolerance(Tolerance::DEFAULT), time.end / LOOKS),
            Self::Steady => (StepChoice::Automatic, f64::INFINITY),
            Self::Slow => (StepChoice::Tolerance(Tolerance::DEFAULT), f64::INFINITY),
        };
        match (self, scene.length) {
            (Self::EulerAbove, _) => time.end = TO_OVERFLOW * ABOVE * bounds.limit,
            (Self::Slow, _) => {
                time.method = MethodChoice::Automatic;
                time.end = slow_time(&scene.problem);
                time.output_every = time.end / LOOKS;
            }
            (Self::Steady, _) | (_, Length::Steps(_) | Length::Jump(_)) => {}
            (_, Length::EqualSteps(_)) => {
                (time.step, time.output_every) = (StepChoice::Given(safe), 0.1 * time.end);
            }
        }
        if matches!(scene.length, Length::Jump(_)) {
            let at = 0.5 * time.end;
            time.breaks = vec![at];
            match problem.sources.first_mut() {
                Some(source) => source.rate = jump(at),
                None => problem.walls[0].condition.imposed = jump(at),
            }
        }
        problem
    }

    fn method(self) -> Method {
        match self {
            Self::EulerSafe | Self::EulerBelow | Self::EulerAbove | Self::Slow => Method::Euler,
            Self::Tolerant(method) => method,
            Self::Steady => Method::Steady,
        }
    }
}

/// `problem` by a method of second order with equal steps that are far smaller than the safe bound: what
/// others are compared with.
pub(super) fn reference(problem: &Problem, safe: f64, finer: f64) -> Problem {
    let mut problem = problem.clone();
    problem.time.method = MethodChoice::Given(Method::Heun);
    problem.time.step = StepChoice::Given(safe / finer);
    problem.time.output_every = f64::INFINITY;
    problem
}

/// `problem` by the implicit method at a tolerance of `relative`.
pub(super) fn implicit_reference(problem: &Problem, relative: f64) -> Problem {
    let mut problem = problem.clone();
    problem.time.method = MethodChoice::Given(Method::TrBdf2);
    problem.time.step = StepChoice::Tolerance(Tolerance { absolute: 0.0, relative });
    problem.time.output_every = f64::INFINITY;
    problem
}

/// A value that jumps from 0 to 1 at `time` (s).
fn jump(time: f64) -> ScalarField {
    ScalarField::new("0, then 1", move |_, t| if t < time { 0.0 } else { 1.0 })
        .depending_on(false, true)
}

/// A time in which the slowest material of a scene changes over its whole length, s.
fn slow_time(problem: &Problem) -> f64 {
    let slowest = problem.particles.material.iter();
    let slowest = slowest.map(|&m| problem.materials[usize::from(m)].diffusivity());
    let length = problem.domain.extent().max_element();
    SLOW * length * length / slowest.fold(f64::INFINITY, f64::min)
}
