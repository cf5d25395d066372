//! One setting of a study and what came of it.

use serde::{Deserialize, Serialize};

use crate::report::run::{ErrorReport, ProbeReport};

/// One setting of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Its number in tables and plots, from 1.
    pub number: usize,
    /// What is set, in the order of the sweep.
    pub settings: Vec<Setting>,
    /// What it is, in short.
    pub label: String,
    /// The command that runs it.
    pub command: String,
    /// Distance of the particles, m.
    pub spacing: f64,
    /// How many particles.
    pub particles: u64,
    /// What came of it; `null` where it failed.
    pub result: Option<Measured>,
    /// Why it failed.
    pub failure: Option<String>,
}

/// Something that differs between points.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setting {
    /// Its name: `spacing`, a path in the case, or `sweep` for the name of a part of the study.
    pub name: String,
    /// Its value, as it was written.
    pub value: String,
}

/// What came of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// `cpu` or `gpu`.
    pub backend: String,
    /// The GPU's name; `null` on the CPU path.
    pub adapter: Option<String>,
    /// `f64`, `f32` or `compensated`.
    pub precision: String,
    /// `lattice`, `list` or `mixed`.
    pub path: String,
    /// The time integrator.
    pub method: String,
    /// Time steps.
    pub steps: u64,
    /// The smallest step, s; `null` where there is none.
    pub dt: Option<f64>,
    /// How often the operator was applied to the whole field.
    pub operator_applications: u64,
    /// Particles x applications a second of the solution, in the middle run.
    pub updates_per_s: f64,
    /// Memory of the backend's buffers, bytes.
    pub memory_bytes: u64,
    /// Every run, in order.
    pub runs: Vec<TimedRun>,
    /// From the case to the first step, s.
    pub setup_s: Spread,
    /// The solution alone, s.
    pub solve_s: Spread,
    /// Comparing with the exact solution, s.
    pub output_s: Spread,
    /// Set-up and solution, s.
    pub total_s: Spread,
    /// The error; `null` where there is nothing to compare with.
    pub error: Option<ErrorReport>,
    /// The last value at every probe.
    pub probes: Vec<ProbeReport>,
    /// What the error consists of.
    pub split: Option<Split>,
    /// Why that is not known.
    pub no_split: Option<String>,
    /// Whether no other point is both faster and more accurate.
    pub pareto: bool,
    /// What the run warned about.
    pub warnings: Vec<String>,
}

/// The times of one run, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedRun {
    /// Whether it only warmed up, and does not count.
    pub warm_up: bool,
    /// From the case to the first step.
    pub setup_s: f64,
    /// The solution alone.
    pub solve_s: f64,
    /// Comparing with the exact solution.
    pub output_s: f64,
    /// Particles x applications a second.
    pub updates_per_s: f64,
    /// The whole process, its start included.
    pub command_s: f64,
}

/// The middle and the ends of several measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The middle one, or the mean of the two there.
    pub median: f64,
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

impl Spread {
    /// The spread of `values`; NaN of none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let [Some(&least), Some(&greatest)] = [values.first(), values.last()] else {
            return Self { median: f64::NAN, least: f64::NAN, greatest: f64::NAN };
        };
        let median = 0.5 * (values[(count - 1) / 2] + values[count / 2]);
        Self { median, least, greatest }
    }
}

/// What an error consists of, in space and in time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// Relative L2 of the error that the particles alone make: the same equations, exact in time.
    pub space_l2_relative: Option<f64>,
    /// The parts at each probe.
    pub probes: Vec<ProbeSplit>,
    /// What the split leaves out, in words.
    pub remarks: Vec<String>,
}

/// The parts of the error at a probe, from the exact value to that of the run. They add up to
/// value - exact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeSplit {
    /// The probe's name.
    pub name: String,
    /// The value of the run.
    pub value: f64,
    /// What it is compared with.
    pub exact: f64,
    /// The parts.
    pub parts: Vec<Part>,
}

/// A part of an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// `source extent` or `initial state`, `Deff`, `interpolation`, `dispersion` or `step`.
    pub name: String,
    /// What it adds to the value.
    pub value: f64,
    /// That over the value before it: 1 + each of them multiply to value / exact.
    pub relative: Option<f64>,
}

impl ProbeSplit {
    /// The part called `name`.
    pub fn part(&self, name: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.name == name)
    }
}

impl Point {
    /// The value of the setting `name`, if it is set.
    pub fn setting(&self, name: &str) -> Option<&str> {
        self.settings.iter().find(|setting| setting.name == name).map(|found| &*found.value)
    }
}

impl Measured {
    /// Relative L2 of the error, where there is one and it is finite.
    pub fn error_norm(&self) -> Option<f64> {
        self.error.as_ref().map(|error| error.l2_relative).filter(|norm| norm.is_finite())
    }
}
