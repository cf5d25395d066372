//! The command line: one file a subcommand, flags turned into validated wishes, errors into exit
//! codes.

mod arguments;
mod bench;
mod cases;
mod check;
mod devices;
mod progress;
mod run;
mod stability;
mod study;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::case;
use crate::study::RunError;

/// Smoothed particle hydrodynamics for diffusion, on the GPU and on the CPU.
#[derive(Debug, Parser)]
#[command(
    name = "diffusph",
    version,
    about,
    after_help = "Examples:\n  diffusph run gaussian_small\n  diffusph run my_case.json --backend \
                  gpu --out results\n  diffusph check gaussian --set particles.spacing=1\n\nExit \
                  codes: 0 done; 1 the run failed; 2 bad case or usage."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Solve a case and report its error beside its run time
    Run(run::Arguments),
    /// Show what a run would do, without solving: particles, memory, step, path, what is left out
    Check(check::Arguments),
    /// Report error against run time over many settings: tables, plots, and which one to run
    Study(study::Arguments),
    /// Measure the throughput beside what the memory and the processor can do at most
    Bench(bench::Arguments),
    /// Find where methods, steps and precisions break, and what holds
    Stability(stability::Arguments),
    /// List the shipped cases, or print one
    Cases(cases::Arguments),
    /// List the GPU adapters, and say which one `--backend auto` would take
    Devices(devices::Arguments),
    /// Print the JSON Schema of the case file
    #[command(after_help = "Example:\n  diffusph schema > case.schema.json")]
    Schema,
    /// Print a completion script for a shell
    #[command(
        after_help = "Example:\n  diffusph completions bash > /etc/bash_completion.d/diffusph"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
enum CliError {
    #[error("{0}")]
    Case(#[from] case::CaseError),
    #[error("{0}")]
    Run(#[from] RunError),
    #[error("{0}")]
    Study(#[from] crate::study::StudyError),
    #[error("no setting has a result: {why}")]
    NothingRan { why: String },
    #[error("--with: {}: {why}", .path.display())]
    Peers { path: std::path::PathBuf, why: String },
    #[error("cannot find the program itself: {0}")]
    OwnProgram(io::Error),
    #[error("{0}")]
    Files(crate::report::OutputError),
    #[error("--out: {0}")]
    Folder(crate::report::OutputError),
    #[error("--out: the run would overwrite its own case {}; choose another folder", .path.display())]
    OverwritesCase { path: std::path::PathBuf },
    #[error("cannot write to standard output: {0}")]
    Stdout(#[from] io::Error),
    #[error("cannot write the report as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("cannot catch Ctrl-C: {0}")]
    Interrupt(#[from] ctrlc::Error),
    #[error("{count} of the promises of the documentation did not hold; see the report")]
    Broken { count: usize },
    #[error("interrupted: what had been measured by then is in the report")]
    Interrupted,
}

impl From<crate::solver::SolverError> for CliError {
    fn from(error: crate::solver::SolverError) -> Self {
        Self::Run(error.into())
    }
}

impl CliError {
    /// 2 where the case or the flags are at fault, 1 where the run failed.
    fn exit_code(&self) -> u8 {
        match self {
            Self::Case(_) | Self::Folder(_) | Self::OverwritesCase { .. } | Self::Peers { .. } => 2,
            Self::Study(error) if error.is_usage() => 2,
            Self::Run(error) if error.is_usage() => 2,
            Self::Run(_)
            | Self::Study(_)
            | Self::NothingRan { .. }
            | Self::OwnProgram(_)
            | Self::Files(_)
            | Self::Stdout(_)
            | Self::Json(_)
            | Self::Interrupt(_)
            | Self::Broken { .. }
            | Self::Interrupted => 1,
        }
    }
}

/// Runs the command of this process.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match cli.command {
        Command::Run(arguments) => in_pool(|| run::run(&arguments)),
        Command::Check(arguments) => in_pool(|| check::check(&arguments)),
        Command::Study(arguments) => study::study(&arguments),
        Command::Bench(arguments) => in_pool(|| bench::bench(&arguments)),
        Command::Stability(arguments) => in_pool(|| stability::stability(&arguments)),
        Command::Cases(arguments) => cases::cases(&arguments),
        Command::Devices(arguments) => devices::devices(&arguments),
        Command::Schema => schema(),
        Command::Completions { shell } => completions(shell),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of a pipe left: nothing is wrong, and nobody is there to be told.
        Err(CliError::Stdout(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(error) => {
            // Nothing can be done where standard error is closed.
            let _ = writeln!(io::stderr(), "diffusph: {}", with_causes(&error));
            ExitCode::from(error.exit_code())
        }
    }
}

/// Does the work of a command on a thread of the pool: one outside would wake the pool for every loop and wait for it.
fn in_pool(work: impl FnOnce() -> Result<(), CliError> + Send) -> Result<(), CliError> {
    rayon::scope(|_| work())
}

/// The error and what caused it, in one line.
fn with_causes(error: &CliError) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        let reason = error.to_string();
        // A transparent error repeats its cause.
        if !text.contains(&reason) {
            text = format!("{text}: {reason}");
        }
        cause = error.source();
    }
    text
}

/// Tells the user something before a command goes on.
fn warn(text: &str) {
    // Nothing can be done where standard error is closed.
    let _ = writeln!(io::stderr(), "diffusph: warning: {text}");
}

/// Prints a line, or text that ends with one.
fn print(text: impl AsRef<str>) -> Result<(), CliError> {
    let text = text.as_ref();
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    if !text.ends_with('\n') {
        out.write_all(b"\n")?;
    }
    Ok(out.flush()?)
}

fn print_json(value: &impl serde::Serialize) -> Result<(), CliError> {
    print(serde_json::to_string_pretty(value)?)
}

fn schema() -> Result<(), CliError> {
    print_json(&case::schema())
}

fn completions(shell: clap_complete::Shell) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "diffusph", &mut script);
    print(String::from_utf8_lossy(&script))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
