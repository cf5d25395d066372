//! `report.json`: everything about one run, as data.
//!
//! A number that is not finite (a diverged field, a limit that does not exist) is written as
//! `null`, and a `null` is read back as NaN: JSON has no other word for it, and a run that
//! diverged must still leave its report.

use serde::{Deserialize, Serialize};

use super::norms::Norms;
use super::sum::{max_or_nan, min_or_nan, sum_over};

/// Version of the report's layout; raised whenever a name or a meaning changes.
pub const REPORT_VERSION: u32 = 1;

/// The version of this crate, for [`RunReport::diffusph_version`].
pub const DIFFUSPH_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Everything about one run: what ran, where, how long, and how well. Units are SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunReport {
    /// [`REPORT_VERSION`].
    pub report_version: u32,
    /// The case's file or shipped name.
    pub case: String,
    /// The case's title.
    pub title: String,
    /// [`DIFFUSPH_VERSION`].
    pub diffusph_version: String,
    /// `cpu` or `gpu`.
    pub backend: String,
    /// The GPU's name; `null` on the CPU path.
    pub adapter: Option<String>,
    /// `f64`, `f32` or `compensated`.
    pub precision: String,
    /// Why in this precision, where the scene decided.
    pub why_precision: Option<String>,
    /// 1, 2 or 3.
    pub dimension: usize,
    /// How many particles.
    pub particles: u64,
    /// `lattice`, `list` or `mixed`.
    pub path: String,
    /// The time integrator's name.
    pub method: String,
    /// Why in this method, where the case leaves it open; `null` where it does not.
    pub why_method: Option<String>,
    /// Time steps taken.
    pub steps: u64,
    /// Steps that were refused, since their error was above what the tolerance allows.
    pub steps_refused: u64,
    /// How often the operator was applied to the whole field, the measuring of a step limit
    /// included: the unit of cost.
    pub operator_applications: u64,
    /// Time step, s, the smallest where they differ, but for one cut short to land on an output.
    #[serde(with = "number")]
    pub dt: f64,
    /// The largest step, s.
    #[serde(with = "number")]
    pub dt_largest: f64,
    /// The largest step that is known to be stable, s; `null` where there is no limit.
    #[serde(with = "number")]
    pub dt_limit: f64,
    /// Simulated time reached, s.
    #[serde(with = "number")]
    pub simulated_s: f64,
    /// Wall-clock times.
    pub wall_s: WallTimes,
    /// Particles x operator applications of the solution / solve seconds, 1/s.
    #[serde(with = "number")]
    pub updates_per_s: f64,
    /// Memory of the backend's buffers, bytes.
    pub memory_bytes: u64,
    /// The field at the end.
    pub field: FieldRange,
    /// The conserved total and what became of it.
    pub conserved: Conserved,
    /// How far the body has melted; `null` where nothing can.
    pub front: Option<Front>,
    /// The summation density at t = 0, kg/m^dim.
    pub density: Range,
    /// Distance to the exact solution; `null` where the case names none.
    pub error: Option<ErrorReport>,
    /// The last value at every probe.
    pub probes: Vec<ProbeReport>,
    /// What the plan left out because the scene does not need it.
    pub left_out: Vec<LeftOut>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Wall-clock times, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WallTimes {
    /// From the case to the first step, a measured step limit included.
    #[serde(with = "number")]
    pub setup: f64,
    /// Solving alone, reading back included.
    #[serde(with = "number")]
    pub solve: f64,
    /// Writing files and comparing with the exact solution.
    #[serde(with = "number")]
    pub output: f64,
}

/// Extremes and mean of a field, in its unit. NaN where it has a NaN, or no particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldRange {
    /// Least value.
    #[serde(with = "number")]
    pub min: f64,
    /// Greatest value.
    #[serde(with = "number")]
    pub max: f64,
    /// Mean over the particles, each counted once.
    #[serde(with = "number")]
    pub mean: f64,
}

impl FieldRange {
    /// The extremes and the mean of `values`.
    pub fn of(values: &[f64]) -> Self {
        let Range { min, max } = Range::of(values);
        let [sum] = sum_over(values.len(), |i| [values[i]]);
        Self { min, max, mean: sum / values.len() as f64 }
    }
}

/// Least and greatest value. NaN where there is a NaN, or no value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Least value.
    #[serde(with = "number")]
    pub min: f64,
    /// Greatest value.
    #[serde(with = "number")]
    pub max: f64,
}

