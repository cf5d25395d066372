//! What rounding would take from a run in f32, up to standing still short of its end.
//!
//! A value C in f32 stays what it is where a step adds less than half a unit in its last place,
//! ulp(C) / 2. A wave that is on its way to the steady state decays as exp(-lambda t), with lambda =
//! pi^2 D / L^2 for one over a length L: after a time T a step adds dt lambda exp(-lambda T) of the
//! field's range. Where that is less than ulp(C) / 2 the field stands still before the end of the
//! run, while it is still off by (ulp(C) / 2) / (dt lambda).
//!
//! A field that still moves loses too: a step takes up to ulp(C) / 2 from each value, and since
//! values of consecutive steps round alike the losses add up, to no more than ulp(C) / 2 times the
//! number of steps or 1 / (dt lambda), whichever is smaller. Measured on a line of 100 particles that
//! fills from its ends, a quarter of that was lost after 28 032 steps.

use crate::model::integrator::Schedule;
use crate::model::operator::FoldNeeds;
use crate::model::stability::ReportBounds;
use crate::model::{Problem, StepChoice};

/// Units in the last place of f32, relative to the power of two at or below a value.
const ULP: f64 = f32::EPSILON as f64;

/// What a run in f32 may lose and still be called good, of the range of its field: less than the
/// operator's own error at most spacings.
const NEGLIGIBLE: f64 = 1e-4;

/// What is foreseen of a run in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Foreseen {
    /// Every step adds more than f32 loses, and what it loses stays negligible.
    Good,
    /// Every step adds more than f32 loses, but what it loses may add up to this, in the unit of the
    /// field.
    Loses(f64),
    /// The field stands still before the end of the run.
    StandsStill(Stagnation),
    /// Walls or surfaces impose something: what they add may be less than f32 keeps, and no estimate
    /// knows it.
    Driven,
}

/// What steps add, and what f32 keeps of it: an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stagnation {
    /// The least that a step has to add by the end of the run, in the unit of the field.
    pub increment: f64,
    /// Half a unit in the last place of the largest value.
    pub half_ulp: f64,
    /// How far off the field stands still, in the unit of the field.
    pub error: f64,
}

impl Foreseen {
    /// What is foreseen of a run of `problem` in f32.
    ///
    /// The range of the field is that of its initial values, among which held ones are. L is the
    /// length of the body, or twice that, as where only one of its ends is held, and D the smallest
    /// diffusivity or the largest: of these waves the one counts that stands still furthest off. The
    /// step is the smallest that the schedule takes; where the case gives none, the report's (117),
    /// which is shorter than what will be taken.
    pub fn of(problem: &Problem) -> Self {
        if problem.time.end <= 0.0 {
            return Self::Good;
        }
        if FoldNeeds::of(problem) >= FoldNeeds::Steady {
            return Self::Driven;
        }
        let of_values = |start: f64, join: fn(f64, f64) -> f64| {
            problem.initial.iter().copied().fold(start, join)
        };
        let (low, high) = (of_values(f64::INFINITY, f64::min), of_values(-f64::INFINITY, f64::max));
        let (range, largest) = (high - low, low.abs().max(high.abs()));
        let step = step(problem);
        if !(range > 0.0 && step > 0.0) {
            return Self::Good;
        }
        let half_ulp = 0.5 * ULP * largest.log2().floor().exp2();
        let wave = |rate: f64| {
            let increment = range * step * rate * (-rate * problem.time.end).exp();
            Stagnation { increment, half_ulp, error: half_ulp / (step * rate) }
        };
        let rates = slowest_rates(problem);
        let waves = rates.iter().flat_map(|&rate| [rate, rate / 4.0]).map(wave);
        let still = waves.filter(|wave| wave.increment < wave.half_ulp);
        let worst = still.max_by(|a, b| a.error.total_cmp(&b.error));
        if let Some(stagnation) = worst {
            return Self::StandsStill(stagnation);
        }
        let slowest = 0.25 * rates[0].min(rates[1]);
        let lost = half_ulp * (problem.time.end / step).min(1.0 / (step * slowest));
        if lost > NEGLIGIBLE * range { Self::Loses(lost) } else { Self::Good }
    }

    /// What f32 would do to the run, in words; `None` where it does no harm.
    pub fn harm(&self) -> Option<String> {
        match self {
            Self::Good => None,
            Self::Loses(lost) => {
                Some(format!("in f32 the rounding of the steps may add up to {lost:.1e}"))
            }
            Self::StandsStill(Stagnation { increment, half_ulp, error }) => Some(format!(
                "in f32 steps add as little as {increment:.1e}, of which all below {half_ulp:.1e} \
                 is lost: the field would stand still about {error:.1e} short of its end"
            )),
            Self::Driven => {
                Some("f32 may lose what walls, surfaces or sources add in a step".to_owned())
            }
        }
    }
}

/// The smallest step of a run, s, or a shorter one where the case leaves it open.
fn step(problem: &Problem) -> f64 {
    let given = match problem.time.step {
        StepChoice::Given(step) => step,
        StepChoice::Automatic | StepChoice::Tolerance(_) => ReportBounds::of(problem).cfl_third,
    };
    let segments = Schedule::new(&problem.time, given);
    segments.map(|segment| segment.dt).fold(given, f64::min)
}

/// pi^2 D / L^2, 1/s, of the smallest and the largest diffusivity, where L is the largest extent of
/// the domain, of which one that is periodic counts half.
pub fn slowest_rates(problem: &Problem) -> [f64; 2] {
    let of_material = |&m: &u16| problem.materials[usize::from(m)].diffusivity;
    let diffusivity = || problem.particles.material.iter().map(of_material);
    let extent = problem.domain.extent();
    let length = |axis: usize| match problem.domain.periodic[axis] {
        true => 0.5 * extent[axis],
        false => extent[axis],
    };
    let longest = (0..problem.dimension).map(length).fold(0.0, f64::max);
    let rate = |diffusivity: f64| diffusivity * (std::f64::consts::PI / longest).powi(2);
    [rate(diffusivity().fold(f64::INFINITY, f64::min)), rate(diffusivity().fold(0.0, f64::max))]
}
