//! What steps of an enthalpy cost beside steps of plain conduction.
//!
//! The scenes of a group take explicit Euler steps in turn, a few at a time, so that a machine that others use too is as
//! fast for one as for another. What is printed is the median over the rounds: of the time of a particle and step, of how
//! many times that of the group's first scene in the same round it is, and of the same beside the scene that differs from
//! it in that nothing melts. The fronts of the cubes stay in one layer of particles meanwhile.
//!
//! ```text
//! cargo bench --bench melting
//! cargo bench --bench melting -- --path list --particles 1e5 cube
//! ```

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "what a bench is for")]

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, ValueEnum};
use diffusph::case::{self, Scene};
use diffusph::report::study::Spread;
use diffusph::solver::{
    Backend, BackendWish, Machine, MachineWish, Path, PathChoice, PathWish, Precision,
};
use diffusph::study::{self, Driver, Prepared};
use serde_json::{Map, Value, json};

/// What is run.
#[derive(Parser)]
struct Arguments {
    /// Only groups whose name contains this
    group: Option<String>,
    /// On a GPU, or a software adapter, not on the CPU
    #[arg(long)]
    gpu: bool,
    /// The precision on a GPU: f32, compensated or f64
    #[arg(long, value_parser = precision, requires = "gpu")]
    precision: Option<Precision>,
    /// How neighbours are known
    #[arg(long, default_value = "lattice")]
    path: PathName,
    /// Particles of a scene, about
    #[arg(long, default_value_t = 1e6, value_parser = particles)]
    particles: f64,
    /// How often each scene has its turn
    #[arg(long, default_value_t = 21, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Steps of a turn
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Given by cargo
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum PathName {
    Lattice,
    List,
}

fn particles(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|count| (1e3..1e9).contains(count));
    found.ok_or_else(|| "a number from 1e3 to 1e9".to_owned())
}

fn precision(name: &str) -> Result<Precision, String> {
    let found = Precision::ALL.into_iter().find(|precision| precision.name() == name);
    found.ok_or_else(|| "f32, compensated or f64".to_owned())
}

/// Steps that are taken before the first round.
const STEPS_BEFORE: u64 = 400;

/// Scenes that are compared with the first.
struct Group {
    name: &'static str,
    entries: Vec<Entry>,
}

/// A scene of a group.
struct Entry {
    name: &'static str,
    case: Value,
    /// The name of the scene that differs from it in that nothing melts.
    unmelted: &'static str,
}

/// The groups, of about so many particles a scene.
fn groups(particles: f64) -> [Group; 4] {
    // Steps of a part of spacing^2 / alpha, with the largest alpha (m2/s) of the case.
    let steps_of = |part: f64, spacing: f64, alpha: f64| {
        let step = part * spacing * spacing / alpha;
        json!({ "end": 1e9 * step, "method": "euler", "step": step })
    };
    // Length (m) of the rod, roots of the areas of the others.
    let (rod, pipe, track) = (0.4 / particles, 0.1 / particles.sqrt(), 1.7e-3 / particles.sqrt());
    [
        cube(0.5 / (0.5 * particles.cbrt()).round()),
        shipped("melting_rod", rod, |case| case["time"] = steps_of(0.2, rod, 1.28e-4)),
        shipped("freezing_pipe", pipe, |case| case["time"] = steps_of(0.1, pipe, 1.15e-6)),
        shipped("laser_track", track, |case| {
            case["time"] = steps_of(0.05, track, 7.6e-6);
            // A molten layer, since the laser would take longer than the rounds.
            case["sources"] = json!([]);
            let layer = json!({ "box": { "min": [0, 0.0009], "max": [0.003, 0.001] } });
            case["initial"] = json!([{ "value": 300 }, { "value": 2000, "where": layer }]);
        }),
    ]
}

