//! The mixed path against the list path: the same survey, rates, fields, exchange and totals.

use std::ops::ControlFlow;

use diffusph::case::{self, Override, Scene};
use diffusph::model::lattice::MixedScene;
use diffusph::model::operator::rows::{cell_grid, survey};
use diffusph::model::{KernelKind, Material, PairMean, Problem};
use diffusph::report::run::{LeftOut, RunReport};
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::plan::Path;
use diffusph::solver::{Backend, Machine, MachineKind, PathChoice, PathWish, Plan};
use diffusph::study::{self, RunOptions};
use serde_json::json;

use scenes::{COUNTS, SPACING, cut, faces, part, problems, scene};

#[expect(dead_code, reason = "the tests of the plain lattice use the rest")]
#[path = "lattice_path/scenes.rs"]
mod boxes;
#[path = "mixed_path/scenes.rs"]
mod scenes;

/// The mixed backend, the way a run makes it, of a scene found in another problem.
fn backend(problem: &Problem, scene: MixedScene) -> CpuBackend {
    let (_, rows) = scene.assemble(problem);
    CpuBackend::mixed(problem, scene, rows)
}

/// How far two backends are apart.
#[derive(Debug)]
struct Apart {
    /// The largest difference of rates over what rounding may do to each.
    rates: f64,
    /// The largest difference of fields after some steps over the largest value.
    fields: f64,
    /// The difference of what was exchanged, over the total.
    exchange: f64,
    /// What the total of the mixed path lost, over the total.
    lost: f64,
}

impl Apart {
    fn worst(&self) -> f64 {
        [self.rates, self.fields, self.exchange, self.lost].into_iter().fold(0.0, f64::max)
    }
}

fn apart(problem: &Problem, mixed: &mut CpuBackend) -> Apart {
    let bound = survey(problem, &cell_grid(problem)).rate_bound;
    let mut list = CpuBackend::of(problem);
    let (a, b) = (list.rate(0.3).expect("rate"), mixed.rate(0.3).expect("rate"));
    // Beside faster particles the harmonic mean is twice the own diffusivity at most.
    let largest = problem.max_diffusivity();
    let diffusivity =
        |p: usize| problem.materials[usize::from(problem.particles.material[p])].diffusivity();
    let scale = |p: usize| match problem.pair_mean {
        PairMean::Harmonic => 300.0 * bound * diffusivity(p) / largest,
        PairMean::Arithmetic => 300.0 * bound,
    };
    // What sources add is rounded with the rest.
    let fed = |p: usize| {
        let x = problem.particles.position[p];
        let here = problem.sources.iter().filter(|source| source.acts_on(p));
        here.map(|s| s.rate.at(x, 0.3).abs() + 310.0 * s.linear.at(x, 0.0).abs()).sum::<f64>()
    };
    let pairs = a.as_ref().iter().zip(b.as_ref()).enumerate();
    let rates = pairs.map(|(p, (a, b))| (a - b).abs() / (scale(p) + fed(p))).fold(0.0, f64::max);
    let (dt, steps) = (0.9 / bound, if problem.dimension < 3 { 200 } else { 60 });
    list.euler(0.0, dt, steps).expect("steps");
    mixed.euler(0.0, dt, steps).expect("steps");
    let (a, b) = (list.read().expect("read"), mixed.read().expect("read"));
    let (a, b) = (a.as_ref(), b.as_ref());
    assert_eq!(a.len(), b.len());
    let largest = a.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
    let fields = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
    let volume = &problem.capacities();
    let total = |state: &[f64]| state.iter().zip(volume).map(|(c, v)| c * v).sum::<f64>();
    let (before, given) = (total(&problem.initial), mixed.exchange().expect("exchange"));
    let exchange = (list.exchange().expect("exchange") - given).abs() / before;
    let lost = (total(b) - before - given).abs() / before;
    assert!(mixed.is_finite().expect("finite"));
    Apart { rates, fields, exchange, lost }
}

#[test]
fn surveys_rates_fields_and_totals_agree_for_every_kernel_dimension_support_and_scene() {
    for kernel in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
            for support_ratio in [1.5, 2.0, 3.0, 3.7] {
                // In 3-D wide supports of every kernel take long, and have the same stencil.
                if dimension == 3 && support_ratio != 2.0 && kernel != KernelKind::WendlandC2 {
                    continue;
                }
                for (name, mut problem) in problems(kernel, support_ratio, dimension) {
                    for mean in PairMean::ALL {
                        if mean != problem.pair_mean && problem.materials.len() == 1 {
                            continue;
                        }
                        problem.pair_mean = mean;
                        let name =
                            format!("{kernel:?} {dimension}-D {support_ratio} {mean:?} {name}");
                        agree(&problem, &name);
                    }
                }
            }
        }
    }
}

