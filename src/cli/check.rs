//! `diffusph check`: what a run would do.

use std::fmt::Write;

use clap::Args;

use super::arguments::{CaseArguments, WayArguments};
use super::{CliError, print};
use crate::case::Scene;
use crate::model::integrator::{Method, Schedule, Tolerance};
use crate::model::{Problem, Source, Surface, Wall};
use crate::report::format::{bytes, grouped, significant, simulated_time};
use crate::solver::{Machine, Opened, PathChoice, Step};
use crate::study::{self, Prepared};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  diffusph check gaussian --set particles.spacing=1")]
pub(super) struct Arguments {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    way: WayArguments,
    /// Accept a step above the measured stability limit
    #[arg(long)]
    allow_unstable: bool,
}

pub(super) fn check(arguments: &Arguments) -> Result<(), CliError> {
    let mut scene = arguments.case.load()?;
    let Opened { machine, why_precision, warnings } =
        Machine::open_for(&arguments.way.wish(), &scene.problem)?;
    scene.warnings.extend(warnings);
    let problem = &scene.problem;
    let choice = PathChoice::new(problem, machine.kind(), arguments.way.path())?;
    let (prepared, _) =
        study::prepare(problem, machine.kind(), choice, arguments.allow_unstable, false)?;
    let prepared = prepared.within_memory(problem, &machine);
    print(describe(&scene, &prepared, machine.adapter(), why_precision.as_deref()))
}

fn describe(
    scene: &Scene,
    prepared: &Prepared,
    adapter: Option<&str>,
    why_precision: Option<&str>,
) -> String {
    let Prepared { survey, step, plan } = prepared;
    let problem = &scene.problem;
    let limits = &step.limits;
    let particles = problem.particles.len() as u64;
    let [dt, steps] = steps(problem, step);
    let of_vectors = step.vectors() * particles * plan.machine.precision().state_bytes();
    let held = problem.held.len() as u64;
    let neighbors = survey.entries as f64 / particles.max(1) as f64;
    let mut lines = vec![
        ("case", format!("{}: {}", scene.name, scene.title)),
        (
            "particles",
            format!("{} in {}-D, {} held", grouped(particles), problem.dimension, grouped(held)),
        ),
        ("neighbours", format!("{} a particle", significant(neighbors, 4))),
        (
            "kernel",
            format!("{}, H = {} m", problem.kernel.kind().name(), problem.kernel.support_radius()),
        ),
        (
            "machine",
            format!(
                "{}{}, {}{}",
                plan.machine.backend_name(),
                adapter.map(|a| format!(" ({a})")).unwrap_or_default(),
                plan.machine.precision().name(),
                why_precision.map(|why| format!(": {why}")).unwrap_or_default()
            ),
        ),
        ("path", plan.path_in_words(problem)),
        ("memory", bytes(plan.memory_bytes(problem, survey.entries) + of_vectors)),
        ("duration", simulated_time(problem.time.end)),
        ("method", method(step)),
        ("step", dt),
        ("steps", steps),
        (
            "limits",
            format!(
                "(116) {}, (117) {}, safe {}{}",
                seconds(limits.report.cfl),
                seconds(limits.report.cfl_third),
                seconds(limits.safe),
                limits.measured.map(|m| format!(", measured {}", seconds(m))).unwrap_or_default()
            ),
        ),
        ("passes", plan.passes(problem).join(", ")),
    ];
    if !(problem.walls.is_empty() && problem.surfaces.is_empty()) {
        let matrix = match survey.symmetric {
            true => "symmetric",
            false => "not symmetric: convection reaches past the first layer of particles",
        };
        lines.insert(3, ("walls", walls(problem)));
        lines.insert(4, ("matrix", matrix.to_owned()));
    }
    if !problem.sources.is_empty() {
        let place = if problem.walls.is_empty() && problem.surfaces.is_empty() { 3 } else { 4 };
        lines.insert(place, ("sources", sources(problem)));
    }
    let mut text = String::new();
    for (name, value) in lines {
        let _ = writeln!(text, "{name:<11}{value}");
    }
    for left in &plan.left_out {
        let _ = writeln!(
            text,
            "left out   {}: {} ({} saved)",
            left.what,
            left.why,
            bytes(left.bytes_saved)
        );
    }
    for warning in scene.warnings.iter().chain(&step.warnings) {
        let _ = writeln!(text, "warning    {warning}");
    }
    text
}

fn seconds(s: f64) -> String {
    if s.is_finite() { format!("{} s", significant(s, 6)) } else { "no limit".to_owned() }
}

fn method(step: &Step) -> String {
    let why = step.why_method.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
    format!("{}{why}", step.method.name())
}

/// The step and the number of steps, in words.
fn steps(problem: &Problem, step: &Step) -> [String; 2] {
    match (step.method, step.tolerance) {
        (Method::Steady, _) => ["none: straight to the steady state".to_owned(), "0".to_owned()],
        (_, Some(Tolerance { absolute, relative })) => {
            let first = format!("from {}", seconds(step.dt));
            let follows = match (absolute > 0.0, relative > 0.0) {
                (true, true) => format!("{absolute:e} + {relative:e} of the largest value"),
                (true, false) => format!("{absolute:e}"),
                _ => format!("{relative:e} of the largest value"),
            };
            [first, format!("as many as a tolerance of {follows} needs")]
        }
        (_, None) => {
            let count = Schedule::new(&problem.time, step.dt).total_steps();
            [seconds(step.taken(problem)), grouped(count)]
        }
    }
}

/// The sources of a scene in a line.
fn sources(problem: &Problem) -> String {
    let source = |source: &Source| {
        let place = match &source.particles {
            None => "everywhere".to_owned(),
            Some(particles) => format!("on {} particles", grouped(particles.len() as u64)),
        };
        let linear = match source.linear.as_constant() {
            Some(0.0) => String::new(),
            _ => format!(" + ({}) x value", source.linear.text()),
        };
        format!("{}{linear} {place}", source.rate.text())
    };
    problem.sources.iter().map(source).collect::<Vec<_>>().join(", ")
}

/// The walls and surfaces of a scene in a line.
fn walls(problem: &Problem) -> String {
    let wall = |wall: &Wall| {
        let part = if wall.covers.is_some() { " (part)" } else { "" };
        format!("{}{part} {}", wall.face.name(), wall.condition.kind.name())
    };
    let surface = |surface: &Surface| format!("surface {}", surface.condition.kind.name());
    let walls = problem.walls.iter().map(wall);
    walls.chain(problem.surfaces.iter().map(surface)).collect::<Vec<_>>().join(", ")
}
