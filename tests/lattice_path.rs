//! The lattice path against the list path: the same survey, the same fields, the same exchange.

use std::ops::ControlFlow;

use diffusph::case::{self, Override};
use diffusph::model::lattice::LatticeScene;
use diffusph::model::operator::rows::{cell_grid, survey};
use diffusph::model::{KernelKind, Material, Problem};
use diffusph::report::run::RunReport;
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::plan::Path;
use diffusph::solver::{Backend, Machine, MachineKind, PathChoice, PathWish, Plan, Precision};
use diffusph::study::{self, RunOptions};
use serde_json::{Value, json};

use scenes::{COUNTS, boundaries, difference, scene, without_far_bodies};

#[path = "lattice_path/scenes.rs"]
mod scenes;

/// The lattice backend, the way a run makes it.
fn lattice(problem: &Problem) -> impl Backend {
    let scene = LatticeScene::of(problem).expect("a lattice");
    let (walls, _) = study::lattice_walls(problem, &scene).expect("good walls");
    CpuBackend::lattice(problem, scene, walls)
}

/// How far the two paths are apart after some steps: fields, and exchange over the total.
fn apart(on_list: &Problem, on_lattice: &Problem) -> (f64, f64) {
    let dt = 0.9 / survey(on_list, &cell_grid(on_list)).rate_bound;
    let (mut one, mut other) = (CpuBackend::of(on_list), lattice(on_lattice));
    one.euler(0.0, dt, 40).expect("steps");
    other.euler(0.0, dt, 40).expect("steps");
    let (a, b) = (one.read().expect("read"), other.read().expect("read"));
    let total: f64 = on_list.capacities().iter().sum::<f64>() * 300.0;
    let exchange = one.exchange().expect("exchange") - other.exchange().expect("exchange");
    (difference(a.as_ref(), b.as_ref()), exchange.abs() / total)
}

#[test]
fn surveys_and_fields_agree_for_every_kernel_dimension_support_and_boundary() {
    for kernel in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
            for support_ratio in [1.5, 2.0, 3.0, 3.7, 4.4] {
                // In 3-D wide supports of every kernel take long, and have the same stencil.
                if dimension == 3 && support_ratio > 2.0 && kernel != KernelKind::WendlandC2 {
                    continue;
                }
                for boundaries in boundaries(dimension) {
                    let name = format!("{kernel:?} {dimension}-D {support_ratio} {boundaries}");
                    let counts = COUNTS[dimension - 1];
                    let problem = scene(kernel, support_ratio, counts, boundaries).problem;
                    let found = LatticeScene::of(&problem).expect("a lattice").survey(&problem);
                    let expected = survey(&problem, &cell_grid(&problem));
                    assert_eq!(found.entries, expected.entries, "{name}");
                    assert_eq!(found.most_neighbors, expected.most_neighbors, "{name}");
                    let (_, is_skew) = study::lattice_walls(
                        &problem,
                        &LatticeScene::of(&problem).expect("a lattice"),
                    )
                    .expect("good walls");
                    assert_eq!(is_skew, !expected.symmetric, "{name}");
                    for (a, b) in [
                        (found.rate_bound, expected.rate_bound),
                        (found.min_density, expected.min_density),
                        (found.max_density, expected.max_density),
                    ] {
                        assert!((a / b - 1.0).abs() < 1e-12, "{name}: {a} {b}");
                    }
                    let (fields, exchange) = apart(&problem, &problem);
                    assert!(fields < 1e-13, "{name}: fields {fields:e}");
                    assert!(exchange < 1e-13, "{name}: exchange {exchange:e}");
                }
            }
        }
    }
}

#[test]
fn one_changed_number_is_noticed() {
    for boundaries in boundaries(2) {
        let problem = scene(KernelKind::WendlandC4, 3.0, COUNTS[1], boundaries).problem;
        let mut changed = problem.clone();
        changed.materials[0].conductivity *= 1.0 + 1e-6;
        assert!(apart(&problem, &changed).0 > 1e-13);
        if !problem.held.is_empty() {
            let mut freed = problem.clone();
            freed.held.pop();
            assert!(apart(&problem, &freed).1 > 1e-13, "what one held particle gave");
        }
    }
}

#[test]
fn boxes_thinner_than_the_stencil_agree() {
    for counts in [[3, 11], [11, 3], [1, 9]] {
        let is_periodic = |boundaries: &Value| boundaries.to_string().contains("periodic");
        for boundaries in boundaries(2).into_iter().filter(|boundaries| !is_periodic(boundaries)) {
            // Walls ask for a body as thick as the support.
            let has_walls = boundaries.to_string().contains("wall");
            let ratios: &[f64] = match (has_walls, counts.contains(&1)) {
                (true, true) => &[],
                (true, false) => &[2.0, 3.0],
                (false, _) => &[2.0, 3.7, 4.4],
            };
            for &support_ratio in ratios {
                let boundaries = without_far_bodies(&boundaries, counts);
                let name = format!("{counts:?} {support_ratio} {boundaries}");
                let problem =
                    scene(KernelKind::WendlandC2, support_ratio, &counts, boundaries).problem;
                let (fields, exchange) = apart(&problem, &problem);
                assert!(fields < 1e-13 && exchange < 1e-13, "{name}: {fields:e} {exchange:e}");
            }
        }
    }
}

