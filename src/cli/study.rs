//! `diffusph study`: error against run time.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::arguments::{CaseArguments, WayArguments};
use super::progress::Monitor;
use super::{CliError, print, print_json, warn};
use crate::report::study::Peers;
use crate::report::{OutputFolder, StudyReport};
use crate::solver::Machine;
use crate::study::{self, StudyOptions, Vary};

/// The most runs of a setting.
const MOST_RUNS: u64 = 1000;

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  diffusph study gaussian_small\n  diffusph study gaussian --vary \
                        spacing=2,1,0.5 --vary correction=none,moment\n  diffusph study \
                        constant_column --vary method=rkl2,tr_bdf2 --vary tolerance=1e-2,1e-3,1e-4 \
                        --budget 5min\n  diffusph study gaussian --with peers.json --out \
                        study\n\nEvery combination of what is varied runs in a process of its own, \
                        cheap ones first, then again while there is time. The folder has study.csv, \
                        study.json, study.html (one file that needs nothing else) and its pictures as \
                        SVG."
)]
pub(super) struct Arguments {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    way: WayArguments,
    /// What is varied: spacing, support_ratio, kernel, correction, pair_mean, method, step, tolerance,
    /// backend, precision, path, or the path of a key in the case. Values are written as for --set
    /// [default: a sweep that suits the case]
    #[arg(long, value_name = "NAME=V1,V2,...")]
    vary: Vec<String>,
    /// How often each setting runs; a short first run warms up, and does not count
    #[arg(long, value_name = "N", default_value = "3",
        value_parser = clap::value_parser!(u64).range(1..=MOST_RUNS))]
    repeat: u64,
    /// The time allowed: 90, 90s, 500ms, 5min or 2h. Settings for which it is too short are listed
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = "60s")]
    budget: Duration,
    /// Add what other programs took for the same problem: a file as benches/peers.py writes it
    #[arg(long = "with", value_name = "PEERS.JSON")]
    peers: Option<PathBuf>,
    /// The output folder [default: out/study/CASE]
    #[arg(long, value_name = "DIR", conflicts_with = "no_output")]
    out: Option<PathBuf>,
    /// Write no files
    #[arg(long)]
    no_output: bool,
    /// Print study.json to standard output, and nothing else there
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn study(arguments: &Arguments) -> Result<(), CliError> {
    let vary = arguments.vary.iter().map(|text| Vary::parse(text));
    let vary = vary.collect::<Result<Vec<_>, _>>()?;
    let peers = arguments.peers.as_deref().map(read_peers).transpose()?;
    let (machine, passed_over) = Machine::open(&arguments.way.wish())?;
    let options = StudyOptions {
        program: std::env::current_exe().map_err(CliError::OwnProgram)?,
        set: arguments.case.changes(),
        flags: arguments.way.flags(machine.kind().backend_name()),
        vary,
        repeat: arguments.repeat as usize,
        budget: arguments.budget,
        machine: study::study_machine(&machine),
        peers,
        ..StudyOptions::new(&arguments.case.case)
    };
    // Each setting opens the device for itself.
    drop(machine);
    let folder = folder(arguments)?;
    let monitor = Monitor::new(arguments.quiet)?;
    let result = study::study(&options, &mut |progress| {
        monitor.at(progress.done, progress.all, progress.what)
    });
    monitor.finish();
    let mut report = match result {
        Ok(report) => report,
        Err(error) => {
            folder.into_iter().for_each(OutputFolder::abandon);
            return Err(error.into());
        }
    };
    report.remarks.extend(passed_over);
    show(arguments, folder.as_ref(), &report)?;
    match (report.interrupted, report.measured().next()) {
        (true, _) => Err(CliError::Interrupted),
        (false, None) => Err(CliError::NothingRan { why: why_nothing(&report) }),
        (false, Some(_)) => Ok(()),
    }
}

fn folder(arguments: &Arguments) -> Result<Option<OutputFolder>, CliError> {
    if arguments.no_output {
        return Ok(None);
    }
    let name = Path::new(&arguments.case.case).file_stem().unwrap_or_default();
    let path = arguments.out.clone().unwrap_or_else(|| Path::new("out/study").join(name));
    OutputFolder::create(path).map(Some).map_err(CliError::Folder)
}

/// Writes the files and prints the table.
fn show(
    arguments: &Arguments,
    folder: Option<&OutputFolder>,
    report: &StudyReport,
) -> Result<(), CliError> {
    if let Some(folder) = folder {
        report.write(folder).map_err(CliError::Files)?;
    }
    if arguments.json {
        return print_json(report);
    }
    if arguments.quiet {
        return Ok(());
    }
    let page = folder.map(|folder| folder.path().join("study.html"));
    let files = page.map(|page| format!("page  {}\n", page.display())).unwrap_or_default();
    print(report.table() + &files)
}

/// Why a study has no results.
fn why_nothing(report: &StudyReport) -> String {
    let failure = report.points.iter().find_map(|point| point.failure.clone());
    let skipped = report.skipped.first().map(|of| format!("{}: {}", of.label, of.why));
    failure.or(skipped).unwrap_or_default()
}

fn read_peers(path: &Path) -> Result<Peers, CliError> {
    let failed = |why: String| CliError::Peers { path: path.to_owned(), why };
    let text = fs::read_to_string(path).map_err(|error| failed(error.to_string()))?;
    let peers = Peers::parse(&text).map_err(failed)?;
    if peers.points.is_empty() {
        warn(&format!("{}: has no points", path.display()));
    }
    Ok(peers)
}

/// `90`, `90s`, `500ms`, `5min` or `2h` as a duration.
fn duration(text: &str) -> Result<Duration, String> {
    const UNITS: [(&str, f64); 5] =
        [("ms", 1e-3), ("min", 60.0), ("s", 1.0), ("h", 3600.0), ("", 1.0)];
    /// A year.
    const LONGEST: f64 = 3.2e7;
    let text = text.trim();
    let read = UNITS.iter().find_map(|(unit, seconds)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        Some(number * seconds)
    });
    match read {
        Some(seconds) if seconds > 0.0 && seconds <= LONGEST => {
            Ok(Duration::from_secs_f64(seconds))
        }
        Some(_) => Err("a time is above 0 and at most a year".to_owned()),
        None => Err("not a time, such as 90s, 500ms, 5min or 2h".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        let seconds = |text| duration(text).map(|of| of.as_secs_f64());
        for (text, expected) in
            [("90", 90.0), ("1.5s", 1.5), ("500ms", 0.5), ("5 min", 300.0), ("2h", 7200.0)]
        {
            assert_eq!(seconds(text), Ok(expected), "{text}");
        }
        for text in ["", "s", "0", "-1s", "inf", "nan", "5 weeks", "1e9h"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
