//! The report of a benchmark as tables for people.

use std::fmt::{self, Display};

use super::bench::{BenchReport, Growth, LeftOutSize, LimitReport, Measurement, SeriesReport};
use super::format::{bytes, grouped, significant, wall_time};

/// The columns of a series.
const COLUMNS: [&str; 11] = [
    "particles",
    "neighbours",
    "set-up",
    "updates/s",
    "bytes",
    "of copy",
    "of reading",
    "operations",
    "of arithmetic",
    "of the limit",
    "memory",
];

impl BenchReport {
    /// The report as tables, one a series.
    pub fn table(&self) -> String {
        Table(self).to_string()
    }
}

struct Table<'a>(&'a BenchReport);

impl Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = self.0;
        let machine = report.adapter.as_ref().map_or_else(String::new, |name| format!(" ({name})"));
        let threads = report.threads;
        let plural = if threads == 1 { "" } else { "s" };
        let version = &report.diffusph_version;
        writeln!(f, "diffusph {version}, {}{machine}, {threads} thread{plural}", report.backend)?;
        report.limits.iter().try_for_each(|limit| self.limit(f, limit))?;
        report.series.iter().try_for_each(|of| series(f, of))?;
        if !report.left_out.is_empty() {
            writeln!(f, "\nleft out")?;
        }
        for left in &report.left_out {
            let size = left.size.map_or("every size".to_owned(), power);
            writeln!(f, "  {}, {size}: {}", left.name(), left.why)?;
        }
        report.warnings.iter().try_for_each(|warning| writeln!(f, "warning  {warning}"))
    }
}

impl Table<'_> {
    fn limit(&self, f: &mut fmt::Formatter<'_>, limit: &LimitReport) -> fmt::Result {
        let giga = |x: f64| significant(x / 1e9, 3);
        let one = limit.copy_one_thread_bytes_per_s;
        let one = one.map_or_else(String::new, |x| format!(" ({} on one thread)", giga(x)));
        let read = limit.read_bytes_per_s;
        let read = read.map_or_else(String::new, |x| format!(", reading {} GB/s", giga(x)));
        let by = self.0.instructions.as_ref();
        let by = by.map_or_else(String::new, |name| format!(" ({name})"));
        let (copy, operations) = (giga(limit.copy_bytes_per_s), giga(limit.operations_per_s));
        let precision = &limit.precision;
        writeln!(
            f,
            "limits in {precision}: copy {copy} GB/s{one}{read}, arithmetic {operations} GFLOP/s{by}"
        )
    }
}

fn series(f: &mut fmt::Formatter<'_>, series: &SeriesReport) -> fmt::Result {
    writeln!(f, "\n{}", series.name())?;
    let mut rows = vec![COLUMNS.map(str::to_owned)];
    rows.extend(series.measurements.iter().map(row));
    let width = |column: usize| {
        rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default()
    };
    let widths: Vec<usize> = (0..COLUMNS.len()).map(width).collect();
    for row in &rows {
        let cells = row.iter().zip(&widths);
        writeln!(
            f,
            "{}",
            cells.map(|(cell, width)| format!("  {cell:>width$}")).collect::<String>()
        )?;
    }
    growth(f, &series.growth)
}

fn row(m: &Measurement) -> [String; COLUMNS.len()] {
    [
        grouped(m.particles),
        significant(m.neighbors, 3),
        wall_time(m.setup_s),
        updates(m),
        significant(m.bytes_per_update, 3),
        percent(m.copy_fraction),
        m.read_fraction.map_or_else(|| "-".to_owned(), percent),
        significant(m.operations_per_update, 3),
        percent(m.arithmetic_fraction),
        format!("{} ({})", percent(m.limit_fraction), m.bound_by),
        bytes(m.memory_bytes),
    ]
}

/// Updates a second with half of what the rounds differ by.
fn updates(m: &Measurement) -> String {
    let range = m.fastest_updates_per_s - m.slowest_updates_per_s;
    let rate = significant(m.updates_per_s, 3);
    format!("{rate} ± {:.0} %", 50.0 * range / m.updates_per_s)
}

fn growth(f: &mut fmt::Formatter<'_>, growth: &Growth) -> fmt::Result {
    let Some(exponent) = growth.exponent else {
        return Ok(());
    };
    let from = power(growth.from_size);
    write!(f, "  time grows as N^{exponent:.3} over {} sizes from {from}", growth.sizes)?;
    match growth.largest_over_million {
        Some(ratio) => writeln!(f, "; {} of the rate at 1e6 at the largest", percent(ratio)),
        None => writeln!(f),
    }
}

fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    if percent < 9.95 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

/// A size as flags take it: `1e6`.
fn power(size: u64) -> String {
    format!("{:e}", size as f64)
}

impl SeriesReport {
    /// What stays the same in it.
    fn name(&self) -> String {
        name(&self.path, &self.precision, self.dimension, self.support_ratio)
    }
}

impl LeftOutSize {
    /// The series that it belongs to.
    fn name(&self) -> String {
        name(&self.path, &self.precision, self.dimension, self.support_ratio)
    }
}

fn name(path: &str, precision: &str, dimension: usize, support_ratio: f64) -> String {
    format!("{path}, {precision}, {dimension}-D, H/dx {support_ratio}")
}

#[cfg(test)]
mod tests {
    use super::super::bench::BENCH_VERSION;
    use super::*;

    fn report() -> BenchReport {
        let measurement = Measurement {
            particles: 1_000_000,
            neighbors: 25.53,
            setup_s: 0.032,
            updates_per_s: 3.456e8,
            slowest_updates_per_s: 3.3e8,
            fastest_updates_per_s: 3.5e8,
            bytes_per_update: 16.0,
            copy_fraction: 0.301,
            read_bytes_per_update: 8.0,
            read_fraction: Some(0.25),
            operations_per_update: 31.0,
            arithmetic_fraction: 0.0512,
            bound_by: "copy".to_owned(),
            limit_fraction: 0.301,
            memory_bytes: 16_000_000,
            ..Measurement::default()
        };
        let growth = Growth {
            exponent: Some(1.0312),
            from_size: 100_000,
            sizes: 4,
            largest_over_million: Some(0.91),
        };
        let limit = LimitReport {
            precision: "f64".to_owned(),
            copy_bytes_per_s: 18.4e9,
            copy_one_thread_bytes_per_s: Some(9.31e9),
            read_bytes_per_s: Some(12.3e9),
            operations_per_s: 80e9,
        };
        let [path, precision] = ["lattice", "f64"].map(str::to_owned);
        BenchReport {
            bench_version: BENCH_VERSION,
            diffusph_version: "1.2.3".to_owned(),
            backend: "cpu".to_owned(),
            adapter: None,
            threads: 2,
            instructions: Some("AVX2 and FMA".to_owned()),
            least_s: 0.5,
            limits: vec![limit],
            left_out: vec![LeftOutSize {
                path: path.clone(),
                precision: precision.clone(),
                dimension: 3,
                support_ratio: 2.0,
                size: Some(100_000_000),
                why: "no room".to_owned(),
            }],
            series: vec![SeriesReport {
                path,
                precision,
                dimension: 3,
                support_ratio: 2.0,
                measurements: vec![measurement],
                growth,
            }],
            warnings: vec!["it rains".to_owned()],
        }
    }

    #[test]
    fn the_table_says_what_was_measured_and_what_was_not() {
        let text = report().table();
        for part in [
            "diffusph 1.2.3, cpu, 2 threads\n",
            "limits in f64: copy 18.4 GB/s (9.31 on one thread), reading 12.3 GB/s, arithmetic 80 GFLOP/s (AVX2 and FMA)\n",
            "\nlattice, f64, 3-D, H/dx 2\n",
            "  1 000 000        25.5   32 ms  3.46e8 ± 3 %     16     30 %        25 %  ",
            "          5.1 %   30 % (copy)   16 MB\n",
            "  time grows as N^1.031 over 4 sizes from 1e5; 91 % of the rate at 1e6 at the largest\n",
            "\nleft out\n  lattice, f64, 3-D, H/dx 2, 1e8: no room\n",
            "warning  it rains\n",
        ] {
            assert!(text.contains(part), "no `{part}` in\n{text}");
        }
        let plain = BenchReport {
            left_out: Vec::new(),
            warnings: Vec::new(),
            adapter: Some("a GPU".to_owned()),
            instructions: None,
            ..report()
        };
        let text = plain.table();
        assert!(!text.contains("left out") && !text.contains("warning"), "{text}");
        assert!(text.contains("(a GPU)") && !text.contains("AVX2"), "{text}");
    }

    #[test]
    fn the_report_is_read_back_as_it_was_written() {
        let text = serde_json::to_string(&report()).expect("it is JSON");
        let read: BenchReport = serde_json::from_str(&text).expect("it is a report");
        assert_eq!(read, report());
    }
}
