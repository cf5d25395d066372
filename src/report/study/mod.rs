//! The report of a study, as data: error against run time over many settings of one case.
//!
//! Beside it lie what people read: a table for the terminal, plots, `study.csv` and `study.html`.

mod chart;
mod csv;
mod labels;
mod law;
mod page;
mod peers;
mod plots;
mod point;
mod table;

use serde::{Deserialize, Serialize};

use super::{OutputError, OutputFolder};

pub use self::csv::COLUMNS as CSV_COLUMNS;
pub use labels::label;
pub use law::ReferenceLaw;
pub use peers::{PEERS_VERSION, PeerPoint, Peers};
pub use point::{Measured, Part, Point, ProbeSplit, Setting, Split, Spread, TimedRun};

/// Version of the report's layout; raised whenever a name or a meaning changes.
pub const STUDY_VERSION: u32 = 1;

/// The errors that a recommendation is given for: relative L2.
pub const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Error against run time. Units are SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyReport {
    /// [`STUDY_VERSION`].
    pub study_version: u32,
    /// [`crate::report::run::DIFFUSPH_VERSION`].
    pub diffusph_version: String,
    /// The case's file or shipped name.
    pub case: String,
    /// The case's title.
    pub title: String,
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Where it ran.
    pub machine: StudyMachine,
    /// What errors are against, in words; `null` where there is nothing to compare with.
    pub against: Option<String>,
    /// How often each point was to run, a warm-up apart.
    pub repeat: usize,
    /// The time allowed, s.
    pub budget_s: f64,
    /// The time taken, s.
    pub elapsed_s: f64,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
    /// What was measured, and what failed, by number.
    pub points: Vec<Point>,
    /// What was left out, since the time allowed was over.
    pub skipped: Vec<Skipped>,
    /// Observed orders of accuracy.
    pub orders: Vec<Order>,
    /// The cheapest setting for each of [`TARGETS`].
    pub recommendations: Vec<Recommendation>,
    /// What is known elsewhere of the error.
    #[serde(default)]
    pub reference_laws: Vec<ReferenceLaw>,
    /// Points of other programs.
    pub peers: Option<Peers>,
    /// Where these win, in words.
    pub peers_ahead: Vec<String>,
    /// What the user should know.
    pub remarks: Vec<String>,
}

/// Where a study ran.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StudyMachine {
    /// The processor's name.
    pub processor: String,
    /// Threads of the CPU that a run may use.
    pub threads: usize,
    /// `cpu` or `gpu`, where points do not say otherwise.
    pub backend: String,
    /// The GPU's name; `null` on the CPU path.
    pub adapter: Option<String>,
}

/// A setting that was not run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Skipped {
    /// What it is, in short.
    pub label: String,
    /// The command that runs it.
    pub command: String,
    /// What it was expected to take, s.
    pub expected_s: f64,
    /// Why it was not run.
    pub why: String,
}

/// The observed order of accuracy of points that differ in one thing alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// `spacing` or `step`.
    pub varies: String,
    /// What stays the same.
    pub series: String,
    /// The points, the finest first.
    pub points: Vec<usize>,
    /// The finest, m or s.
    pub from: f64,
    /// The coarsest, m or s.
    pub to: f64,
    /// Least-squares slopes over all of them.
    pub all: Slopes,
    /// Slopes between the two finest.
    pub finest: Slopes,
    /// The slope of what the steps in time make of the error at the first probe; `null` where that
    /// part is not known.
    pub time_part: Option<f64>,
}

/// Slopes of the logarithm of an error, by norm; `null` where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Slopes {
    /// Of the mean magnitude.
    pub l1: Option<f64>,
    /// Of the root mean square, weighted by volume.
    pub l2: Option<f64>,
    /// Of the largest.
    pub linf: Option<f64>,
    /// Of the root mean square over that of the exact field.
    pub l2_relative: Option<f64>,
}

/// The cheapest setting for an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recommendation {
    /// Relative L2.
    pub target: f64,
    /// The point; `null` where none reached it.
    pub point: Option<usize>,
    /// Set-up and solve, s.
    pub total_s: Option<f64>,
    /// The same in words.
    pub text: String,
}

impl StudyReport {
    /// Writes `study.json`, `study.csv`, `study.html` and the pictures.
    ///
    /// # Errors
    /// Where one cannot be written.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), OutputError> {
        folder.write_json("study.json", self)?;
        self.write_csv(folder.path())?;
        self.write_pictures(folder.path())?;
        self.write_page(folder.path())
    }

    /// The points that ran.
    pub fn measured(&self) -> impl Iterator<Item = (&Point, &Measured)> {
        self.points.iter().filter_map(|point| Some((point, point.result.as_ref()?)))
    }
}

#[cfg(test)]
pub(crate) mod tests;
