//! The study as a table for the terminal, and the texts that the page shares with it.

use std::fmt::{self, Display};

use super::{Measured, Order, Part, Point, ProbeSplit, StudyReport};
use crate::report::format::{grouped, significant, wall_time};

/// The columns of the table of points.
pub(super) const HEADER: [&str; 10] = [
    "",
    "setting",
    "particles",
    "steps",
    "applications",
    "set-up",
    "solve",
    "updates/s",
    "L2 relative",
    "Linf",
];

/// The splits of the errors, as a table.
pub(super) struct Splits {
    pub(super) header: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl StudyReport {
    /// The study as text for the terminal.
    pub fn table(&self) -> String {
        Table(self).to_string()
    }

    /// Where it ran, in words.
    pub(super) fn where_it_ran(&self) -> String {
        let machine = &self.machine;
        let plural = if machine.threads == 1 { "" } else { "s" };
        let gpu = machine.adapter.as_ref().map_or_else(String::new, |name| format!(", GPU {name}"));
        format!(
            "diffusph {}, {}, {} thread{plural}, backend {}{gpu}",
            self.diffusph_version, machine.processor, machine.threads, machine.backend
        )
    }

    /// What was run and what was not, in words.
    pub(super) fn extent(&self) -> String {
        let failed = self.points.iter().filter(|point| point.result.is_none()).count();
        let ran = self.points.len() - failed;
        let [elapsed, budget] = [self.elapsed_s, self.budget_s].map(wall_time);
        let stopped = if self.interrupted { "; stopped before its end" } else { "" };
        format!(
            "{ran} settings ran, {failed} failed, {} left out; {elapsed} of the {budget} \
             allowed{stopped}",
            self.skipped.len()
        )
    }

    /// The points as rows under [`HEADER`].
    pub(super) fn rows(&self) -> Vec<Vec<String>> {
        self.points.iter().map(row).collect()
    }

    /// The splits of the errors at the first probe: or why there are none.
    pub(super) fn splits(&self) -> Result<Splits, Vec<String>> {
        let split = |of: &Measured| of.split.as_ref()?.probes.first().cloned();
        let all: Vec<(&Point, ProbeSplit)> =
            self.measured().filter_map(|(point, of)| Some((point, split(of)?))).collect();
        let Some((_, first)) = all.first() else {
            let mut why: Vec<String> =
                self.measured().filter_map(|(_, of)| of.no_split.clone()).collect();
            why.sort();
            why.dedup();
            return Err(why);
        };
        let names = first.parts.iter().map(|part| part.name.clone());
        let header: Vec<String> = ["", "setting", "value", "all"].map(str::to_owned).to_vec();
        let header = header.into_iter().chain(names).collect();
        let row = |(point, split): &(&Point, ProbeSplit)| {
            let all = (split.value - split.exact) / split.exact;
            let value = significant(split.value, 10);
            let mut cells =
                vec![point.number.to_string(), point.label.clone(), value, percent(all)];
            let part = |part: &Part| part.relative.map_or_else(String::new, percent);
            cells.extend(split.parts.iter().map(part));
            cells
        };
        Ok(Splits { header, rows: all.iter().map(row).collect() })
    }

    /// What the splits say of themselves, each once.
    pub(super) fn split_remarks(&self) -> Vec<String> {
        let of = self.measured().filter_map(|(_, of)| of.split.as_ref());
        let mut remarks: Vec<String> = of.flat_map(|split| split.remarks.clone()).collect();
        remarks.sort();
        remarks.dedup();
        remarks
    }

    /// What the first probe of the splits is called and compared with.
    pub(super) fn split_place(&self) -> Option<String> {
        let split = self.measured().find_map(|(_, of)| of.split.as_ref())?.probes.first()?;
        let exact = significant(split.exact, 8);
        Some(format!("at the probe \"{}\", where the exact value is {exact}", split.name))
    }
}

/// A part of one with its sign, in percent.
pub(super) fn percent(part: f64) -> String {
    // Rounding of the order of f64's is no part of an error.
    if part.abs() < 1e-13 {
        return "0 %".to_owned();
    }
    let text = significant(100.0 * part, 3);
    if part > 0.0 { format!("+{text} %") } else { format!("{} %", text.replace('-', "−")) }
}

fn row(point: &Point) -> Vec<String> {
    let mark = |of: &Measured| if of.pareto { "*" } else { "" };
    let number = format!("{}{}", point.number, point.result.as_ref().map_or("", mark));
    let mut cells = vec![number, point.label.clone(), grouped(point.particles)];
    let Some(of) = &point.result else {
        let why = point.failure.clone().unwrap_or_default();
        cells.push(format!("failed: {why}"));
        cells.resize(HEADER.len(), String::new());
        return cells;
    };
    let norm = |norm: Option<f64>| norm.map_or_else(|| "-".to_owned(), |x| significant(x, 4));
    let error = of.error.as_ref();
    cells.extend([
        grouped(of.steps),
        grouped(of.operator_applications),
        wall_time(of.setup_s.median),
        with_spread(of),
        significant(of.updates_per_s, 3),
        norm(error.map(|error| error.l2_relative)),
        norm(error.map(|error| error.linf)),
    ]);
    cells
}

/// The time of the solution with half of what the runs differ by.
fn with_spread(of: &Measured) -> String {
    let solve = of.solve_s;
    let text = wall_time(solve.median);
    if solve.greatest <= solve.least {
        return text;
    }
    format!("{text} ± {:.0} %", 50.0 * (solve.greatest - solve.least) / solve.median)
}

/// An order of accuracy in words.
pub(super) fn order_text(order: &Order) -> String {
    let slope = |slope: Option<f64>| slope.map_or_else(|| "none".to_owned(), |x| format!("{x:.2}"));
    let unit = if order.varies == "spacing" { "m" } else { "s" };
    let [from, to] = [order.from, order.to].map(|x| significant(x, 4));
    let all = &order.all;
    let time = order.time_part.map_or_else(String::new, |slope| {
        format!("; the part of the steps at the first probe {slope:.2}")
    });
    format!(
        "{}, {} {from} to {to} {unit} ({} points): relative L2 {}, L1 {}, Linf {}; between the two \
         finest, relative L2 {}{time}",
        order.series,
        order.varies,
        order.points.len(),
        slope(all.l2_relative),
        slope(all.l1),
        slope(all.linf),
        slope(order.finest.l2_relative)
    )
}

struct Table<'a>(&'a StudyReport);

