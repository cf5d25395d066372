//! `diffusph stability`: where methods, steps and precisions break, and what holds.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{MachineArguments, PrecisionFlag};
use super::progress::Monitor;
use super::{CliError, print, print_json};
use crate::case::{self, Override, Scene};
use crate::model::KernelKind;
use crate::report::OutputFolder;
use crate::solver::{Machine, MachineWish};
use crate::study::{self, StabilityOptions, StabilityOutcome, Tampering};

/// The widest support.
const WIDEST: f64 = 10.0;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  diffusph stability --quick\n  diffusph stability --kernel \
                        wendland_c4 --support-ratio 3,4 --dimension 3\n  diffusph stability \
                        gaussian_small --out stability_of_gaussian\n  diffusph stability --backend \
                        gpu --precision f32\n\nWithout a case: the growth of the fastest mode over \
                        the step of explicit Euler on lattices, and extreme scenes in every method. \
                        Exit codes: 0 every promise of the README held; 1 one did not, or the study \
                        was stopped; 2 bad case or usage.")]
pub(super) struct Arguments {
    /// A case file, or the name of a shipped case: the step and every method on that scene alone
    case: Option<String>,
    /// Change a value of the case, as for `diffusph run`
    #[arg(long, value_name = "PATH=VALUE", requires = "case")]
    set: Vec<String>,
    #[command(flatten)]
    machine: MachineArguments,
    /// The precision beside f64 on the CPU [default: every one that the GPU has]
    #[arg(long, value_enum)]
    precision: Option<PrecisionFlag>,
    /// Kernels of the lattices [default: all; with --quick the cubic spline]
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = kernel)]
    kernel: Vec<KernelKind>,
    /// Support radii of the lattices over their spacing, H/dx [default: 2,3; with --quick 2]
    #[arg(long, value_name = "RATIO", value_delimiter = ',', value_parser = support_ratio)]
    support_ratio: Vec<f64>,
    /// Dimensions of the lattices [default: 1,2,3]
    #[arg(long, value_name = "DIM", value_delimiter = ',',
        value_parser = clap::value_parser!(u64).range(1..=3))]
    dimension: Vec<u64>,
    /// Leave out what takes long: done within a minute on two cores
    #[arg(long)]
    quick: bool,
    /// The output folder [default: out/stability, or out/stability_CASE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print stability.json to standard output, and nothing else there
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn stability(arguments: &Arguments) -> Result<(), CliError> {
    let scene = scene(arguments)?;
    let (machines, passed_over) = machines(arguments)?;
    let (kernels, support_ratios, dimensions) = StabilityOptions::default_lattices(arguments.quick);
    let dimension: Vec<usize> = arguments.dimension.iter().map(|&of| of as usize).collect();
    let options = StabilityOptions {
        scene: scene.as_ref(),
        machines,
        kernels: given(&arguments.kernel, kernels),
        support_ratios: given(&arguments.support_ratio, support_ratios),
        dimensions: given(&dimension, dimensions),
        quick: arguments.quick,
        tampering: Tampering::NONE,
        command: command(),
    };
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = scene.as_ref().map(|scene| format!("stability_{}", scene.name));
        PathBuf::from("out").join(name.as_deref().unwrap_or("stability"))
    });
    let folder = OutputFolder::create(folder).map_err(CliError::Folder)?;
    let monitor = Monitor::new(arguments.quiet || arguments.json)?;
    let result = study::stability(&options, &mut |progress| match progress.all {
        0 => monitor.flow(),
        all => monitor.at(progress.done, all, progress.what),
    });
    monitor.finish();
    let mut outcome = match result {
        Ok(outcome) => outcome,
        Err(error) => {
            folder.abandon();
            return Err(error.into());
        }
    };
    outcome.report.warnings.extend(passed_over);
    outcome.report.write(&folder).map_err(study::RunError::from)?;
    if arguments.json {
        print_json(&outcome.report)?;
    } else if !arguments.quiet {
        print(outcome.report.table() + &format!("\nfiles  {}\n", folder.path().display()))?;
    }
    conclude(&outcome)
}

