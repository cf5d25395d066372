//! `diffusph bench`: throughput beside the limits of the machine.

use std::time::Duration;

use clap::Args;

use super::arguments::{MachineArguments, PathFlag, PrecisionFlag};
use super::progress::Monitor;
use super::{CliError, print, print_json};
use crate::solver::{Machine, MachineWish, PathWish};
use crate::study::{self, BenchOptions, LEAST_SIZE};

/// The widest support: the lattice path ends at 4.
const WIDEST: f64 = 10.0;

/// The longest measurement, s.
const LONGEST: f64 = 3600.0;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  diffusph bench\n  diffusph bench --backend gpu --sizes \
                        1e5,1e6 --dimension 3\n  diffusph bench --path lattice --support-ratio 2 \
                        --json > bench.json\n\nThe scenes are uniform lattices in a box with free \
                        edges and a cubic spline; a step is one of explicit Euler. A size whose \
                        arrays fit into caches can exceed the limit of the memory. RAYON_NUM_THREADS \
                        sets the number of threads.")]
pub(super) struct Arguments {
    #[command(flatten)]
    machine: MachineArguments,
    /// The precision [default: every one that the machine has]
    #[arg(long, value_enum)]
    precision: Option<PrecisionFlag>,
    /// How neighbours are known [default: by lattice and by list]
    #[arg(long, value_enum)]
    path: Option<PathFlag>,
    /// Numbers of particles, about: whole, 1000 at least. One that does not fit is left out, and why
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = size,
        default_value = "1e4,1e5,1e6,1e7,1e8")]
    sizes: Vec<u64>,
    /// Dimensions of the scene
    #[arg(long, value_name = "DIM", value_delimiter = ',', default_value = "2,3",
        value_parser = clap::value_parser!(u64).range(2..=3))]
    dimension: Vec<u64>,
    /// Support radius over spacing, H/dx
    #[arg(long, value_name = "RATIO", value_delimiter = ',', value_parser = support_ratio,
        default_value = "2,3")]
    support_ratio: Vec<f64>,
    /// The least time of one measurement
    #[arg(long, value_name = "S", value_parser = seconds, default_value = "0.5")]
    seconds: f64,
    /// Leave out sizes whose set-up is expected to take longer
    #[arg(long, value_name = "S", value_parser = seconds, default_value = "20")]
    setup_seconds: f64,
    /// Print the report as JSON to standard output, and nothing else there
    #[arg(long)]
    json: bool,
    /// Show no progress
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn bench(arguments: &Arguments) -> Result<(), CliError> {
    let precision = arguments.precision.and_then(PrecisionFlag::wish);
    let wish = MachineWish { precision, ..arguments.machine.wish() };
    let (machine, passed_over) = Machine::open(&wish)?;
    let options = BenchOptions {
        precisions: precision.map_or_else(|| machine.precisions(), |precision| vec![precision]),
        paths: paths(arguments.path),
        sizes: ascending(&arguments.sizes, u64::cmp),
        dimensions: ascending(&arguments.dimension, u64::cmp).iter().map(|&d| d as usize).collect(),
        support_ratios: ascending(&arguments.support_ratio, f64::total_cmp),
        least: Duration::from_secs_f64(arguments.seconds),
        most_setup: Duration::from_secs_f64(arguments.setup_seconds),
        machine: &machine,
    };
    let monitor = Monitor::new(arguments.quiet)?;
    let result = study::bench(&options, &mut |progress| {
        monitor.at(progress.done, progress.all, progress.what)
    });
    monitor.finish();
    let mut outcome = result?;
    outcome.report.warnings.extend(passed_over);
    if arguments.json {
        print_json(&outcome.report)?;
    } else {
        print(outcome.report.table())?;
    }
    if outcome.interrupted { Err(CliError::Interrupted) } else { Ok(()) }
}

/// The paths in the order in which they are measured: the one with less to set up first.
fn paths(flag: Option<PathFlag>) -> Vec<PathWish> {
    match flag.map(PathFlag::wish) {
        None | Some(PathWish::Auto) => vec![PathWish::Lattice, PathWish::List],
        Some(path) => vec![path],
    }
}

/// The values in order, each once.
fn ascending<T: Copy + PartialEq>(
    values: &[T],
    order: impl FnMut(&T, &T) -> std::cmp::Ordering,
) -> Vec<T> {
    let mut values = values.to_vec();
    values.sort_by(order);
    values.dedup();
    values
}

fn size(text: &str) -> Result<u64, String> {
    let size: f64 = text.trim().parse().map_err(|_| "not a number, such as 1e6".to_owned())?;
    if size.fract() != 0.0 || !(LEAST_SIZE as f64..1e15).contains(&size) {
        return Err(format!("a size is a whole number of particles, {LEAST_SIZE} at least"));
    }
    Ok(size as u64)
}

fn support_ratio(text: &str) -> Result<f64, String> {
    between(text, 1.0, WIDEST)
}

fn seconds(text: &str) -> Result<f64, String> {
    between(text, 0.0, LONGEST)
}

/// A number above `above` and at most `most`.
fn between(text: &str, above: f64, most: f64) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| "not a number".to_owned())?;
    let allowed = number > above && number <= most;
    allowed.then_some(number).ok_or_else(|| format!("not above {above} and at most {most}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_whole_and_not_too_small() {
        assert_eq!(["1e4", "1000", " 2500000"].map(size), [Ok(10_000), Ok(1000), Ok(2_500_000)]);
        for text in ["999", "1e-4", "-1e5", "1000.5", "many", "inf", "nan", "1e15", ""] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn values_are_measured_once_and_in_order() {
        assert_eq!(ascending(&[5, 2, 5, 1], u32::cmp), [1, 2, 5]);
        assert_eq!(ascending(&[3.0, 2.0], f64::total_cmp), [2.0, 3.0]);
    }
}