/// Cubes with an even number of particles along an edge, of which one half is hot. Where it meets the other there is a
/// front all over the cross-section, and there two materials meet if there are two.
fn cube(spacing: f64) -> Group {
    let solid = |conductivity: Value| json!({ "conductivity": conductivity, "density": 1000, "heat_capacity": 1 });
    let melting = |mut solid: Value, at: Value| {
        solid["melting_temperature"] = at;
        solid["latent_heat"] = json!(100);
        solid["liquid"] = json!({ "conductivity": 4 });
        solid
    };
    let half = |axis: usize, from: f64, to: f64| {
        let (mut min, mut max) = ([0.0; 3], [1.0; 3]);
        (min[axis], max[axis]) = (from, to);
        json!({ "box": { "min": min, "max": max } })
    };
    let case = |axis: usize, first: Value, second: Option<Value>| {
        let (hot, cold) = (half(axis, 0.0, 0.5), half(axis, 0.5, 1.0));
        let of_cold = if second.is_some() { "second" } else { "first" };
        let materials = [("first", Some(first)), ("second", second)];
        let materials = materials.into_iter().filter_map(|(name, of)| Some((name.into(), of?)));
        json!({
            "title": "A cube of which one half is hot",
            "dimension": 3,
            "particles": {
                "spacing": spacing,
                "fill": [
                    { "shape": hot, "material": "first" },
                    { "shape": cold, "material": of_cold },
                ],
            },
            "kernel": { "name": "cubic_spline", "support_ratio": 2 },
            "materials": materials.collect::<Map<String, Value>>(),
            "initial": [{ "value": 300 }, { "value": 360, "where": hot }],
            "time": { "end": 1e3, "method": "euler", "step": 10.0 * spacing * spacing },
        })
    };
    let plain = || solid(json!(10));
    let other = || solid(json!(6));
    let rising = || solid(json!([[300, 10], [700, 14]]));
    let other_rising = || solid(json!([[300, 6], [700, 7]]));
    let at = || json!(330);
    let other_melting = || melting(other(), json!(335));
    let entry = |name, unmelted, case| Entry { name, case, unmelted };
    Group {
        name: "cube, 26 neighbours",
        entries: vec![
            entry("plain", "plain", case(0, plain(), None)),
            entry("nothing melts yet", "plain", case(0, melting(plain(), json!(900)), None)),
            entry("a front across lines", "plain", case(0, melting(plain(), at()), None)),
            entry("a front along lines", "plain", case(2, melting(plain(), at()), None)),
            entry("over a range", "plain", case(0, melting(plain(), json!([320, 340])), None)),
            entry("k(T)", "k(T)", case(0, rising(), None)),
            entry("k(T), a front", "k(T)", case(0, melting(rising(), at()), None)),
            entry("two", "two", case(0, plain(), Some(other()))),
            entry("two, a front", "two", case(0, melting(plain(), at()), Some(other_melting()))),
            entry("two with k(T)", "two with k(T)", case(0, rising(), Some(other_rising()))),
        ],
    }
}

/// A shipped case with a spacing (m) and what else is to `change`, without and with melting.
fn shipped(name: &'static str, spacing: f64, change: impl FnOnce(&mut Value)) -> Group {
    let text = case::shipped_text(name).expect("a shipped case");
    let mut as_it_is: Value = serde_json::from_str(text).expect("a case in JSON");
    let remove = |of: &mut Value, keys: &[&str]| {
        let of = of.as_object_mut().expect("an object");
        keys.iter().for_each(|key| drop(of.remove(*key)));
    };
    remove(&mut as_it_is, &["exact", "probes", "output", "$schema"]);
    as_it_is["particles"]["spacing"] = json!(spacing);
    change(&mut as_it_is);
    let mut without = as_it_is.clone();
    for (_, material) in without["materials"].as_object_mut().expect("materials") {
        remove(material, &["melting_temperature", "latent_heat", "liquid"]);
    }
    let entry = |name, case| Entry { name, case, unmelted: "without melting" };
    Group { name, entries: vec![entry("without melting", without), entry("as it is", as_it_is)] }
}

/// A scene that is ready to go on.
struct Ready {
    /// Takes so many steps, and waits for their end.
    steps: Box<dyn FnMut(u64)>,
    particles: usize,
    path: Path,
}

