//! `study.html`: the study on one page that needs nothing else.

use std::io::{self, Write};
use std::path::Path;

use super::table::{HEADER, Splits, order_text};
use super::{PeerPoint, Recommendation, StudyReport};
use crate::report::OutputError;
use crate::report::canvas::Failure;
use crate::report::format::{significant, wall_time};
use crate::report::html::{
    Html, Section, details, figure, list, page, paragraph, preformatted, table,
};
use crate::report::output::write_whole;

impl StudyReport {
    /// Writes `study.html` into `folder`.
    ///
    /// # Errors
    /// Where it cannot be drawn or written.
    pub fn write_page(&self, folder: &Path) -> Result<(), OutputError> {
        let path = folder.join("study.html");
        let drawn = self.page().map_err(|error: Failure| OutputError::Write {
            path: path.clone(),
            source: io::Error::other(error),
        })?;
        write_whole(&path, |out| out.write_all(drawn.as_bytes()))
    }

    /// The page as text.
    pub(super) fn page(&self) -> Result<String, Failure> {
        let mut sections = vec![self.summary()];
        let pictures = self.pictures()?.into_iter();
        let pictures = pictures.map(|picture| figure(&picture.svg, &picture.caption));
        sections.push(Section::new("Pictures", pictures));
        sections.push(self.numbers());
        if !self.orders.is_empty() {
            let orders: Vec<String> = self.orders.iter().map(order_text).collect();
            sections.push(Section::new("Observed orders of accuracy", [list(&orders)]));
        }
        sections.push(self.what_it_consists_of());
        sections.extend(self.other_programs());
        if !self.skipped.is_empty() {
            let skipped: Vec<String> =
                self.skipped.iter().map(|of| format!("{}: {}", of.label, of.why)).collect();
            sections.push(Section::new("Left out", [list(&skipped)]));
        }
        sections.push(self.commands());
        Ok(page(&format!("Error against run time: {}", self.title), &sections))
    }

    fn summary(&self) -> Section {
        let text = |of: &Recommendation| of.text.clone();
        let mut advice: Vec<String> = self.recommendations.iter().map(text).collect();
        advice.extend(self.peers_ahead.iter().cloned());
        let mut parts = vec![list(&advice)];
        parts.extend(
            self.against.iter().map(|against| paragraph(&format!("Errors are {against}."))),
        );
        parts.extend(self.remarks.iter().map(|remark| paragraph(remark)));
        parts.push(paragraph(&format!("{}. {}.", self.where_it_ran(), self.extent())));
        Section::new("Which settings to run", parts)
    }

    fn numbers(&self) -> Section {
        let note = "* is on the Pareto front: no other setting is both faster and more accurate. Times \
                    are medians over the runs that count; ± is half of what they differ by.";
        Section::new("Numbers", [table(&HEADER, &self.rows()), paragraph(note)])
    }

    fn what_it_consists_of(&self) -> Section {
        let body: Vec<Html> = match self.splits() {
            Ok(Splits { header, rows }) => {
                let place = self.split_place().unwrap_or_default();
                let text = format!(
                    "The error {place}, on the way from the exact value to that of the run, each part over \
                     the value before it. Source extent (or initial state): what the particles carry at \
                     first, spread exactly. Deff: the effective diffusivity of the particles' sum in place \
                     of D. Interpolation: a probe between particles. Dispersion: what the sum does to \
                     short waves beyond that. Step: the steps in time."
                );
                let remarks = self.split_remarks();
                vec![paragraph(&text), table(&header, &rows), list(&remarks)]
            }
            Err(why) => why.iter().map(|why| paragraph(&format!("Not known: {why}."))).collect(),
        };
        Section::new("What the error consists of", body)
    }

    fn other_programs(&self) -> Option<Section> {
        let peers = self.peers.as_ref()?;
        let row = |peer: &PeerPoint| {
            vec![
                peer.name(),
                wall_time(peer.total_s()),
                significant(peer.l2_relative, 4),
                peer.against.clone(),
                peer.command.clone(),
            ]
        };
        let rows: Vec<Vec<String>> = peers.points.iter().map(row).collect();
        let header = ["program", "set-up and solution", "L2 relative", "against", "command"];
        let machine = format!("Measured on: {}.", peers.machine);
        Some(Section::new("Other programs", [paragraph(&machine), table(&header, &rows)]))
    }

    fn commands(&self) -> Section {
        let ran = self.points.iter().map(|point| format!("# {}: {}", point.number, point.label));
        let ran = ran.zip(&self.points).map(|(name, point)| format!("{name}\n{}", point.command));
        let skipped =
            self.skipped.iter().map(|of| format!("# left out: {}\n{}", of.label, of.command));
        let all: Vec<String> = ran.chain(skipped).collect();
        let count = format!("The commands of all {} settings", all.len());
        Section::new("Commands", [details(&count, preformatted(&all.join("\n")))])
    }
}
