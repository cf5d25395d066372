//! The report on numerical stability as one page, and its files.

use std::io::{self, Write};

use super::{Check, StabilityReport, StepScan, TrialReport, Verdict, growth, heat};
use crate::report::canvas::Failure;
use crate::report::format::{grouped, significant, wall_time};
use crate::report::html::{
    Html, Section, details, figure, list, page, paragraph, preformatted, table,
};
use crate::report::output::write_whole;
use crate::report::{OutputError, OutputFolder};

/// Panels of growth that one picture holds.
const PANELS: usize = 3;

impl StabilityReport {
    /// Writes `stability.json` and `stability.html` into `folder`.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), OutputError> {
        folder.write_json("stability.json", self)?;
        let path = folder.path().join("stability.html");
        let failed = |error: Failure| OutputError::Write {
            path: path.clone(),
            source: io::Error::other(error),
        };
        let page = self.page().map_err(failed)?;
        write_whole(&path, |out| out.write_all(page.as_bytes()))
    }

    /// The page, with everything in it.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn page(&self) -> Result<String, Failure> {
        let title = match &self.case {
            Some(case) => format!("Numerical stability of {case}"),
            None => "Numerical stability".to_owned(),
        };
        let sections = [
            Section::new("What held", self.summary()),
            Section::new("Scenes and methods", self.verdicts()?),
            Section::new("Growth of the fastest mode", self.growth()?),
            Section::new("Limits of the step", self.limits()?),
            Section::new("How it was made", self.origin()),
        ];
        Ok(page(&title, &sections))
    }

    fn summary(&self) -> Vec<Html> {
        let mut parts = vec![paragraph(&match self.broken.len() {
            0 => "Every promise of the documentation held.".to_owned(),
            count => format!("{count} promises of the documentation did not hold:"),
        })];
        if !self.broken.is_empty() {
            parts.push(list(&self.broken));
        }
        let (scans, trials) = (self.scans.len(), self.trials.len());
        parts.push(paragraph(&format!(
            "{scans} scans of the step of explicit Euler; {trials} runs: {}.",
            self.counts_in_words()
        )));
        parts
    }

    fn verdicts(&self) -> Result<Vec<Html>, Failure> {
        let mut parts = vec![paragraph(
            "Each cell gives the verdict with a figure: where something fails, by how much; else for \
             explicit Euler how far values leave the range that they start from and that walls impose, \
             above the limit how far the growth is off, and for the other methods the error, all of \
             these over the size of the field. Everything that was checked stands in the tables below.",
        )];
        for machine in self.machines() {
            let caption = format!("Verdicts on the {}, {}.", machine.0.to_uppercase(), machine.1);
            parts.push(figure(&heat::svg(self, machine)?, &caption));
        }
        let notable = |trial: &&TrialReport| trial.verdict != Verdict::Pass;
        let rows: Vec<Vec<String>> = self.trials.iter().filter(notable).map(row).collect();
        let header = ["scene", "way", "precision", "verdict", "why"];
        if !rows.is_empty() {
            parts.push(paragraph("What is not a plain pass:"));
            parts.push(table(&header, &rows));
        }
        let header = ["scene", "way", "precision", "verdict", "steps", "applications", "checks"];
        let rows: Vec<Vec<String>> = self.trials.iter().map(full_row).collect();
        parts.push(details("All runs with all that was checked", table(&header, &rows)));
        Ok(parts)
    }

    fn growth(&self) -> Result<Vec<Html>, Failure> {
        let mut parts = vec![paragraph(
            "The mode that explicit Euler loses first is put in as the initial state, and the growth of \
             the run is measured over a few steps. Above 1 the run diverges.",
        )];
        let lattices: Vec<&StepScan> = self.scans.iter().filter(|scan| scan.is_lattice).collect();
        let others: Vec<&StepScan> =
            self.scans.iter().filter(|scan| !scan.is_lattice && !scan.points.is_empty()).collect();
        // The first are shown, the rest are there on demand.
        for (scans, what) in [(lattices, "lattices"), (others, "scenes")] {
            let mut hidden = Vec::new();
            for (number, group) in scans.chunks(PANELS).enumerate() {
                let caption = "Growth a step over the step, with the bounds.";
                let picture = figure(&growth::growth(group)?, caption);
                let is_shown = number == 0 && (what == "lattices" || self.case.is_some());
                if is_shown { parts.push(picture) } else { hidden.push(picture) }
            }
            if !hidden.is_empty() {
                parts.push(details(&format!("More {what}"), hidden.into_iter().collect()));
            }
        }
        Ok(parts)
    }

    fn limits(&self) -> Result<Vec<Html>, Failure> {
        let scans: Vec<&StepScan> = self.scans.iter().collect();
        let header =
            ["scene", "(116)", "(117)", "safe", "2/λmax", "measured", "safe/measured", "checks"];
        let row = |scan: &StepScan| -> Vec<String> {
            let first = [scan.scene.clone()].into_iter();
            first.chain(scan.limits()).chain([checks_in_words(&scan.checks)]).collect()
        };
        let rows: Vec<Vec<String>> = self.scans.iter().map(row).collect();
        let caption = "The report's bounds and the safe bound over the measured limit: what lies right \
                       of 1 is unstable. The report's bounds know the largest diffusivity alone.";
        Ok(vec![
            figure(&growth::bounds(&scans)?, caption),
            paragraph("Steps over dx²/D of the largest diffusivity:"),
            table(&header, &rows),
        ])
    }

    fn origin(&self) -> Vec<Html> {
        let adapter = self.adapter.as_ref().map(|name| format!(", {name}")).unwrap_or_default();
        let mut parts = vec![
            preformatted(&self.command),
            paragraph(&format!(
                "diffusph {}, {} threads{adapter}, {}.",
                self.diffusph_version,
                self.threads,
                wall_time(self.wall_s)
            )),
        ];
        if !self.left_out.is_empty() {
            let rows: Vec<Vec<String>> = self
                .left_out
                .iter()
                .map(|left| vec![left.what.clone(), left.why.clone()])
                .collect();
            parts.push(details("What was left out", table(&["what", "why"], &rows)));
        }
        if !self.warnings.is_empty() {
            parts.push(list(&self.warnings));
        }
        parts
    }
}

