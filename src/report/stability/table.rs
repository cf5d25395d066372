//! The report on numerical stability as tables for people.

use std::fmt::{self, Display};

use super::{StabilityReport, StepScan, TrialReport, Verdict};
use crate::report::format::{significant, wall_time};

/// The columns of a scan.
const COLUMNS: [&str; 7] =
    ["limits in dx^2/D", "(116)", "(117)", "safe", "2/lambda", "measured", "safe/measured"];

impl StabilityReport {
    /// The report as tables.
    pub fn table(&self) -> String {
        Table(self).to_string()
    }

    /// Backend and precision of the trials, in their order.
    pub(super) fn machines(&self) -> Vec<(&str, &str)> {
        let mut found = Vec::new();
        for trial in &self.trials {
            let machine = (&*trial.backend, &*trial.precision);
            if !found.contains(&machine) {
                found.push(machine);
            }
        }
        found
    }

    /// Scenes of the trials on a machine, and their ways, in their order.
    pub(super) fn axes(&self, machine: (&str, &str)) -> (Vec<&str>, Vec<&str>) {
        let (mut scenes, mut ways): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
        for trial in self.on(machine) {
            if !scenes.contains(&&*trial.scene) {
                scenes.push(&trial.scene);
            }
            if !ways.contains(&&*trial.way) {
                ways.push(&trial.way);
            }
        }
        (scenes, ways)
    }

    /// The trial of a scene in a way on a machine.
    pub(super) fn trial(
        &self,
        machine: (&str, &str),
        scene: &str,
        way: &str,
    ) -> Option<&TrialReport> {
        self.on(machine).find(|trial| trial.scene == scene && trial.way == way)
    }

    fn on(&self, machine: (&str, &str)) -> impl Iterator<Item = &TrialReport> {
        let (backend, precision) = (machine.0.to_owned(), machine.1.to_owned());
        let is_there =
            move |trial: &&TrialReport| trial.backend == backend && trial.precision == precision;
        self.trials.iter().filter(is_there)
    }

    /// How many trials came to what, in words.
    pub(super) fn counts_in_words(&self) -> String {
        let counts = Verdict::ALL.into_iter().zip(self.counts());
        let parts: Vec<String> =
            counts.map(|(verdict, count)| format!("{count} {}", verdict.name())).collect();
        parts.join(", ")
    }
}

impl TrialReport {
    /// The verdict with its figure.
    pub(super) fn cell(&self) -> String {
        format!("{} {}", self.verdict.name(), self.figure)
    }
}

impl StepScan {
    /// A time in the unit of limits.
    pub(super) fn in_units(&self, step: Option<f64>) -> String {
        step.map_or("none".to_owned(), |step| significant(step / self.unit_s, 4))
    }

    /// The limits in their unit, as text.
    pub(super) fn limits(&self) -> [String; 6] {
        let over = self.safe_s.zip(self.measured_limit_s).map(|(safe, limit)| safe / limit);
        let units = [Some(self.cfl_s), Some(self.cfl_third_s), self.safe_s, self.limit_s];
        let [cfl, third, safe, limit] = units.map(|step| self.in_units(step));
        let measured = self.in_units(self.measured_limit_s);
        [cfl, third, safe, limit, measured, over.map_or("none".to_owned(), |x| significant(x, 3))]
    }
}

struct Table<'a>(&'a StabilityReport);

impl Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = self.0;
        writeln!(f, "diffusph {}, numerical stability\n", report.diffusph_version)?;
        let mut rows = vec![COLUMNS.map(str::to_owned).to_vec()];
        for scan in &report.scans {
            rows.push([scan.scene.clone()].into_iter().chain(scan.limits()).collect());
        }
        align(f, &rows)?;
        for machine in report.machines() {
            let (scenes, ways) = report.axes(machine);
            writeln!(f)?;
            let first = format!("{}, {}", machine.0, machine.1);
            let header = [first].into_iter().chain(ways.iter().map(|way| (*way).to_owned()));
            let mut rows: Vec<Vec<String>> = vec![header.collect()];
            for scene in scenes {
                let cell = |way: &&str| {
                    report.trial(machine, scene, way).map_or("-".to_owned(), TrialReport::cell)
                };
                rows.push([scene.to_owned()].into_iter().chain(ways.iter().map(cell)).collect());
            }
            align(f, &rows)?;
        }
        writeln!(f)?;
        for trial in report.trials.iter().filter(|trial| trial.verdict != Verdict::Pass) {
            let TrialReport { scene, way, precision, reason, verdict, .. } = trial;
            writeln!(f, "{:8}  {scene}, {way}, {precision}: {reason}", verdict.name())?;
        }
        for left in &report.left_out {
            writeln!(f, "left out  {}: {}", left.what, left.why)?;
        }
        report.warnings.iter().try_for_each(|warning| writeln!(f, "warning   {warning}"))?;
        writeln!(f, "\n{}; {}", report.counts_in_words(), wall_time(report.wall_s))?;
        match report.broken.len() {
            0 => writeln!(f, "every promise held"),
            count => {
                writeln!(f, "{count} promises broken:")?;
                report.broken.iter().try_for_each(|broken| writeln!(f, "  {broken}"))
            }
        }
    }
}

/// Rows in columns of even width: the first to the left, the rest to the right.
fn align(f: &mut fmt::Formatter<'_>, rows: &[Vec<String>]) -> fmt::Result {
    let columns = rows.first().map_or(0, Vec::len);
    let width =
        |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for row in rows {
        for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
            match column {
                0 => write!(f, "{cell:<width$}")?,
                _ => write!(f, "  {cell:>width$}")?,
            }
        }
        writeln!(f)?;
    }
    Ok(())
}