fn agree(problem: &Problem, name: &str) {
    let scene = MixedScene::of(problem).unwrap_or_else(|why| panic!("{name}: {why}"));
    let (found, rows) = scene.assemble(problem);
    // A GPU finds by the stencil what is beside rows.
    for &site in rows.rank() {
        let mut of_stencil = Vec::new();
        scene.lattice.entries(site as usize, |other, _| of_stencil.push(other as u32));
        let (others, _) = rows.entries_of(site as usize, &mut 0).expect("a row");
        assert!(others.iter().all(|other| of_stencil.contains(other)), "{name}: {site}");
    }
    let expected = survey(problem, &cell_grid(problem));
    assert_eq!(found.entries, expected.entries, "{name}");
    assert_eq!(found.most_neighbors, expected.most_neighbors, "{name}");
    assert_eq!(found.symmetric, expected.symmetric, "{name}");
    assert_eq!((found.fault, found.coincident), (None, None), "{name}");
    for (a, b) in [
        (found.rate_bound, expected.rate_bound),
        (found.min_density, expected.min_density),
        (found.max_density, expected.max_density),
    ] {
        assert!((a / b - 1.0).abs() < 1e-12, "{name}: {a} {b}");
    }
    let apart = apart(problem, &mut backend(problem, scene));
    assert!(apart.worst() < 1e-13, "{name}: {apart:?}");
}

#[test]
fn most_particles_have_the_stencil_and_the_others_are_told() {
    let share = |name: &str| {
        let found = problems(KernelKind::CubicSpline, 2.0, 2).into_iter();
        let (_, problem) = found.into_iter().find(|(n, _)| *n == name).expect("a scene");
        let scene = MixedScene::of(&problem).expect("mixed");
        (scene.rows(), problem.particles.len())
    };
    // By hand: the reach is 1 along the axes and across.
    assert_eq!(share("layers").0, 4 * COUNTS[1][1]);
    assert_eq!(share("varying coefficient").0, 23 * 19 - 19 * 15);
    let (rows, all) = share("hole");
    assert!(rows > 10 && rows < all / 8, "{rows} of {all}");
    let (rows, all) = share("surface of a ball");
    assert!(rows > 20 && rows < all, "{rows} of {all}");
}

#[test]
fn one_changed_number_is_noticed() {
    let scenes = problems(KernelKind::WendlandC4, 3.0, 2);
    for name in ["hole", "layers", "surface, flux", "patches", "hole, convection"] {
        let (_, problem) = scenes.iter().find(|(n, _)| *n == name).expect("a scene");
        let scene = MixedScene::of(problem).expect("mixed");
        // One factor of the stencil.
        let mut ratio = scene.clone();
        ratio.ratios[0].1 *= 1.0 + 1e-6;
        let found = apart(problem, &mut backend(problem, ratio));
        assert!(found.rates > 1e-13 && found.fields > 1e-13, "{name}: {found:?}");
        // One weight of a stored row.
        let stored = scene.first_row().expect("a row") as usize;
        let neighbor = problem.particles.position.iter().position(|x| {
            let d = x.distance(problem.particles.position[scene.lattice.particle(stored)]);
            d > 0.0 && d < 1.1 * SPACING
        });
        let mut heavier = problem.clone();
        heavier.particles.volume[neighbor.expect("a neighbour")] *= 1.0 + 1e-6;
        let (_, rows) = scene.assemble(&heavier);
        let found = apart(problem, &mut CpuBackend::mixed(problem, scene, rows));
        assert!(found.rates > 1e-13 && found.fields > 1e-13, "{name}: {found:?}");
    }
}

#[test]
fn inclusions_at_random_and_speckles_agree() {
    for (support_ratio, one_in) in [(2.0, 400), (3.0, 900), (2.0, 3)] {
        let whole = part(3, 0.0, 1.0);
        let mut problem = scene(KernelKind::WendlandC2, support_ratio, 3, &[(whole, 1.0)], &[]);
        let slow = |conductivity| Material { conductivity, ..problem.materials[0].clone() };
        let (slow, slower) = (slow(1e-3), slow(1e-6));
        problem.materials.extend([slow, slower]);
        let mut seed = 7_u64;
        for material in &mut problem.particles.material {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
            if (seed >> 33).is_multiple_of(one_in) {
                *material = 1 + (seed >> 40) as u16 % 2;
            }
        }
        for pair_mean in PairMean::ALL {
            problem.pair_mean = pair_mean;
            agree(&problem, &format!("{support_ratio} 1 in {one_in} {pair_mean:?}"));
        }
    }
}

