//! The report on numerical stability, as data: what held and what broke.

mod growth;
mod heat;
mod page;
mod table;

use serde::{Deserialize, Serialize};

/// Version of the report's layout; raised whenever a name or a meaning changes.
pub const STABILITY_VERSION: u32 = 1;

/// Where the method and the step of a run are at their limits. Units are SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StabilityReport {
    /// [`STABILITY_VERSION`].
    pub stability_version: u32,
    /// [`crate::report::run::DIFFUSPH_VERSION`].
    pub diffusph_version: String,
    /// The command that made it.
    pub command: String,
    /// The case, where one was asked for.
    pub case: Option<String>,
    /// The GPU's name; `null` where only the CPU was used.
    pub adapter: Option<String>,
    /// Threads of the CPU.
    pub threads: usize,
    /// How long it took, s.
    pub wall_s: f64,
    /// Growth over the step, one entry a scene.
    pub scans: Vec<StepScan>,
    /// Scenes in every method and precision.
    pub trials: Vec<TrialReport>,
    /// What was left out, and why.
    pub left_out: Vec<LeftOutTrial>,
    /// Promises of the documentation that did not hold. Empty where all is well.
    pub broken: Vec<String>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Growth of the fastest mode over the step of explicit Euler.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepScan {
    /// What is scanned.
    pub scene: String,
    /// Whether it is a plain lattice or one of the extreme scenes.
    pub is_lattice: bool,
    /// 1, 2 or 3.
    pub dimension: usize,
    /// The kernel's name.
    pub kernel: String,
    /// H / dx.
    pub support_ratio: f64,
    /// `none` (the plain operator) or `moment`.
    pub correction: String,
    /// How many particles.
    pub particles: u64,
    /// dx^2 / D of the largest diffusivity, s: what limits are compared in.
    pub unit_s: f64,
    /// The report's (116), s.
    pub cfl_s: f64,
    /// The report's (117), s.
    pub cfl_third_s: f64,
    /// The safe bound 1 / max|A_aa|, s; `null` where nothing limits the step.
    pub safe_s: Option<f64>,
    /// The limit 2 / lambda_max by a Lanczos iteration, s; `null` where nothing limits the step, or the
    /// matrix is not symmetric.
    pub limit_s: Option<f64>,
    /// The step at which the run begins to grow, s: found by runs alone.
    pub measured_limit_s: Option<f64>,
    /// The limit from the plane waves of the lattice, s, where the scene is one.
    pub wave_limit_s: Option<f64>,
    /// The published limit over dx^2 / D, where there is one.
    pub published: Option<f64>,
    /// Growth a step, by step.
    pub points: Vec<GrowthPoint>,
    /// What was checked.
    pub checks: Vec<Check>,
}

/// Growth at a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrowthPoint {
    /// The step over the limit.
    pub ratio: f64,
    /// The step, s.
    pub step_s: f64,
    /// Steps over which the growth was measured.
    pub steps: u64,
    /// The factor by which the norm of the field grows in a step.
    pub growth: f64,
    /// |1 - dt lambda_max|.
    pub expected: f64,
}

/// Something that was measured, with what it is held to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What.
    pub what: String,
    /// The figure; `null` where it is not finite.
    pub value: Option<f64>,
    /// What it must not exceed.
    pub limit: f64,
    /// Whether it does not.
    pub holds: bool,
    /// Whether the documentation promises it.
    pub promised: bool,
}

/// What became of a scene in a method and a precision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialReport {
    /// The scene.
    pub scene: String,
    /// The group that it belongs to.
    pub group: String,
    /// The method, and how its step was chosen.
    pub way: String,
    /// `cpu` or `gpu`.
    pub backend: String,
    /// The precision.
    pub precision: String,
    /// What to think of it.
    pub verdict: Verdict,
    /// The figure that decided, in a few letters.
    pub figure: String,
    /// Why, in words.
    pub reason: String,
    /// The method that was taken.
    pub method: Option<String>,
    /// Steps taken.
    pub steps: u64,
    /// Operator applications.
    pub operator_applications: u64,
    /// The smallest step, s.
    pub step_s: Option<f64>,
    /// What was checked.
    pub checks: Vec<Check>,
}

/// What to think of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// All that was checked holds.
    Pass,
    /// What is promised holds; something else does not.
    Degraded,
    /// It ends in a clear error, as documented.
    Refused,
    /// A promise is broken.
    Fail,
}

/// What was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOutTrial {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

impl Check {
    /// `value` must not exceed `limit`; a value that is no number does not hold.
    pub fn at_most(what: &str, value: f64, limit: f64, promised: bool) -> Self {
        let holds = value <= limit;
        let value = value.is_finite().then_some(value);
        Self { what: what.to_owned(), value, limit, holds, promised }
    }

    /// Something that holds or does not.
    pub fn that(what: &str, holds: bool, promised: bool) -> Self {
        let value = if holds { 0.0 } else { 1.0 };
        Self { what: what.to_owned(), value: Some(value), limit: 0.0, holds, promised }
    }

    /// Whether it breaks a promise.
    pub fn is_broken(&self) -> bool {
        self.promised && !self.holds
    }
}

impl Verdict {
    /// Every verdict, the best first.
    pub const ALL: [Self; 4] = [Self::Pass, Self::Degraded, Self::Refused, Self::Fail];

    /// That of checks.
    pub fn of(checks: &[Check]) -> Self {
        if checks.iter().any(Check::is_broken) {
            return Self::Fail;
        }
        if checks.iter().all(|check| check.holds) { Self::Pass } else { Self::Degraded }
    }

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Degraded => "degraded",
            Self::Refused => "refused",
            Self::Fail => "FAIL",
        }
    }
}

impl StabilityReport {
    /// Whether every promise held.
    pub fn keeps_its_promises(&self) -> bool {
        self.broken.is_empty()
    }

    /// How many trials have each verdict, in the order of [`Verdict::ALL`].
    pub fn counts(&self) -> [usize; 4] {
        Verdict::ALL.map(|of| self.trials.iter().filter(|trial| trial.verdict == of).count())
    }
}

impl TrialReport {
    /// Backend, precision and way: the column of a table that it belongs to.
    pub fn column(&self) -> (&str, &str, &str) {
        (&self.backend, &self.precision, &self.way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_follow_checks() {
        let good = Check::at_most("drift", 1e-16, 1e-12, true);
        let unpromised = Check::at_most("overshoot", 0.1, 1e-12, false);
        let broken = Check::at_most("overshoot", 0.1, 1e-12, true);
        assert_eq!(Verdict::of(std::slice::from_ref(&good)), Verdict::Pass);
        assert_eq!(Verdict::of(&[good.clone(), unpromised]), Verdict::Degraded);
        assert_eq!(Verdict::of(&[broken, good]), Verdict::Fail);
        let lost = Check::at_most("error", f64::NAN, 1.0, true);
        assert!(lost.is_broken() && lost.value.is_none(), "what is no number holds nothing");
    }
}
