//! What a run that stands still is short of.

use super::prepare::{Driver, Prepared, start};
use crate::model::operator::FoldNeeds;
use crate::model::{Problem, StepChoice};
use crate::solver::{
    Backend, Machine, MachineKind, PathChoice, PathWish, SolverError, Still, slowest_rates,
};

/// How far off a field may stand still without a word, of its largest value: a few times what its
/// values are rounded by.
const UNSAID: f64 = 8.0 * f32::EPSILON as f64;

/// Steps in f64 after which what rounding has left of noise between neighbours is gone, and what
/// still changes is what the run has missed.
const SMOOTHING: u64 = 100;

/// The most particles whose rates are evaluated by list, which takes some 400 bytes a particle.
const MOST_BY_LIST: usize = 5_000_000;

/// The largest rate once noise is gone.
struct Largest {
    time: f64,
}

impl Driver for Largest {
    type Output = Result<f64, SolverError>;

    fn drive<B: Backend + 'static>(self, prepared: Prepared, mut backend: B) -> Self::Output {
        if prepared.step.dt.is_finite() {
            backend.euler(self.time, prepared.step.dt, SMOOTHING)?;
        }
        let rate = backend.rate(self.time)?;
        Ok(rate.as_ref().iter().fold(0.0, |largest: f64, rate| largest.max(rate.abs())))
    }
}

/// What to say of a run whose field `state` stands still at its `end` (s), if that is no steady state:
/// its rate is evaluated in f64, and what that would change in the time that was left is missing, or,
/// where walls and sources impose nothing, in the time in which a wave over the body decays, if that is shorter.
pub(super) fn stagnated(
    problem: &Problem,
    state: &[f64],
    end: f64,
    still: Still,
) -> Option<String> {
    let seen = format!(
        "stands still: no look after step {} (t = {:.6e} s) has seen a value change",
        still.step, still.time
    );
    let largest = match largest_rate(problem, state, end) {
        Ok(Some(largest)) => largest,
        Ok(None) => return Some(format!("{seen}; the scene is too large to say what is missing")),
        Err(error) => return Some(format!("{seen}; what is missing is not known: {error}")),
    };
    let left = end - still.time;
    let [slowest, _] = slowest_rates(problem);
    let is_driven = FoldNeeds::of(problem) >= FoldNeeds::Steady;
    let missing = largest * if is_driven { left } else { left.min(1.0 / slowest) };
    let values = state.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    (missing > UNSAID * values).then(|| {
        format!(
            "{seen}, though in f64 the field still changes by up to {largest:.1e} a second: about \
             {missing:.1e} is missing"
        )
    })
}

/// The largest rate of change in f64 of a field at a time, 1/s x its unit; `None` of one that is too
/// large.
fn largest_rate(problem: &Problem, state: &[f64], time: f64) -> Result<Option<f64>, SolverError> {
    let choice = PathChoice::new(problem, MachineKind::Cpu, PathWish::Auto)?;
    if matches!(choice, PathChoice::List(_)) && problem.particles.len() > MOST_BY_LIST {
        return Ok(None);
    }
    let mut again = problem.clone();
    again.initial = state.to_vec();
    // Another step than that of the run: the largest that is stable.
    again.time.step = StepChoice::Automatic;
    start(&again, &Machine::Cpu, choice, false, Largest { time })?.map(Some)
}