/// A box of 40 x 40 x 40 with a large hole and a slow layer: several parallel tasks.
fn large() -> Problem {
    let whole = json!({ "box": { "min": [0, 0, 0], "max": [10, 10, 10] } });
    let hole = json!({ "sphere": { "center": [4, 5, 5], "radius": 3 } });
    let slow = json!({ "box": { "min": [8, 0, 0], "max": [9, 10, 10] } });
    let holed = cut(&whole, &[hole, slow.clone()]);
    let wall = json!({ "wall": { "faces": ["z_min"], "kind": { "value": "300 + x" } } });
    let held = json!({ "held": {
        "where": { "sphere": { "center": [1, 1, 9], "radius": 1 } }, "value": 320
    } });
    scene(KernelKind::CubicSpline, 2.0, 3, &[(holed, 1.0), (slow, 1e-2)], &[wall, held])
}

#[test]
fn large_scenes_in_parallel_agree_in_any_order_of_particles() {
    let mut problem = large();
    agree(&problem, "as filled");
    let last = problem.particles.len() - 1;
    for (a, b) in [(0, last), (17, 333), (12_345, 34_321)] {
        problem.particles.position.swap(a, b);
        problem.particles.material.swap(a, b);
        problem.initial.swap(a, b);
    }
    agree(&problem, "in another order");
}

#[test]
fn scenes_thinner_than_the_support_agree() {
    for max in [[0.25, 4.0], [0.5, 4.0], [4.0, 0.5]] {
        let whole = json!({ "box": { "min": [0, 0], "max": max } });
        let hole = json!({ "box": { "min": [1, 1], "max": [1.5, 1.5] } });
        let hole = if max[0] < 1.0 || max[1] < 1.0 { vec![] } else { vec![hole] };
        let ends = json!({ "box": { "min": [0, 0], "max": max.map(|x: f64| x.min(2.0)) } });
        let shapes = [(cut(&whole, std::slice::from_ref(&ends)), 0.7), (cut(&ends, &hole), 0.1)];
        let problem = scene(KernelKind::WendlandC2, 3.7, 2, &shapes, &[]);
        agree(&problem, &format!("{max:?}"));
    }
}

/// Empty sites that are passed over, and lines longer than what is worked on at once, through one material and two.
#[test]
fn long_gaps_and_long_lines_agree() {
    let whole = json!({ "box": { "min": [0, 0], "max": [1250, 5] } });
    let hole = json!({ "box": { "min": [200, 1], "max": [400, 4] } });
    let notch = json!({ "box": { "min": [900, 3], "max": [960, 5] } });
    let part = |from: u32, to: u32| json!({ "box": { "min": [from, 0], "max": [to, 5] } });
    let one = vec![(cut(&whole, &[hole.clone(), notch.clone()]), 0.7)];
    let two = vec![(cut(&part(0, 700), &[hole]), 0.7), (cut(&part(700, 1250), &[notch]), 0.2)];
    for (support_ratio, shapes) in [(2.0, &one), (3.7, &one), (2.0, &two), (3.7, &two)] {
        for boundary in [
            json!({ "periodic": { "axes": ["x", "y"] } }),
            json!({ "wall": { "faces": faces(&["x", "y"]), "kind": { "value": "300 + x" } } }),
        ] {
            let problem = scene(KernelKind::WendlandC2, support_ratio, 2, shapes, &[boundary]);
            let found = MixedScene::of(&problem).expect("mixed");
            assert!(found.absent.iter().any(|gap| gap.len() > 700), "{:?}", found.absent.len());
            agree(&problem, &format!("{support_ratio}, {} materials", shapes.len()));
        }
    }
}

#[test]
fn what_is_no_lattice_takes_the_list_and_says_why() {
    let holed = problems(KernelKind::CubicSpline, 2.0, 2).swap_remove(0).1;
    let why = |change: &dyn Fn(&mut Problem)| {
        let mut problem = holed.clone();
        change(&mut problem);
        MixedScene::of(&problem).expect_err("no lattice")
    };
    let off = why(&|problem| problem.particles.position[5].x += 1e-4);
    assert_eq!(off, "a particle is not on its site of the lattice");
    let twice = why(&|problem| problem.particles.position[5] = problem.particles.position[4]);
    assert_eq!(twice, "two particles are on one site of the lattice");
    assert_eq!(why(&|problem| problem.particles.volume[3] *= 1.1), "particles differ in volume");
    let sparse = why(&|problem| problem.domain.max *= 4.0);
    assert_eq!(sparse, "the particles fill less than a tenth of the box around them");
}