fn row(trial: &TrialReport) -> Vec<String> {
    let TrialReport { scene, way, precision, verdict, reason, .. } = trial;
    [scene, way, precision, verdict.name(), reason].map(str::to_owned).to_vec()
}

fn full_row(trial: &TrialReport) -> Vec<String> {
    let TrialReport { scene, way, precision, verdict, .. } = trial;
    let checks = match trial.checks.is_empty() {
        true => trial.reason.clone(),
        false => checks_in_words(&trial.checks),
    };
    let counts = [trial.steps, trial.operator_applications].map(grouped);
    let names = [scene, way, precision, verdict.name()].map(str::to_owned);
    names.into_iter().chain(counts).chain([checks]).collect()
}

/// Every check with its figure and what it is held to.
fn checks_in_words(checks: &[Check]) -> String {
    let parts: Vec<String> = checks.iter().map(Check::in_words).collect();
    parts.join("; ")
}

impl Check {
    /// The check with its figure and what it is held to.
    pub fn in_words(&self) -> String {
        let Self { what, limit, holds, promised, .. } = self;
        if *limit == 0.0 {
            return format!("{what}: {}", if *holds { "yes" } else { "no" });
        }
        let value = self.value.map_or("not finite".to_owned(), |value| significant(value, 2));
        let most = significant(*limit, 2);
        match (holds, promised) {
            (true, _) => format!("{what} {value}, at most {most}"),
            (false, true) => format!("{what} {value}, above the promised {most}"),
            (false, false) => format!("{what} {value}, above {most} (not promised)"),
        }
    }
}