/// Makes a scene of so many particles [`Ready`].
struct Starter {
    particles: usize,
}

impl Driver for Starter {
    type Output = Ready;

    fn drive<B: Backend + 'static>(self, prepared: Prepared, mut backend: B) -> Ready {
        let (dt, mut done) = (prepared.step.dt, 0);
        let steps = Box::new(move |count| {
            backend.euler(done as f64 * dt, dt, count).expect("steps");
            backend.wait().expect("their end");
            done += count;
        });
        Ready { steps, particles: self.particles, path: prepared.plan.path }
    }
}

/// Puts the scene of an entry on a machine.
fn start(entry: &Entry, machine: &Machine, wish: PathWish) -> Result<Ready, Box<dyn Error>> {
    let Scene { problem, .. } = case::from_json(entry.name, entry.case.clone(), &[])?;
    let choice = PathChoice::new(&problem, machine.kind(), wish)?;
    let starter = Starter { particles: problem.particles.len() };
    Ok(study::start(&problem, machine, choice, false, starter)?)
}

fn measure(group: &Group, machine: &Machine, arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    // What has no lattice takes the list, and says so.
    let wish = match arguments.path {
        PathName::Lattice => PathWish::Auto,
        PathName::List => PathWish::List,
    };
    let scenes = group.entries.iter().map(|entry| {
        start(entry, machine, wish).map_err(|error| format!("{}: {error}", entry.name))
    });
    let mut scenes: Vec<Ready> = scenes.collect::<Result<_, _>>()?;
    scenes.iter_mut().for_each(|scene| (scene.steps)(STEPS_BEFORE));
    let mut taken = vec![Vec::new(); scenes.len()];
    for _ in 0..arguments.rounds {
        for (scene, taken) in scenes.iter_mut().zip(&mut taken) {
            let start = Instant::now();
            (scene.steps)(arguments.steps);
            taken.push(start.elapsed().as_secs_f64());
        }
    }
    let ratio = |one: usize, other: usize| {
        Spread::of(taken[one].iter().zip(&taken[other]).map(|(one, other)| one / other)).median
    };
    println!("\n{}, {} particles", group.name, scenes[0].particles);
    println!("{:24}{:>10}{:>10}{:>10}{:>12}", "", "path", "ns", "/ first", "/ unmelted");
    for (k, (entry, scene)) in group.entries.iter().zip(&scenes).enumerate() {
        let particle_steps = arguments.steps as f64 * scene.particles as f64;
        let time = 1e9 * Spread::of(taken[k].iter().copied()).median / particle_steps;
        let unmelted = group.entries.iter().position(|other| other.name == entry.unmelted);
        let [to_first, to_unmelted] =
            [0, unmelted.expect("one of the group")].map(|of| ratio(k, of));
        let (name, path) = (entry.name, scene.path.name());
        println!("{name:24}{path:>10}{time:10.3}{to_first:10.2}{to_unmelted:12.2}");
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    // On a thread of the pool, as commands are.
    rayon::scope(|_| match measure_all(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    })
}

fn measure_all(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let backend = if arguments.gpu { BackendWish::Gpu } else { BackendWish::Cpu };
    let wish = MachineWish { backend, adapter: None, precision: arguments.precision };
    let (machine, _) = Machine::open(&wish)?;
    let groups = groups(arguments.particles);
    let is_wanted =
        |group: &&Group| arguments.group.as_ref().is_none_or(|part| group.name.contains(part));
    let wanted: Vec<&Group> = groups.iter().filter(is_wanted).collect();
    if wanted.is_empty() {
        let names: Vec<&str> = groups.iter().map(|group| group.name).collect();
        return Err(format!("no such group: there are {}", names.join("; ")).into());
    }
    let place = machine.adapter().map_or_else(
        || format!("CPU, {} threads", rayon::current_num_threads()),
        |adapter| format!("{adapter}, {}", machine.kind().precision().name()),
    );
    println!("{place}: ns a particle and step");
    wanted.into_iter().try_for_each(|group| measure(group, &machine, arguments))
}
