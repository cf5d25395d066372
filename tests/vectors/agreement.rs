//! What is done with any backend, and how what comes of it is compared.

use diffusph::model::Problem;
use diffusph::model::lattice::LatticeScene;
use diffusph::model::operator::rows::{cell_grid, survey};
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::{Backend, Precision};
use diffusph::study;

use crate::support::{Random, device, epsilon};

/// How a scene is put on the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Path {
    List,
    /// A list in chunks.
    ChunkedList,
    /// A search in every sum.
    MatrixFree,
    Lattice,
    /// A lattice whose state is in parts of four layers.
    SplitLattice,
}

/// The stable step, s, and the most neighbours.
pub(crate) fn step(problem: &Problem) -> (f64, usize) {
    let survey = survey(problem, &cell_grid(problem));
    (0.9 / survey.rate_bound, survey.most_neighbors)
}

pub(crate) fn gpu(problem: &Problem, path: Path, precision: Precision) -> GpuBackend {
    let (dt, neighbors) = step(problem);
    let whole = GpuOptions::new(precision);
    let in_chunks = |bytes| GpuOptions { chunk_bytes: Some(bytes), ..whole };
    let list = |options| GpuBackend::with_options(problem, dt, device(), options);
    let lattice = |scene: &LatticeScene, options| {
        let (walls, _) = study::lattice_walls(problem, scene).expect("good walls");
        GpuBackend::lattice(problem, scene, walls, dt, device(), options)
    };
    let backend = match path {
        Path::List => list(whole),
        Path::MatrixFree => list(GpuOptions { matrix_free: true, ..whole }),
        // A slice of 32 rows, and a slot of a wall in each.
        Path::ChunkedList => list(in_chunks(32 * (neighbors as u64 + 2) * precision.bytes())),
        Path::Lattice => lattice(&LatticeScene::of(problem).expect("a lattice"), whole),
        Path::SplitLattice => {
            let scene = LatticeScene::of(problem).expect("a lattice");
            let layer = problem.particles.len() / scene.counts[problem.dimension - 1];
            lattice(&scene, in_chunks(4 * layer as u64 * precision.state_bytes()))
        }
    };
    let backend = backend.expect("backend");
    let is_split = matches!(path, Path::ChunkedList | Path::SplitLattice);
    assert_eq!(backend.chunk_count() > 1, is_split, "{path:?}");
    backend
}

/// The numbers of the script, the same on both sides but in a test of the test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Script {
    pub(crate) time: f64,
    pub(crate) share: f64,
    pub(crate) scale: f64,
    pub(crate) keep: f64,
    pub(crate) factor: f64,
    pub(crate) shift: f64,
    pub(crate) later: f64,
}

pub(crate) const SCRIPT: Script =
    Script { time: 0.3, share: 0.7, scale: -0.4, keep: 0.5, factor: 0.8, shift: 1.0, later: 5.0 };

/// The size of a vector of random numbers.
const NOISE: f64 = 100.0;

/// What came of an operation.
#[derive(Debug)]
pub(crate) struct Reading {
    name: &'static str,
    values: Vec<f64>,
    given: f64,
    largest: f64,
    /// The products with itself and with a vector of random numbers.
    dots: [f64; 2],
    /// What values are made of at most, and how much is given per volume.
    terms: f64,
}

