//! What a setting is expected to take, before it runs.

use crate::model::integrator::{Method, MethodChoice, Tolerance, rkl2_stages};
use crate::model::lattice::{LatticeScene, for_each_neighbor};
use crate::model::{Problem, StepChoice};

/// Neighbours x particles x applications a second by stencil and by list, on a processor of two
/// cores: what orders the settings. What was measured replaces it (see [`Rates`]).
const BY_STENCIL: f64 = 8e9;
const BY_LIST: f64 = 1e9;

/// Particles a second that are set up, by stencil and by list.
const SET_UP_STENCIL: f64 = 5e6;
const SET_UP_LIST: f64 = 8e5;

/// Starting a process and reading a case, s.
const START: f64 = 0.03;

/// What a stage of the methods other than explicit Euler costs beside an application.
const STAGE: f64 = 1.8;

/// Applications of a steady state, and of a step of `tr_bdf2`, about.
const STEADY: f64 = 150.0;
const IMPLICIT: f64 = 40.0;

/// The cost of a setting before it is measured.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Predicted {
    pub(super) particles: u64,
    pub(super) spacing: f64,
    /// What its rate is like: settings of one kind are compared with each other.
    pub(super) kind: String,
    /// Seconds, at the rates above.
    pub(super) seconds: f64,
}

/// The expected cost of `problem`, along the `path` of the flag, if there is one.
pub(super) fn predict(problem: &Problem, path: Option<&str>, backend: &str) -> Predicted {
    let particles = problem.particles.len() as u64;
    let by_neighbors = path.filter(|path| ["list", "matrix-free"].contains(path));
    let is_stencil = by_neighbors.is_none() && LatticeScene::of(problem).is_ok();
    let (mut neighbors, mut rate_bound) = (0.0_f64, 0.0);
    let volume = problem.spacing.powi(problem.dimension as i32);
    let moment = problem.correction.moment(&problem.kernel, problem.spacing);
    for_each_neighbor(&problem.kernel, problem.spacing, |offset| {
        let dw_over_r = problem.kernel.dw_over_r(offset.length());
        rate_bound -= 2.0 * problem.max_diffusivity() / moment * volume * dw_over_r;
        neighbors += 1.0;
    });
    let (method, work) = work(problem, rate_bound);
    let (rate, set_up) = match is_stencil {
        true => (BY_STENCIL, SET_UP_STENCIL),
        false => (BY_LIST, SET_UP_LIST),
    };
    let count = particles as f64;
    let seconds = START + count / set_up + count * neighbors.max(1.0) * work / rate;
    let path = if is_stencil { "stencil" } else { by_neighbors.unwrap_or("list") };
    Predicted {
        particles,
        spacing: problem.spacing,
        kind: format!("{method} {path} {backend}"),
        seconds,
    }
}

/// The method, and its cost in operator applications; `rate_bound` is max|A_aa|, 1/s.
fn work(problem: &Problem, rate_bound: f64) -> (&'static str, f64) {
    let time = &problem.time;
    let safe = 1.0 / rate_bound.max(f64::MIN_POSITIVE);
    let tolerance = match time.step {
        StepChoice::Tolerance(tolerance) => tolerance.relative.max(1e-12),
        StepChoice::Automatic | StepChoice::Given(_) => Tolerance::DEFAULT.relative,
    };
    let accurate = (0.5 / tolerance.sqrt()).max(16.0);
    let steps = |else_steps: f64| match time.step {
        StepChoice::Given(step) => (time.end / step).ceil(),
        _ => else_steps,
    };
    let reach = 2.0 * rate_bound * time.end;
    let heun = 2.0 * STAGE * steps(accurate.max(0.5 * reach));
    let supersteps = steps(accurate);
    let rkl2 = STAGE * supersteps * rkl2_stages(reach / supersteps.max(1.0)) as f64;
    let implicit = IMPLICIT * steps(0.4 * accurate);
    match time.method {
        MethodChoice::Given(Method::Euler) => ("euler", steps(time.end / safe)),
        MethodChoice::Given(Method::Heun) => ("heun", heun),
        MethodChoice::Given(Method::Rkl2) => ("rkl2", rkl2),
        MethodChoice::Given(Method::TrBdf2) => ("tr_bdf2", implicit),
        MethodChoice::Given(Method::Steady) => ("steady", STEADY),
        MethodChoice::Automatic => ("auto", heun.min(rkl2).min(implicit)),
    }
}

/// What predictions were worth: measured over predicted seconds, by kind.
#[derive(Debug, Default)]
pub(super) struct Rates(Vec<(String, f64)>);

impl Rates {
    /// Takes note of what a setting took (s).
    pub(super) fn learn(&mut self, predicted: &Predicted, seconds: f64) {
        self.0.retain(|(kind, _)| *kind != predicted.kind);
        self.0.push((predicted.kind.clone(), seconds / predicted.seconds));
    }

    /// What a setting is expected to take, s: by the last one of its kind, or by the slowest of the
    /// other kinds, or as predicted.
    pub(super) fn expect(&self, predicted: &Predicted) -> f64 {
        let own = self.0.iter().find(|(kind, _)| *kind == predicted.kind).map(|(_, ratio)| *ratio);
        let slowest = self.0.iter().map(|(_, ratio)| *ratio).reduce(f64::max);
        predicted.seconds * own.or(slowest).unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{self, Override};

    fn of(set: &[&str]) -> Predicted {
        let overrides: Vec<Override> =
            set.iter().map(|text| Override::parse(text).expect("an override")).collect();
        let scene = case::load("gaussian_small", &overrides).expect("a case");
        predict(&scene.problem, None, "cpu")
    }

    #[test]
    fn finer_and_more_applications_cost_more() {
        let cheap = of(&[]);
        assert_eq!((cheap.particles, cheap.kind.as_str()), (13_824, "euler stencil cpu"));
        assert!(of(&["particles.spacing=1"]).seconds > 2.0 * cheap.seconds);
        assert!(of(&["time.step=46720"]).seconds > 2.0 * cheap.seconds);
        assert!(of(&["time.method=heun"]).seconds > cheap.seconds);
        // The safe bound at spacing 2 m is 4^2 times that at 0.5 m, 119 093 s: 34 steps.
        let automatic = of(&["time.step=null"]);
        assert!(automatic.seconds < cheap.seconds);
    }

    #[test]
    fn what_was_measured_replaces_what_was_predicted() {
        let predicted = of(&[]);
        let mut rates = Rates::default();
        assert_eq!(rates.expect(&predicted), predicted.seconds);
        rates.learn(&predicted, 3.0 * predicted.seconds);
        assert!((rates.expect(&predicted) / predicted.seconds - 3.0).abs() < 1e-12);
        let other = of(&["time.method=heun"]);
        assert!((rates.expect(&other) / other.seconds - 3.0).abs() < 1e-12, "by another kind");
        rates.learn(&other, other.seconds);
        assert!((rates.expect(&other) / other.seconds - 1.0).abs() < 1e-12);
    }
}
