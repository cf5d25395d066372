//! The report as a short text for people.

use std::fmt::{self, Display, Write};

use super::format::{bytes, grouped, significant, simulated_time, wall_time};
use super::run::{ErrorReport, ProbeReport, RunReport};

/// Digits of measured and physical quantities.
const DIGITS: usize = 4;
/// Significant digits of values and totals.
const VALUE_DIGITS: usize = 10;
/// Probes that are listed; the rest is in the files.
const MOST_PROBES: usize = 8;

impl RunReport {
    /// A summary of a screenful for stdout: what ran, where, how long, and how well.
    pub fn summary(&self) -> String {
        Summary(self).to_string()
    }
}

struct Summary<'a>(&'a RunReport);

/// A line with its name in front; an empty name continues the line above.
fn line(f: &mut fmt::Formatter<'_>, name: &str, text: impl Display) -> fmt::Result {
    writeln!(f, "  {name:<10}{text}")
}

fn short(number: f64) -> String {
    significant(number, DIGITS)
}

/// A value of the field: long runs differ from their exact solution in the seventh digit.
fn value(number: f64) -> String {
    significant(number, VALUE_DIGITS)
}

impl Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = self.0;
        writeln!(f, "{} ({})", report.title, report.case)?;
        self.what_and_where(f)?;
        self.how_long(f)?;
        self.field(f)?;
        if let Some(error) = &report.error {
            error_lines(f, error)?;
        }
        probe_lines(f, &report.probes)?;
        self.left_out(f)?;
        report.warnings.iter().try_for_each(|warning| line(f, "warning", warning))
    }
}

impl Summary<'_> {
    fn what_and_where(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let r = self.0;
        let count = grouped(r.particles);
        line(f, "scene", format!("{count} particles, {}-D, {} path", r.dimension, r.path))?;
        let adapter = r.adapter.as_ref().map_or_else(String::new, |name| format!(", {name}"));
        line(f, "backend", format!("{}{adapter}, {}", r.backend, r.precision))?;
        if let Some(why) = &r.why_precision {
            line(f, "", why)?;
        }
        let applications = grouped(r.operator_applications);
        line(f, "method", format!("{}, {applications} operator applications", r.method))?;
        if let Some(why) = &r.why_method {
            line(f, "", why)?;
        }
        line(f, "time", simulated_time(r.simulated_s))?;
        if r.steps == 0 {
            return Ok(());
        }
        line(f, "step", self.steps())?;
        if r.dt_limit.is_finite() {
            line(f, "", self.margin())?;
        }
        Ok(())
    }

    fn steps(&self) -> String {
        let r = self.0;
        let [dt, largest] = [r.dt, r.dt_largest].map(|dt| significant(dt, 6));
        let steps = grouped(r.steps);
        // Equal steps differ a little where they land on outputs.
        if r.dt_largest < 1.01 * r.dt {
            return format!("{steps} steps of {dt} s");
        }
        format!("{steps} steps of {dt} to {largest} s, {} more refused", grouped(r.steps_refused))
    }

    fn margin(&self) -> String {
        let ratio = self.0.dt / self.0.dt_limit;
        let limit = significant(self.0.dt_limit, 6);
        let percent = |x: f64| significant(100.0 * x, DIGITS);
        if ratio > 1.0 {
            return format!("{} % ABOVE the limit {limit} s: not stable", percent(ratio - 1.0));
        }
        format!("{} % of the limit {limit} s, {} % margin", percent(ratio), percent(1.0 - ratio))
    }

    fn how_long(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let r = self.0;
        let [setup, solve, output] =
            [r.wall_s.setup, r.wall_s.solve, r.wall_s.output].map(wall_time);
        line(f, "wall time", format!("setup {setup}, solve {solve}, output {output}"))?;
        if r.steps > 0 {
            let rate = significant(r.updates_per_s, 3);
            line(f, "speed", format!("{rate} particle updates/s"))?;
        }
        let each = significant(r.memory_bytes as f64 / r.particles as f64, 3);
        line(f, "memory", format!("{} ({each} bytes a particle)", bytes(r.memory_bytes)))
    }

    fn field(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (field, density, total) = (&self.0.field, &self.0.density, &self.0.conserved);
        let [min, max, mean] = [field.min, field.max, field.mean].map(value);
        line(f, "field", format!("{min} to {max}, mean {mean}"))?;
        if let Some(front) = &self.0.front {
            let unit = ["m", "m2", "m3"][self.0.dimension.clamp(1, 3) - 1];
            let [position, volume] =
                [front.position, front.liquid_volume].map(|x| significant(x, DIGITS));
            let exact =
                front.exact.map(|exact| format!(", exact {} m", significant(exact, DIGITS)));
            let exact = exact.unwrap_or_default();
            line(f, "melted", format!("{volume} {unit}, {position} m along x{exact}"))?;
        }
        let [min, max] = [density.min, density.max].map(|x| significant(x, 6));
        let unit = ["kg/m", "kg/m2", "kg/m3"][self.0.dimension.clamp(1, 3) - 1];
        line(f, "density", format!("{min} to {max} {unit}"))?;
        let [initial, last, exchange] =
            [total.initial, total.last, total.boundary_exchange].map(value);
        line(f, "total", format!("{initial} at first, {last} at last"))?;
        let drift = short(total.relative_drift);
        line(f, "", format!("boundary exchange {exchange}, relative drift {drift}"))
    }

    fn left_out(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.left_out.is_empty() {
            return Ok(());
        }
        let mut text = String::new();
        for (i, part) in self.0.left_out.iter().enumerate() {
            write!(text, "{}{}", if i > 0 { ", " } else { "" }, part.what)?;
        }
        line(f, "left out", text)?;
        let saved: u64 = self.0.left_out.iter().map(|part| part.bytes_saved).sum();
        line(f, "", format!("{} saved", bytes(saved)))
    }
}

fn error_lines(f: &mut fmt::Formatter<'_>, error: &ErrorReport) -> fmt::Result {
    line(f, "error", format!("against {}", error.against))?;
    let [relative, linf] = [error.l2_relative, error.linf].map(short);
    line(f, "", format!("L2 relative {relative}, Linf {linf}"))?;
    let [square, root] = [error.mean_square, error.root_mean_square].map(short);
    line(f, "", format!("mean square (123) {square}, root {root}"))
}

fn probe_lines(f: &mut fmt::Formatter<'_>, probes: &[ProbeReport]) -> fmt::Result {
    for (i, probe) in probes.iter().take(MOST_PROBES).enumerate() {
        let exact = probe.exact.map_or_else(String::new, |x| format!("  exact {}", value(x)));
        let name = if i == 0 { "probes" } else { "" };
        line(f, name, format!("{:<12}{}{exact}", probe.name, value(probe.value)))?;
    }
    if probes.len() > MOST_PROBES {
        line(f, "", format!("and {} more, in probes.csv", probes.len() - MOST_PROBES))?;
    }
    Ok(())
}
