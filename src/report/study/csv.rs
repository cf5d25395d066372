//! `study.csv`: a line a point.

use super::{Point, StudyReport};
use crate::report::OutputError;
use crate::report::output::write_whole;
use std::io;
use std::path::Path;

/// The columns. Times are in seconds, medians unless they say otherwise; a cell is empty where
/// there is no number.
pub const COLUMNS: [&str; 29] = [
    "number",
    "label",
    "settings",
    "particles",
    "spacing_m",
    "backend",
    "precision",
    "path",
    "method",
    "steps",
    "dt_s",
    "operator_applications",
    "setup_s",
    "solve_s",
    "output_s",
    "total_s",
    "total_least_s",
    "total_greatest_s",
    "runs",
    "updates_per_s",
    "memory_bytes",
    "l1",
    "l2",
    "linf",
    "l2_relative",
    "space_l2_relative",
    "pareto",
    "failure",
    "command",
];

impl StudyReport {
    /// Writes `study.csv` into `folder`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write_csv(&self, folder: &Path) -> Result<(), OutputError> {
        write_whole(&folder.join("study.csv"), |out| {
            let mut table = csv::Writer::from_writer(out);
            table.write_record(COLUMNS).map_err(io::Error::from)?;
            for point in &self.points {
                table.write_record(row(point)).map_err(io::Error::from)?;
            }
            table.flush()
        })
    }
}

/// `{:?}` is the shortest text that reads back as the same number.
fn number(x: f64) -> String {
    if x.is_finite() { format!("{x:?}") } else { String::new() }
}

fn row(point: &Point) -> [String; COLUMNS.len()] {
    let of = point.result.as_ref();
    let text = |text: fn(&super::Measured) -> String| of.map_or_else(String::new, text);
    let error = of.and_then(|of| of.error.as_ref());
    let norm = |norm: Option<f64>| norm.map_or_else(String::new, number);
    let settings: Vec<String> =
        point.settings.iter().map(|of| format!("{}={}", of.name, of.value)).collect();
    let split = of.and_then(|of| of.split.as_ref());
    [
        point.number.to_string(),
        point.label.clone(),
        settings.join("; "),
        point.particles.to_string(),
        number(point.spacing),
        text(|of| of.backend.clone()),
        text(|of| of.precision.clone()),
        text(|of| of.path.clone()),
        text(|of| of.method.clone()),
        text(|of| of.steps.to_string()),
        norm(of.and_then(|of| of.dt)),
        text(|of| of.operator_applications.to_string()),
        text(|of| number(of.setup_s.median)),
        text(|of| number(of.solve_s.median)),
        text(|of| number(of.output_s.median)),
        text(|of| number(of.total_s.median)),
        text(|of| number(of.total_s.least)),
        text(|of| number(of.total_s.greatest)),
        text(|of| of.runs.iter().filter(|run| !run.warm_up).count().to_string()),
        text(|of| number(of.updates_per_s)),
        text(|of| of.memory_bytes.to_string()),
        norm(error.map(|error| error.l1)),
        norm(error.map(|error| error.l2)),
        norm(error.map(|error| error.linf)),
        norm(error.map(|error| error.l2_relative)),
        norm(split.and_then(|split| split.space_l2_relative)),
        text(|of| of.pareto.to_string()),
        point.failure.clone().unwrap_or_default(),
        point.command.clone(),
    ]
}