/// Does the same with any backend. What a vector holds is read by adding it to a state of zeros.
pub(crate) fn readings<B: Backend>(
    mut backend: B,
    problem: &Problem,
    script: Script,
) -> Vec<Reading> {
    let (dt, _) = step(problem);
    let held: Vec<usize> = problem.held.iter().map(|&p| p as usize).collect();
    let mut random = Random(7);
    let noise: Vec<f64> =
        problem.initial.iter().map(|_| NOISE * (2.0 * random.unit() - 1.0)).collect();
    let mut vector = || backend.vector().expect("vector");
    let [mut rate, mut x, mut applied, mut twice] = [(); 4].map(|()| vector());
    let [mut sum, mut kept, mut given, mut divided] = [(); 4].map(|()| vector());
    let [mut by_diagonal, mut change, mut state, mut prolonged] = [(); 4].map(|()| vector());
    let nan = vec![f64::NAN; noise.len()];
    backend.load(&noise, &mut x).expect("load");
    backend.rate_into(script.time * dt, &mut rate).expect("rate");
    backend.apply(&x, script.share, script.scale * dt, &mut applied).expect("apply");
    backend.apply(&rate, 1.0, script.scale * dt, &mut twice).expect("apply");
    backend.load(&nan, &mut sum).expect("load");
    let terms = [(0.3 * dt, &rate), (script.factor, &x), (-1.5, &applied), (dt, &twice), (2.0, &x)];
    backend.update(&mut sum, 0.0, &terms).expect("sum");
    backend.update(&mut kept, 1.0, &[(1.0, &sum)]).expect("sum");
    backend.update(&mut kept, script.keep, &[(dt, &rate)]).expect("sum");
    backend.load(&noise, &mut given).expect("load");
    backend.update_given(&mut given, 0.0, &[(dt, &rate), (2.0, &applied)]).expect("sum");
    backend.update_given(&mut given, script.keep, &[(1.0, &applied)]).expect("sum");
    backend.divide(&sum, script.shift, script.scale * dt, &mut divided).expect("divide");
    backend.divide(&rate, 0.0, -dt, &mut by_diagonal).expect("divide");
    backend.rate_into(0.0, &mut change).expect("rate");
    backend.source_change(script.time * dt, script.later * dt, &mut change).expect("change");

    // Sums over seven aggregates, of which one has no member, as a mean density on top of noise.
    let is_free = |particle: usize| held.binary_search(&particle).is_err();
    let of = |a: usize| if is_free(a) { (a % 6) as u32 } else { u32::MAX };
    let aggregates: Vec<u32> = (0..noise.len()).map(of).collect();
    let volume: f64 = problem.capacities().iter().sum();
    let mut sums = [f64::NAN; 7];
    backend.aggregate(&aggregates, sums.len()).expect("aggregate");
    backend.restrict(&sum, &mut sums).expect("restrict");
    assert_eq!(sums[6], 0.0);
    backend.load(&noise, &mut prolonged).expect("load");
    backend.prolong(&sums.map(|sum| sum / volume), &mut prolonged).expect("prolong");

    // Zeros in the place of all that is not held.
    backend.load(&problem.initial, &mut state).expect("load");
    let values = backend.largest(&state).expect("largest");
    backend.update(&mut state, -1.0, &[]).expect("sum");
    backend.add(&state).expect("add");
    backend.save().expect("save");
    let slope = 2.0 * values / dt + backend.largest(&rate).expect("largest");
    let unit = NOISE + backend.largest(&applied).expect("largest") + dt * slope;
    let named = [
        ("loaded", &x, NOISE),
        ("rate", &rate, slope),
        ("applied", &applied, unit),
        ("applied to a rate", &twice, 4.0 * slope),
        ("sum", &sum, 8.0 * unit),
        ("kept", &kept, 8.0 * unit),
        ("given", &given, 4.0 * unit),
        ("divided", &divided, 16.0 * unit),
        ("over the diagonal", &by_diagonal, unit * condition(problem)),
        ("source", &change, slope),
        ("over aggregates", &prolonged, 9.0 * unit),
        ("state", &state, values),
    ];
    let mut read = |(name, vector, terms): (&'static str, &B::Vector, f64)| {
        backend.add(vector).expect("add");
        let mut values = backend.read().expect("read").as_ref().to_vec();
        for &p in &held {
            assert_eq!(values[p] as f32, problem.initial[p] as f32, "{name}: a held value");
            values[p] = 0.0;
        }
        let given = backend.exchange().expect("exchange");
        let dot = |y| backend.dot(vector, y).expect("dot");
        let dots = [vector, &x].map(dot);
        let largest = backend.largest(vector).expect("largest");
        backend.restore().expect("restore");
        Reading { name, values, given, largest, dots, terms }
    };
    named.map(&mut read).into()
}

/// How much larger the largest diagonal is than the smallest.
fn condition(problem: &Problem) -> f64 {
    let ratio = |values: &mut dyn Iterator<Item = f64>| {
        let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        most / least
    };
    // Ends have an eighth of the neighbours of the inside, or so.
    30.0 * ratio(&mut problem.materials.iter().map(|m| m.diffusivity()))
}

/// The readings that differ by more than roundings explain.
pub(crate) fn apart(
    here: &[Reading],
    there: &[Reading],
    problem: &Problem,
    precision: Precision,
) -> Vec<String> {
    let (_, neighbors) = step(problem);
    let roundings = (2 * (neighbors + 64)) as f64 * epsilon(precision);
    let volume: f64 = problem.capacities().iter().sum();
    let mut found = Vec::new();
    for (a, b) in here.iter().zip(there) {
        let allowed = roundings * a.terms;
        let values = a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs());
        // NaN stays.
        let worst = values.fold(0.0, |m: f64, off| if off > m || off.is_nan() { off } else { m });
        let mut check = |what: &str, off: f64, allowed: f64| {
            if off.abs() > allowed || off.is_nan() {
                found.push(format!("{} {what}: {off:e} > {allowed:e}", a.name));
            }
        };
        check("values", worst, allowed);
        check("given", a.given - b.given, allowed * volume);
        check("largest", a.largest - b.largest, allowed);
        for k in 0..2 {
            let size = if k == 0 { 2.0 * a.largest } else { NOISE };
            let sums = 32.0 * epsilon(precision) * a.largest;
            check("dot", a.dots[k] - b.dots[k], volume * size * (allowed + sums));
        }
    }
    found
}

pub(crate) fn assert_agreement(problem: &Problem, path: Path, precision: Precision, name: &str) {
    let here = readings(CpuBackend::of(problem), problem, SCRIPT);
    let there = readings(gpu(problem, path, precision), problem, SCRIPT);
    let apart = apart(&here, &there, problem, precision);
    assert!(apart.is_empty(), "{name} {path:?} {precision:?}: {apart:#?}");
}