impl Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = self.0;
        writeln!(f, "{} ({})", report.title, report.case)?;
        writeln!(f, "{}", report.where_it_ran())?;
        writeln!(f, "{}", report.extent())?;
        if let Some(against) = &report.against {
            writeln!(f, "errors are {against}; * marks the Pareto front")?;
        }
        writeln!(f)?;
        let header = HEADER.map(str::to_owned).to_vec();
        aligned(f, &header, &report.rows())?;
        self.orders(f)?;
        self.splits(f)?;
        self.skipped(f)?;
        writeln!(f)?;
        report.recommendations.iter().try_for_each(|of| writeln!(f, "{}", of.text))?;
        report.peers_ahead.iter().try_for_each(|text| writeln!(f, "{text}"))?;
        report.remarks.iter().try_for_each(|text| writeln!(f, "note  {text}"))
    }
}

impl Table<'_> {
    fn orders(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.0.orders.is_empty() {
            writeln!(f, "\nobserved orders")?;
        }
        self.0.orders.iter().try_for_each(|order| writeln!(f, "  {}", order_text(order)))
    }

    fn splits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.splits() {
            Ok(Splits { header, rows }) => {
                let place = self.0.split_place().unwrap_or_default();
                writeln!(f, "\nwhat the error consists of, {place}")?;
                aligned(f, &header, &rows)?;
                self.0.split_remarks().iter().try_for_each(|text| writeln!(f, "  {text}"))
            }
            Err(why) => {
                why.iter().try_for_each(|why| writeln!(f, "\nno split of the error: {why}"))
            }
        }
    }

    fn skipped(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.0.skipped.is_empty() {
            writeln!(f, "\nleft out")?;
        }
        let skipped = self.0.skipped.iter();
        skipped.into_iter().try_for_each(|of| writeln!(f, "  {}: {}", of.label, of.why))
    }
}

/// Rows under a header, text to the left and numbers to the right.
fn aligned(f: &mut fmt::Formatter<'_>, header: &[String], rows: &[Vec<String>]) -> fmt::Result {
    // A failure may be long: it does not widen its column.
    let counts = |row: &&Vec<String>| !row.iter().any(|cell| cell.starts_with("failed: "));
    let width = |column: usize| {
        let cells = rows.iter().filter(counts).map(|row| row[column].chars().count());
        cells.chain([header[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    for row in std::iter::once(&header.to_vec()).chain(rows) {
        let mut text = String::new();
        for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
            let padded = match column == 1 || cell.starts_with("failed: ") {
                true => format!("  {cell:<width$}"),
                false => format!("  {cell:>width$}"),
            };
            text.push_str(&padded);
        }
        writeln!(f, "{}", text.trim_end())?;
    }
    Ok(())
}