#[test]
fn speckles_and_sparse_bodies_take_the_list_unless_the_stencil_is_wished_for() {
    let speckled = |one_in: usize| {
        let mut problem = scene(KernelKind::CubicSpline, 2.0, 3, &[(part(3, 0.0, 1.0), 1.0)], &[]);
        let slow = Material { conductivity: 1e-3, ..problem.materials[0].clone() };
        problem.materials.push(slow);
        problem.particles.material.iter_mut().step_by(one_in).for_each(|m| *m = 1);
        problem
    };
    let path = |problem: &Problem, wish| {
        let choice = PathChoice::new(problem, MachineKind::Cpu, wish).expect("a path");
        Plan::new(problem, MachineKind::Cpu, &choice, 0)
    };
    let few = path(&speckled(701), PathWish::Auto);
    assert_eq!((few.path, few.why_no_lattice), (Path::Mixed, Some(DIFFER)));
    let many = path(&speckled(3), PathWish::Auto);
    let why = "too few particles have the lattice's stencil";
    assert_eq!((many.path, many.why_no_lattice), (Path::List, Some(why)));
    assert_eq!(path(&speckled(3), PathWish::Lattice).path, Path::Mixed);
    assert_eq!(path(&speckled(701), PathWish::List).path, Path::List);
    // One particle off its site.
    let mut moved = speckled(701);
    moved.particles.position[700].x += 1e-3;
    assert_eq!(path(&moved, PathWish::Auto).path, Path::List);
    let refused = PathChoice::new(&moved, MachineKind::Cpu, PathWish::Lattice);
    assert!(refused.expect_err("no lattice").to_string().contains("not on its site"));
}

/// Why a scene of two materials is no plain lattice.
const DIFFER: &str = "particles differ in conductivity, capacity or density";

/// The report of a case with these changes on this path.
fn report(name: &str, path: PathWish, set: &[&str]) -> RunReport {
    let parse = |text: &&str| Override::parse(text).expect("an override");
    let overrides: Vec<Override> = set.iter().map(parse).collect();
    let scene: Scene =
        case::load(name, &overrides).unwrap_or_else(|error| panic!("{name}: {error}"));
    let options = RunOptions { path, ..RunOptions::new(&Machine::Cpu) };
    let run = study::run(&scene, &options, &mut |_| ControlFlow::Continue(())).expect("it runs");
    run.report
}

#[test]
fn shipped_cases_that_are_no_plain_lattice_are_mixed_and_give_the_same() {
    let names = [
        "patches",
        "annulus",
        "annulus_steady",
        "sphere_cooling",
        "sphere_convection",
        "contact",
        "freezing_pipe",
    ];
    for name in names {
        let set: &[&str] = match name {
            "patches" => &["time.end=0.2"],
            "annulus_steady" => &["time.end=0.1"],
            "freezing_pipe" => &["time.end=600"],
            // A tolerance follows roundings too.
            "contact" => &["time.step=0.02"],
            _ => &[],
        };
        let list = report(name, PathWish::List, set);
        assert_eq!(list.path, "list", "{name}");
        for wish in [PathWish::Auto, PathWish::Lattice] {
            let taken = report(name, wish, set);
            assert_eq!(taken.path, "mixed", "{name} {wish:?}");
            assert_eq!(taken.steps, list.steps, "{name}");
            let of_list = |left: &&LeftOut| left.what == "neighbour list and weights";
            let left = taken.left_out.iter().find(of_list).expect("most of the list is left out");
            assert!(left.why.starts_with("a stencil holds but for "), "{name}: {}", left.why);
            assert!(left.bytes_saved > 0 && taken.memory_bytes < list.memory_bytes, "{name}");
            for (a, b) in [
                (taken.field.min, list.field.min),
                (taken.field.max, list.field.max),
                (taken.field.mean, list.field.mean),
                (taken.conserved.last, list.conserved.last),
                (taken.conserved.boundary_exchange, list.conserved.boundary_exchange),
            ] {
                assert!((a - b).abs() <= 1e-12 * b.abs(), "{name}: {a} {b}");
            }
        }
    }
}