impl Range {
    /// The extremes of `values`.
    pub fn of(values: &[f64]) -> Self {
        let Some(&first) = values.first() else {
            return Self { min: f64::NAN, max: f64::NAN };
        };
        Self {
            min: values.iter().copied().fold(first, min_or_nan),
            max: values.iter().copied().fold(first, max_or_nan),
        }
    }
}

/// The conserved total, sum of value x capacity (rho c V; V where there is only a diffusivity), and what became of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conserved {
    /// Total at t = 0.
    #[serde(with = "number")]
    pub initial: f64,
    /// Total at the end.
    #[serde(rename = "final", with = "number")]
    pub last: f64,
    /// What came in through walls, held particles and sources, positive into the body.
    #[serde(with = "number")]
    pub boundary_exchange: f64,
    /// (final - initial - boundary_exchange) over the largest of the three magnitudes and of the
    /// initial sum of |value| x volume: the part of the total that the solver itself lost or made.
    /// 0 where all of them are 0.
    #[serde(with = "number")]
    pub relative_drift: f64,
}

impl Conserved {
    /// From the totals at both ends, the exchange and the initial sum of |value| x volume, which
    /// keeps the drift meaningful for a field whose total is 0 by symmetry. An exchange that is not
    /// known is NaN, and the drift then is NaN too.
    pub fn new(initial: f64, last: f64, boundary_exchange: f64, magnitude: f64) -> Self {
        let scale = [initial, last, boundary_exchange, magnitude].map(f64::abs);
        let scale = scale.into_iter().fold(0.0, max_or_nan);
        let drift = last - initial - boundary_exchange;
        let relative_drift = if scale == 0.0 { 0.0 } else { drift / scale };
        Self { initial, last, boundary_exchange, relative_drift }
    }
}

/// How far a body has melted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Front {
    /// The liquid volume over the section of the domain across x, m: where the front is that melts a bar
    /// from one end, or the mean of where it is.
    #[serde(with = "number")]
    pub position: f64,
    /// Volume x liquid fraction of all particles, m^dim.
    #[serde(with = "number")]
    pub liquid_volume: f64,
    /// Where the exact solution has the front, m, if it is one with a front.
    pub exact: Option<f64>,
}

impl Front {
    /// From the liquid volume (m^dim), the section across x (m^(dim - 1)) and the exact position (m).
    pub fn new(liquid_volume: f64, section: f64, exact: Option<f64>) -> Self {
        Self { position: liquid_volume / section, liquid_volume, exact }
    }
}

/// Distance to an exact solution; see [`Norms`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorReport {
    /// What the field is compared with.
    pub against: String,
    /// See [`Norms::l1`].
    #[serde(with = "number")]
    pub l1: f64,
    /// See [`Norms::l2`].
    #[serde(with = "number")]
    pub l2: f64,
    /// See [`Norms::linf`].
    #[serde(with = "number")]
    pub linf: f64,
    /// See [`Norms::l2_relative`].
    #[serde(with = "number")]
    pub l2_relative: f64,
    /// See [`Norms::mean_square`].
    #[serde(with = "number")]
    pub mean_square: f64,
    /// See [`Norms::root_mean_square`].
    #[serde(with = "number")]
    pub root_mean_square: f64,
}

impl ErrorReport {
    /// The norms, with the name of what the field is compared with.
    pub fn new(against: impl Into<String>, norms: Norms) -> Self {
        let Norms { l1, l2, linf, l2_relative, mean_square, root_mean_square } = norms;
        Self { against: against.into(), l1, l2, linf, l2_relative, mean_square, root_mean_square }
    }
}

/// A probe's value at the end of the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeReport {
    /// The name in the case file.
    pub name: String,
    /// Position, m: as many numbers as the scene has dimensions.
    pub at: Vec<f64>,
    /// Time, s.
    #[serde(with = "number")]
    pub time: f64,
    /// The numerical value.
    #[serde(with = "number")]
    pub value: f64,
    /// The exact value, where the case has an exact solution.
    pub exact: Option<f64>,
}

/// Something that the scene does not need and the run did not do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why it is not needed.
    pub why: String,
    /// Memory that this saved, bytes.
    pub bytes_saved: u64,
}

/// Numbers in JSON: what is not finite is `null` there, and NaN here.
mod number {
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
        if number.is_finite() { to.serialize_f64(*number) } else { to.serialize_none() }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
    }
}

#[cfg(test)]
#[path = "run_tests.rs"]
pub(crate) mod tests;