#[test]
fn periodic_lines_longer_than_a_block_agree() {
    for counts in [&[5000][..], &[5000, 12], &[2049, 12]] {
        let axes = &["x", "y"][..counts.len()];
        // A reach of one to four sites.
        for support_ratio in [2.0, 3.0, 3.7, 4.4] {
            let periodic = json!([{ "periodic": { "axes": axes } }]);
            let problem = scene(KernelKind::WendlandC2, support_ratio, counts, periodic).problem;
            let (fields, _) = apart(&problem, &problem);
            assert!(fields < 1e-13, "{counts:?} {support_ratio}: {fields:e}");
        }
    }
}

#[test]
fn large_lattices_in_parallel_agree_too_and_in_any_order_of_particles() {
    let periodic = json!([{ "periodic": { "axes": ["y"] } }]);
    let mut problem = scene(KernelKind::CubicSpline, 2.0, &[50, 40, 30], periodic).problem;
    assert!(apart(&problem, &problem).0 < 1e-13);
    problem.held = vec![17, 5000, 5001, 40_000];
    let last = problem.particles.len() - 1;
    for (a, b) in [(0, last), (17, 333), (12_345, 54_321)] {
        problem.particles.position.swap(a, b);
        problem.initial.swap(a, b);
    }
    let scene = LatticeScene::of(&problem).expect("a lattice");
    assert!(scene.order.is_some());
    let (fields, exchange) = apart(&problem, &problem);
    assert!(fields < 1e-13 && exchange < 1e-13, "{fields:e} {exchange:e}");
    let long = scene_of_a_line(100_000);
    assert!(apart(&long, &long).0 < 1e-13);
}

fn scene_of_a_line(count: usize) -> Problem {
    let flux = json!([{ "wall": { "faces": ["x_min"], "kind": { "flux": 1 } } }]);
    scene(KernelKind::WendlandC2, 3.0, &[count], flux).problem
}

#[test]
fn what_is_no_lattice_takes_the_list_and_says_why() {
    let whole = scene(KernelKind::CubicSpline, 2.0, &[8, 8], json!([])).problem;
    let why = |change: &dyn Fn(&mut Problem)| {
        let mut problem = whole.clone();
        change(&mut problem);
        LatticeScene::of(&problem).expect_err("no lattice")
    };
    assert!(LatticeScene::of(&whole).is_ok());
    let one_short = why(&|problem| {
        problem.particles.position.pop();
        problem.particles.volume.pop();
        problem.particles.material.pop();
        problem.initial.pop();
    });
    assert_eq!(one_short, "the particles do not fill the box around them");
    let moved = why(&|problem| problem.particles.position[5].x += 1e-4);
    assert_eq!(moved, "a particle is not on its site of the lattice");
    let twice = why(&|problem| problem.particles.position[5] = problem.particles.position[4]);
    assert_eq!(twice, "two particles are on one site of the lattice");
    assert_eq!(why(&|problem| problem.particles.volume[3] *= 1.1), "particles differ in volume");
    let two = why(&|problem| {
        let slow = Material { conductivity: 0.1, ..problem.materials[0].clone() };
        problem.materials.push(slow);
        problem.particles.material[3] = 1;
    });
    assert_eq!(two, "particles differ in conductivity, capacity or density");
    let wide = scene(KernelKind::CubicSpline, 5.5, &[12, 12], json!([])).problem;
    let why_wide = LatticeScene::of(&wide).expect_err("too wide");
    assert_eq!(why_wide, "the support reaches past four spacings");
    let convection = json!([{ "wall": {
        "faces": ["x_min"], "kind": { "convection": { "coefficient": 1, "ambient": 0 } }
    } }]);
    let beside_free = scene(KernelKind::CubicSpline, 2.0, &[8, 8], convection).problem;
    let why_convection = LatticeScene::of(&beside_free).expect_err("beside a free face");
    assert_eq!(why_convection, "a convection wall meets a free face");
}

/// The report of a shipped case with these changes on this path.
fn report(name: &str, path: PathWish, set: &[&str]) -> RunReport {
    let parse = |text: &&str| Override::parse(text).expect("an override");
    let overrides: Vec<Override> = set.iter().map(parse).collect();
    let scene = case::load(name, &overrides).unwrap_or_else(|error| panic!("{name}: {error}"));
    let options = RunOptions { path, ..RunOptions::new(&Machine::Cpu) };
    let run = study::run(&scene, &options, &mut |_| ControlFlow::Continue(())).expect("it runs");
    run.report
}

