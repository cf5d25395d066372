//! The steps of a run, cut at the times where something is written.

use crate::model::TimePlan;

/// Times closer than this fraction of the duration are one.
const SAME_TIME: f64 = 1e-9;

/// How far from a time at which something changes at once (of that time) what is imposed before it and
/// after it are told apart.
const BESIDE: f64 = 1e-12;

/// Equal steps up to a time where something is written or changes at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where it starts, s: just after a time at which something changes at once.
    pub start: f64,
    /// Where it ends, s; its steps end just before that where something changes at once.
    pub end: f64,
    /// Step, s: the scene's step, or less so that a whole number of steps ends at `end`.
    pub dt: f64,
    /// Number of steps.
    pub steps: u64,
    /// Whether the fields are written at its end.
    pub output: bool,
    /// Whether the probes are recorded at its end.
    pub probe: bool,
    /// Whether something changes at once at its end.
    pub is_break: bool,
}

/// The segments of a run, in order of time.
#[derive(Clone, Debug)]
pub struct Schedule {
    end: f64,
    step: f64,
    output_every: f64,
    probe_every: f64,
    time: f64,
    outputs: u64,
    probes: u64,
    /// Times at which something changes at once, s, the latest first.
    breaks: Vec<f64>,
}

impl Schedule {
    /// The run of `plan` with steps of at most `step` (s).
    pub fn new(plan: &TimePlan, step: f64) -> Self {
        Self {
            end: plan.end,
            step,
            output_every: plan.output_every,
            probe_every: plan.probe_every,
            time: 0.0,
            outputs: 0,
            probes: 0,
            breaks: plan.breaks.iter().rev().copied().collect(),
        }
    }

    /// Steps of the whole run.
    pub fn total_steps(&self) -> u64 {
        self.clone().map(|segment| segment.steps).sum()
    }
}

impl Iterator for Schedule {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        let same = SAME_TIME * self.end;
        if self.time >= self.end {
            return None;
        }
        let next_output = (self.outputs + 1) as f64 * self.output_every;
        let next_probe = (self.probes + 1) as f64 * self.probe_every;
        while self.breaks.pop_if(|time| *time <= self.time + same).is_some() {}
        let next_break = self.breaks.last().copied().unwrap_or(f64::INFINITY);
        let mut end = next_output.min(next_probe).min(next_break);
        if end > self.end - same {
            end = self.end;
        }
        let last = end == self.end;
        let output = last || next_output <= end + same;
        let probe = last || next_probe <= end + same;
        let is_break = !last && next_break <= end + same;
        // An output within rounding of it is at the same time.
        let end = if is_break { next_break } else { end };
        self.outputs += u64::from(output);
        self.probes += u64::from(probe);
        let (start, last_time) = (self.time, if is_break { end * (1.0 - BESIDE) } else { end });
        let steps = ((end - self.time) / self.step * (1.0 - SAME_TIME)).ceil().max(1.0);
        let exact = (last_time - start) / steps;
        // The step as given where it fits: (end - time) / steps may differ from it by rounding.
        let fits = !is_break
            && self.step.is_finite()
            && (exact - self.step).abs() <= SAME_TIME * self.step;
        let dt = if fits { self.step } else { exact };
        self.time = if is_break { end * (1.0 + BESIDE) } else { end };
        Some(Segment { start, end, dt, steps: steps as u64, output, probe, is_break })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::StepChoice;
    use crate::model::integrator::{Method, MethodChoice, Preconditioner};

    fn plan(end: f64, output_every: f64, probe_every: f64) -> TimePlan {
        let step = StepChoice::Automatic;
        let method = MethodChoice::Given(Method::Euler);
        let breaks = vec![];
        TimePlan {
            end,
            step,
            method,
            breaks,
            linear_tolerance: None,
            preconditioner: Preconditioner::TwoLevel,
            output_every,
            probe_every,
        }
    }

    #[test]
    fn a_fitting_step_is_kept_to_the_bit() {
        let segments: Vec<_> =
            Schedule::new(&plan(63_072_000.0, 63_072_000.0, 6_307_200.0), 225.0).collect();
        assert_eq!(segments.len(), 10);
        assert!(segments.iter().all(|s| s.dt == 225.0 && s.steps == 28_032 && s.probe));
        assert_eq!(segments.iter().filter(|s| s.output).count(), 1);
    }

    #[test]
    fn a_step_that_does_not_fit_is_lowered_never_raised() {
        let segments: Vec<_> = Schedule::new(&plan(1.0, 0.4, 1.0), 0.15).collect();
        assert_eq!(segments.iter().map(|s| s.steps).collect::<Vec<_>>(), [3, 3, 2]);
        assert!(segments.iter().all(|s| s.dt <= 0.15));
        assert_eq!(segments.last().map(|s| s.end), Some(1.0));
        let time: f64 = segments.iter().map(|s| s.dt * s.steps as f64).sum();
        assert!((time - 1.0).abs() < 1e-15);
    }

    #[test]
    fn no_duration_has_no_steps_and_an_unlimited_step_has_one() {
        assert_eq!(Schedule::new(&plan(0.0, 1.0, 1.0), 0.1).total_steps(), 0);
        let segments: Vec<_> = Schedule::new(&plan(3.0, 3.0, 3.0), f64::INFINITY).collect();
        assert_eq!(segments.iter().map(|s| (s.steps, s.dt)).collect::<Vec<_>>(), [(1, 3.0)]);
    }

    #[test]
    fn a_step_ends_where_something_changes() {
        let mut plan = plan(1.0, 0.5, 1.0);
        plan.breaks = vec![0.0, 0.3, 0.5, 2.0];
        let segments: Vec<_> = Schedule::new(&plan, 1.0).collect();
        let ends: Vec<_> = segments.iter().map(|s| (s.end, s.output, s.is_break)).collect();
        assert_eq!(ends, [(0.3, false, true), (0.5, true, true), (1.0, true, false)]);
    }

    #[test]
    fn outputs_and_probes_that_coincide_are_one_segment() {
        let segments: Vec<_> = Schedule::new(&plan(0.9, 0.3, 0.1), 0.05).collect();
        assert_eq!(segments.len(), 9);
        assert_eq!(segments.iter().filter(|s| s.output).count(), 3);
    }
}
