//! `diffusph run`: solve a case.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::arguments::{CaseArguments, WayArguments};
use super::progress::Monitor;
use super::{CliError, print, print_json, warn};
use crate::case::Scene;
use crate::report::OutputFolder;
use crate::solver::{Machine, Opened};
use crate::study::{self, Outcome, RunOptions};

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  diffusph run gaussian_small\n  diffusph run gaussian --set \
                        operator.correction=moment --out corrected\n  diffusph run gaussian_small \
                        --backend gpu --json | jq .error\n  diffusph run constant_column \
                        --method tr_bdf2 --set time.tolerance.relative=1e-4\n\nThe folder has the \
                        fields (series.pvd), report.json, case.json, probes.csv and probes.svg, \
                        profile.svg, and front.csv and front.svg where the scene melts.")]
pub(super) struct Arguments {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    way: WayArguments,
    /// The output folder [default: out/CASE]
    #[arg(long, value_name = "DIR", conflicts_with = "no_output")]
    out: Option<PathBuf>,
    /// Write no files
    #[arg(long)]
    no_output: bool,
    /// Run also with a step above the measured stability limit
    #[arg(long)]
    allow_unstable: bool,
    /// Print report.json to standard output, and nothing else there
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), CliError> {
    let started = Instant::now();
    let mut scene = arguments.case.load()?;
    let Opened { machine, why_precision, warnings } =
        Machine::open_for(&arguments.way.wish(), &scene.problem)?;
    let monitor = Monitor::new(arguments.quiet || arguments.json)?;
    if !arguments.quiet {
        // The summary repeats them, but the run may be long.
        warnings.iter().for_each(|warning| warn(warning));
    }
    scene.warnings.extend(warnings);
    let folder = folder(arguments, &scene)?;
    let options = RunOptions {
        machine: &machine,
        why_precision,
        path: arguments.way.path(),
        allow_unstable: arguments.allow_unstable,
        folder: folder.as_ref(),
        started,
    };
    let result = study::run(&scene, &options, &mut |progress| monitor.update(progress));
    monitor.finish();
    match result {
        Ok(outcome) => show(arguments, folder, outcome),
        Err(error) => {
            if let Some(folder) = folder {
                folder.abandon();
            }
            Err(error.into())
        }
    }
}

fn folder(arguments: &Arguments, scene: &Scene) -> Result<Option<OutputFolder>, CliError> {
    if arguments.no_output {
        return Ok(None);
    }
    let path = arguments.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&scene.name));
    let written = path.join("case.json");
    if same_file(Path::new(&arguments.case.case), &written) {
        return Err(CliError::OverwritesCase { path: written });
    }
    OutputFolder::create(path).map(Some).map_err(CliError::Folder)
}

/// Whether both are there and are one file.
fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

fn show(
    arguments: &Arguments,
    folder: Option<OutputFolder>,
    outcome: Outcome,
) -> Result<(), CliError> {
    let shown = if arguments.json {
        print_json(&outcome.report)
    } else if arguments.quiet {
        Ok(())
    } else {
        let files = folder.map(|folder| format!("  files     {}\n", folder.path().display()));
        print(outcome.report.summary() + &files.unwrap_or_default())
    };
    match outcome.stopped {
        Some(error) => Err(error.into()),
        None => shown,
    }
}