#[test]
fn shipped_cases_take_the_path_that_they_can() {
    for (name, _) in case::shipped() {
        let coarse: &[&str] = match name.as_str() {
            "constant" | "affine" => &[
                "particles.spacing=5",
                "time.step=4e4",
                "output={}",
                "probes=[]",
                "boundaries.1.held.where.box.max.0=5",
                "boundaries.2.held.where.box.min.0=45",
            ],
            "gaussian" => &["particles.spacing=5", "time.step=4e4", "output={}", "probes=[]"],
            "hot_inclusion" => &["time.end=1", "output={}", "probes=[]"],
            "freezing_pipe" => &["time.end=60", "output={}", "probes=[]"],
            "constant_column" | "affine_column" => &["time.end=225*400", "output={}"],
            _ => &[],
        };
        let taken = report(&name, PathWish::Auto, coarse);
        let round = ["annulus", "annulus_steady", "sphere_cooling", "sphere_convection"];
        // See tests/mixed_path.rs.
        let others = ["patches", "contact", "hot_inclusion", "freezing_pipe"];
        let is_mixed = round.contains(&name.as_str()) || others.contains(&name.as_str());
        assert_eq!(taken.path, if is_mixed { "mixed" } else { "lattice" }, "{name}");
        if is_mixed {
            continue;
        }
        let left = |what: &str| taken.left_out.iter().any(|left| left.what == what);
        assert!(left("neighbour list and weights"), "{name}");
        // Walls that impose something are folded by a walk over cells.
        let walled = [
            "flux_plate",
            "heated_plate",
            "flux_half_space",
            "cooling_plate",
            "swinging_bar",
            "fin",
            "rod",
            "square",
            "melting_rod",
            "laser_track",
        ];
        assert_eq!(left("sorting into cells"), !walled.contains(&name.as_str()), "{name}");
        let general = report(&name, PathWish::List, coarse);
        assert_eq!(taken.steps, general.steps, "{name}");
        let pairs = [
            (taken.field.min, general.field.min),
            (taken.field.max, general.field.max),
            (taken.field.mean, general.field.mean),
            (taken.conserved.last, general.conserved.last),
        ];
        for (a, b) in pairs {
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{name}: {a} {b}");
        }
    }
}

#[test]
fn a_lattice_on_the_gpu_leaves_out_the_list_and_what_acts_on_no_site() {
    let machine = MachineKind::Gpu(Precision::F32);
    let plan = |name: &str| {
        let problem = case::load(name, &[]).expect("it loads").problem;
        let choice = PathChoice::new(&problem, machine, PathWish::Auto).expect("a path");
        let plan = Plan::new(&problem, machine, &choice, 1000);
        let left = plan.left_out.iter().map(|left| left.what).collect::<Vec<_>>();
        (plan.path, plan.passes(&problem), left)
    };
    let (path, passes, left) = plan("gaussian_small");
    assert_eq!(path, Path::Lattice);
    assert_eq!(passes, ["stencil", "lattice_step", "finite", "still"]);
    let nothing = ["neighbour list and weights", "sorting into cells", "wall fold"];
    assert_eq!(left, [&nothing[..], &["exchange of held particles", "enthalpy"]].concat());
    let (path, passes, left) = plan("constant_column");
    assert_eq!(path, Path::Lattice);
    assert_eq!(passes, ["stencil", "lattice_step", "exception_step", "finite", "still"]);
    assert_eq!(left, [&nothing[..], &["enthalpy"]].concat());
    let (path, passes, left) = plan("swinging_bar");
    assert_eq!(path, Path::Lattice);
    let steps = ["lattice_step", "exception_step", "finite", "still"];
    assert_eq!(passes, [&["stencil", "sort", "wall_fold"][..], &steps].concat());
    assert!(!left.contains(&"sorting into cells"), "{left:?}");
    // A body that is no full lattice: what the stencil cannot do is done by stored rows.
    let (path, passes, left) = plan("sphere_cooling");
    assert_eq!(path, Path::Mixed);
    let steps = ["rows", "lattice_step", "exception_step"];
    assert!(steps.iter().all(|pass| passes.contains(pass)), "{passes:?}");
    assert!(left.contains(&"neighbour list and weights"), "{left:?}");
    let (path, passes, left) = plan("melting_rod");
    assert_eq!(path, Path::Lattice);
    // The enthalpy is written with its potential: no pass of its own goes over all sites.
    assert_eq!(
        passes,
        [
            "stencil",
            "sort",
            "wall_fold",
            "lattice_step",
            "exception_step",
            "finite",
            "still",
            "fronts"
        ]
    );
    assert!(!left.contains(&"enthalpy"), "{left:?}");
}