/// The case, if there is one, with every override applied.
fn scene(arguments: &Arguments) -> Result<Option<Scene>, CliError> {
    let Some(case) = &arguments.case else {
        return Ok(None);
    };
    let overrides = arguments.set.iter().map(|text| Override::parse(text));
    Ok(Some(case::load(case, &overrides.collect::<Result<Vec<_>, _>>()?)?))
}

/// What the study comes to.
fn conclude(outcome: &StabilityOutcome) -> Result<(), CliError> {
    if outcome.interrupted {
        return Err(CliError::Interrupted);
    }
    match outcome.report.broken.len() {
        0 => Ok(()),
        count => Err(CliError::Broken { count }),
    }
}

/// The GPU in every precision that is asked for, and why it was passed over, if it was.
fn machines(arguments: &Arguments) -> Result<(Vec<Machine>, Option<String>), CliError> {
    let precision = arguments.precision.and_then(PrecisionFlag::wish);
    let wish = MachineWish { precision, ..arguments.machine.wish() };
    let (machine, passed_over) = Machine::open(&wish)?;
    let machines = match machine {
        Machine::Cpu => Vec::new(),
        Machine::Gpu { .. } => {
            let precisions = precision.map_or_else(|| machine.precisions(), |of| vec![of]);
            precisions.into_iter().map(|of| machine.in_precision(of)).collect()
        }
    };
    Ok((machines, passed_over))
}

/// What is given, or the default where nothing is.
fn given<T: Clone>(given: &[T], default: Vec<T>) -> Vec<T> {
    if given.is_empty() { default } else { given.to_vec() }
}

/// The command of this process, as typed.
fn command() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("diffusph {}", arguments.join(" "))
}

fn kernel(text: &str) -> Result<KernelKind, String> {
    let found = KernelKind::ALL.into_iter().find(|kernel| kernel.name() == text.trim());
    found.ok_or_else(|| {
        let names = KernelKind::ALL.map(KernelKind::name);
        format!("no such kernel; there are {}", names.join(", "))
    })
}

fn support_ratio(text: &str) -> Result<f64, String> {
    let ratio: f64 = text.trim().parse().map_err(|_| "not a number".to_owned())?;
    let allowed = ratio > 1.0 && ratio <= WIDEST;
    allowed.then_some(ratio).ok_or_else(|| format!("not above 1 and at most {WIDEST}"))
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;

    /// What the study of a line comes to whose runs have a kernel wrong by `kernel_factor`.
    fn outcome(kernel_factor: f64) -> StabilityOutcome {
        let options = StabilityOptions {
            scene: None,
            machines: Vec::new(),
            kernels: vec![KernelKind::CubicSpline],
            support_ratios: vec![2.0],
            dimensions: vec![1],
            quick: true,
            tampering: Tampering { kernel_factor },
            command: String::new(),
        };
        // The lattices alone, as if there were no more.
        let result = study::stability(&options, &mut |progress| match progress.done {
            0 | 1 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        });
        let outcome = result.unwrap_or_else(|error| panic!("{error}"));
        assert!(outcome.interrupted && outcome.report.scans.len() == 2);
        StabilityOutcome { interrupted: false, ..outcome }
    }

    #[test]
    fn a_broken_promise_ends_with_1_and_so_does_a_stop() {
        assert!(conclude(&outcome(1.0)).is_ok());
        let broken = conclude(&outcome(1.02)).expect_err("the limit is off");
        assert!(matches!(broken, CliError::Broken { count: 2.. }), "{broken}");
        assert_eq!(broken.exit_code(), 1);
        let stopped = StabilityOutcome { interrupted: true, ..outcome(1.0) };
        let stopped = conclude(&stopped).expect_err("it was stopped");
        assert_eq!(stopped.exit_code(), 1);
    }

    #[test]
    fn kernels_and_supports_are_checked() {
        assert_eq!(kernel(" lucy"), Ok(KernelKind::Lucy));
        assert!(kernel("gauss").is_err_and(|error| error.contains("wendland_c6")));
        assert_eq!(support_ratio("2.4"), Ok(2.4));
        assert!(["1", "11", "nan", "x"].iter().all(|text| support_ratio(text).is_err()));
    }
}
