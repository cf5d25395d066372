//! What each precision is worth over long runs, and that runs repeat.

use std::ops::ControlFlow;

use diffusph::case::{self, Scene};
use diffusph::model::lattice::LatticeScene;
use diffusph::model::{KernelKind, Problem};
use diffusph::solver::gpu::passes::self_test;
use diffusph::solver::gpu::{GpuBackend, GpuOptions, SelfTest};
use diffusph::solver::{Backend, BackendWish, Foreseen, Machine, MachineWish, PathWish, Precision};
use diffusph::study::{self, Outcome, RunOptions};
use serde_json::{Value, json};

use support::device;

#[path = "lattice_path/scenes.rs"]
#[expect(dead_code, reason = "the tests of lattices use the rest")]
mod scenes;
#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

/// Steps of the report's cases `constant` and `affine`.
const STEPS: u64 = 280_320;

/// The report's cases on a line of 100 particles: ends held at `left` and `right`.
fn line(left: f64, right: f64, exact: &Value) -> Scene {
    let held = |from: f64, to: f64, value: f64| {
        json!({ "held": {
            "where": { "box": { "min": [from], "max": [to] } }, "value": value
        } })
    };
    let case = json!({
        "title": "line",
        "dimension": 1,
        "particles": {
            "spacing": 0.5,
            "fill": [{ "shape": { "box": { "min": [0], "max": [50] } }, "material": "rock" }]
        },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "operator": { "correction": "none" },
        "materials": { "rock": { "diffusivity": "1875/year" } },
        "initial": [{ "value": 0 }],
        "boundaries": [held(0.0, 0.5, left), held(49.5, 50.0, right)],
        "time": { "end": "2*year", "step": 225 },
        "exact": exact
    });
    case::from_json("line", case, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn constant() -> Scene {
    line(1000.0, 1000.0, &json!({ "name": "uniform", "value": 1000 }))
}

fn affine() -> Scene {
    line(104.5, 995.5, &json!({ "name": "expression", "value": "18*x + 100" }))
}

fn gpu(precision: Precision) -> Machine {
    Machine::Gpu { device: device().clone(), precision }
}

fn run(scene: &Scene, machine: &Machine) -> Outcome {
    let options = RunOptions::new(machine);
    study::run(scene, &options, &mut |_| ControlFlow::Continue(())).expect("it runs")
}

/// The least value of `constant` and the largest error of `affine` after all steps, and what was
/// warned about.
fn after_all_steps(machine: &Machine) -> (f64, f64, [Vec<String>; 2]) {
    let [constant, affine] = [constant(), affine()].map(|scene| run(&scene, machine).report);
    let is_f32 = machine.kind().precision() == Precision::F32;
    for report in [&constant, &affine] {
        // What held particles gave is counted in two words, but an f32 state loses what it gets.
        let drift = report.conserved.relative_drift.abs();
        assert_eq!(drift > 1e-6, is_f32, "{machine:?}: {drift:e}");
    }
    assert_eq!([constant.steps, affine.steps], [STEPS; 2]);
    assert_eq!(constant.path, "lattice");
    let error = affine.error.expect("it has an exact solution").linf;
    (constant.field.min, error, [constant.warnings, affine.warnings])
}

#[test]
fn f64_is_right_after_all_steps() {
    for machine in [Machine::Cpu, gpu(Precision::F64)] {
        let (least, error, warnings) = after_all_steps(&machine);
        assert!((least - 999.999_649_106).abs() < 1e-9, "{machine:?}: {least}");
        assert!((error - 1.929_919e-4).abs() < 1e-9, "{machine:?}: {error:e}");
        assert_eq!(warnings, [const { Vec::<String>::new() }; 2]);
    }
}

#[test]
fn compensated_is_nearly_as_good() {
    let (least, error, warnings) = after_all_steps(&gpu(Precision::Compensated));
    assert!((least - 999.999_649).abs() < 2e-5, "{least}");
    assert!((error - 1.93e-4).abs() < 2e-5, "{error:e}");
    assert_eq!(warnings, [const { Vec::<String>::new() }; 2]);
}

#[test]
fn f32_stagnates_and_says_so() {
    let (least, error, warnings) = after_all_steps(&gpu(Precision::F32));
    assert!((least - 999.3271).abs() < 1e-3, "{least}");
    assert!((error - 0.53).abs() < 0.01, "{error}");
    for warnings in warnings {
        let [warning] = &warnings[..] else { panic!("one warning: {warnings:?}") };
        let number_after = |word: &str| -> f64 {
            let number = warning.split(word).nth(1).and_then(|rest| rest.split(' ').next());
            number.and_then(|text| text.parse().ok()).expect("a number")
        };
        // Half of the steps; about as much as is missing in truth.
        let since = number_after("stands still: no look after step ");
        assert!((1.3e5..1.5e5).contains(&since), "{warning}");
        assert!((0.2..2.0).contains(&number_after("about ")), "{warning}");
    }
}

/// Whether a run of the line in f32 ends still, and how far from the same run in f64.
fn in_f32(scene: &Scene) -> (bool, f64) {
    let [f32, f64] = [gpu(Precision::F32), Machine::Cpu].map(|machine| run(scene, &machine));
    let off = f32.state.iter().zip(&f64.state).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (f32.report.warnings.iter().any(|warning| warning.contains("stands still")), off)
}

#[test]
fn stagnation_is_foreseen_where_it_comes_and_only_there() {
    for scene in [constant(), affine()] {
        let Foreseen::StandsStill(found) = Foreseen::of(&scene.problem) else {
            panic!("it stagnates");
        };
        assert!((0.2..2.0).contains(&found.error), "{found:?}");
    }
    let shipped = |name: &str| Foreseen::of(&case::load(name, &[]).expect("it loads").problem);
    assert!(matches!(shipped("constant_column"), Foreseen::StandsStill(_)));
    assert_eq!(shipped("gaussian"), Foreseen::Good);
    assert_eq!(shipped("gaussian_small"), Foreseen::Good);
    // Walls that impose something: no estimate knows what a step adds.
    assert_eq!(shipped("flux_plate"), Foreseen::Driven);
    // A tenth of the time: the field still moves at the end, in truth as well, but has lost something.
    let after = |part: f64| {
        let mut scene = constant();
        scene.problem.time.end *= part;
        scene.problem.time.output_every = f64::INFINITY;
        scene
    };
    let early = after(0.1);
    let Foreseen::Loses(lost) = Foreseen::of(&early.problem) else { panic!("it loses") };
    let (is_still, off) = in_f32(&early);
    assert!(!is_still && (0.1 * lost..lost).contains(&off), "{off:e} {lost:e}");
    let earlier = after(0.01);
    assert_eq!(Foreseen::of(&earlier.problem), Foreseen::Good);
    let (is_still, off) = in_f32(&earlier);
    assert!(!is_still && off < 0.05, "{off:e}");
    let mut uniform = constant();
    uniform.problem.initial.fill(1000.0);
    assert_eq!(Foreseen::of(&uniform.problem), Foreseen::Good, "nothing changes");
    let mut at_once = constant();
    at_once.problem.time.end = 0.0;
    assert_eq!(Foreseen::of(&at_once.problem), Foreseen::Good);
    // Outputs that shorten the steps count.
    let mut often = early;
    often.problem.time.output_every = 0.02;
    assert!(matches!(Foreseen::of(&often.problem), Foreseen::StandsStill(_)));
}

#[test]
fn a_steady_state_is_not_taken_for_stagnation() {
    let mut scene = affine();
    let position = &scene.problem.particles.position;
    scene.problem.initial = position.iter().map(|x| 18.0 * x.x + 100.0).collect();
    scene.problem.time.end = 225.0 * 4000.0;
    let (is_still, off) = in_f32(&scene);
    assert!(!is_still && off < 1e-3, "{off:e}");
}

/// Drift of the total over it, of the shipped case `patches` in compensated and in f32.
#[test]
fn what_walls_give_is_counted_in_two_words() {
    let scene = case::load("patches", &[]).expect("it loads");
    let drift = |path, precision| {
        let machine = gpu(precision);
        let options = RunOptions { path, ..RunOptions::new(&machine) };
        let outcome = study::run(&scene, &options, &mut |_| ControlFlow::Continue(()));
        outcome.expect("it runs").report.conserved.relative_drift.abs()
    };
    // By list what one particle gains another loses to the last bit, and nothing else is rounded.
    let [compensated, f32] =
        [Precision::Compensated, Precision::F32].map(|p| drift(PathWish::List, p));
    assert!(compensated < 1e-8, "{compensated:e}");
    assert!(f32 > 1e-6, "or the bound shows nothing: {f32:e}");
    // A stencil adds up differences before it weights them, and each sum is rounded by itself.
    let by_stencil = drift(PathWish::Auto, Precision::Compensated);
    assert!(by_stencil < 1e-5, "{by_stencil:e}");
}

/// What a wall imposes is good to the rounding of f32, also where the state is in two words.
#[test]
fn a_wall_imposes_its_value_to_the_rounding_of_its_source() {
    let case = json!({
        "title": "walled line",
        "dimension": 1,
        "particles": {
            "spacing": 0.5,
            "fill": [{ "shape": { "box": { "min": [0], "max": [10] } }, "material": "rock" }]
        },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "materials": { "rock": { "diffusivity": "1875/year" } },
        "boundaries": [{ "wall": { "faces": ["x_min", "x_max"], "kind": { "value": 1000.3 } } }],
        "time": { "end": "0.2*year", "step": 225 }
    });
    let scene = case::from_json("walled", case, &[]).unwrap_or_else(|error| panic!("{error}"));
    let least = |machine: &Machine| run(&scene, machine).report.field.min;
    let (f64, compensated) = (least(&Machine::Cpu), least(&gpu(Precision::Compensated)));
    assert!((compensated / f64 - 1.0).abs() < 2e-7, "{f64} {compensated}");
    assert!((least(&gpu(Precision::F32)) / f64 - 1.0).abs() > 2e-7);
}

#[test]
fn the_precision_that_a_scene_needs_is_taken_with_the_reason() {
    let open = |scene: &Scene, precision: Option<Precision>| {
        let wish = MachineWish { backend: BackendWish::Gpu, adapter: None, precision };
        Machine::open_for(&wish, &scene.problem).expect("an adapter")
    };
    let taken = |scene: &Scene| {
        let opened = open(scene, None);
        assert!(opened.warnings.is_empty(), "{:?}", opened.warnings);
        (opened.machine.kind().precision(), opened.why_precision.expect("a reason"))
    };
    let (precision, why) = taken(&constant());
    assert_eq!(precision, Precision::Compensated);
    assert!(why.contains("in f32 steps add as little as"), "{why}");
    let gaussian = case::load("gaussian_small", &[]).expect("it loads");
    assert_eq!(taken(&gaussian).0, Precision::F32);
    // Who asks for f32 is told before the run.
    let opened = open(&constant(), Some(Precision::F32));
    assert_eq!(opened.machine.kind().precision(), Precision::F32);
    assert!(opened.warnings[0].starts_with("--precision f32: "), "{:?}", opened.warnings);
    for precision in [Precision::Compensated, Precision::F64] {
        assert!(open(&constant(), Some(precision)).warnings.is_empty());
    }
}

#[test]
fn the_self_test_passes_and_catches_a_compiler_that_deletes_compensation() {
    let source = self_test();
    let found = SelfTest::run(device(), &source).expect("it runs");
    assert_eq!(found.fault(), None);
    // The same sums without the zero that the compiler does not know.
    let sums = include_str!("../shaders/sum/compensated.wgsl");
    let opaque = "bitcast<real>(bitcast<u32>(number) ^ step_size.opaque_zero)";
    assert!(sums.contains(opaque));
    let mut naive = source.clone();
    naive.slots.retain(|slot| slot != "sum/compensated");
    naive.generated = sums.replace(opaque, "number");
    let found = SelfTest::run(device(), &naive).expect("it runs");
    let fault = found.fault().expect("compensation is deleted here");
    assert!(found.wrong_sums > found.tried / 10, "{fault}");
    // Differences of the first words alone.
    let mut first = source;
    first.slots.retain(|slot| slot != "state/two_words");
    let words = include_str!("../shaders/state/two_words.wgsl");
    first.generated = words.replace("value.x + value.y", "value.x");
    let found = SelfTest::run(device(), &first).expect("it runs");
    assert!(found.wrong_differences > found.tried / 10 && found.wrong_sums == 0, "{found:?}");
}

/// A plate with jitter, walls of several kinds and a held body, `shift` (m) from the origin.
fn shifted(shift: f64, is_lattice: bool) -> Problem {
    let boundaries = json!([
        { "periodic": { "axes": ["y"] } },
        { "wall": { "faces": ["x_min"], "kind": { "flux": 3 } } },
        { "held": { "where": { "box": { "min": [2, 1], "max": [2.5, 1.5] } }, "value": 250 } }
    ]);
    let boundaries = if is_lattice { boundaries } else { json!([boundaries[2]]) };
    let mut problem = scenes::scene(KernelKind::WendlandC2, 3.0, &[13, 11], boundaries).problem;
    if !is_lattice {
        let mut random = support::Random(3);
        for x in &mut problem.particles.position {
            // Multiples of what is kept at the far place.
            let mut jitter = || (0.05 * (random.unit() - 0.5) * 1e7).round() / 1e7;
            (x.x, x.y) = (x.x + jitter(), x.y + jitter());
        }
    }
    let shift = glam::DVec3::new(shift, -shift, 0.0);
    problem.particles.position.iter_mut().for_each(|x| *x += shift);
    problem.domain.min += shift;
    problem.domain.max += shift;
    problem
}

/// The field after 200 stable steps in f32.
fn far_field(problem: &Problem, is_lattice: bool) -> Vec<f64> {
    let mut backend = on_device(problem, Precision::F32, is_lattice);
    backend.euler(0.0, stable(problem), 200).expect("steps");
    backend.read().expect("read").as_ref().to_vec()
}

fn stable(problem: &Problem) -> f64 {
    use diffusph::model::operator::rows::{cell_grid, survey};
    0.9 / survey(problem, &cell_grid(problem)).rate_bound
}

fn on_device(problem: &Problem, precision: Precision, is_lattice: bool) -> GpuBackend {
    let dt = stable(problem);
    if !is_lattice {
        return GpuBackend::new(problem, dt, device(), precision).expect("backend");
    }
    let scene = LatticeScene::of(problem).expect("a lattice");
    let (walls, _) = study::lattice_walls(problem, &scene).expect("good walls");
    let options = GpuOptions::new(precision);
    GpuBackend::lattice(problem, &scene, walls, dt, device(), options).expect("backend")
}

#[test]
fn a_scene_far_from_the_origin_has_the_same_answer_in_f32() {
    for is_lattice in [true, false] {
        let near = far_field(&shifted(0.0, is_lattice), is_lattice);
        let far = far_field(&shifted(1e6, is_lattice), is_lattice);
        let off = scenes::difference(&near, &far);
        assert!(off < 1e-6, "lattice {is_lattice}: {off:e}");
        let range = near.iter().fold(0.0, |largest: f64, value| largest.max(*value));
        assert!(range > 255.0, "something happens");
    }
    // In f32 itself a position there is good to 0.03 m, an eighth of the spacing.
    let mut rounded = shifted(1e6, false);
    for x in &mut rounded.particles.position {
        (x.x, x.y) = (f64::from(x.x as f32), f64::from(x.y as f32));
    }
    let off =
        scenes::difference(&far_field(&shifted(0.0, false), false), &far_field(&rounded, false));
    assert!(off > 1e-5, "{off:e}");
}

#[test]
fn a_device_repeats_a_run_bit_for_bit() {
    let bits = |problem: &Problem, precision: Precision, is_lattice: bool| {
        let mut backend = on_device(problem, precision, is_lattice);
        backend.euler(0.0, stable(problem), 300).expect("steps");
        let field: Vec<u64> =
            backend.read().expect("read").as_ref().iter().map(|value| value.to_bits()).collect();
        (field, backend.exchange().expect("exchange").to_bits())
    };
    for is_lattice in [true, false] {
        let problem = shifted(0.0, is_lattice);
        for precision in Precision::ALL {
            let first = bits(&problem, precision, is_lattice);
            for _ in 0..2 {
                assert!(bits(&problem, precision, is_lattice) == first, "{precision:?}");
            }
            let mut changed = problem.clone();
            changed.initial[40] *= 1.0 + 1e-3;
            assert!(bits(&changed, precision, is_lattice) != first, "a change is noticed");
        }
    }
}

#[test]
fn the_number_of_threads_makes_no_difference_on_the_cpu() {
    let ball = || json!({ "sphere": { "center": [4, 5, 5], "radius": 2 } });
    let shape = |hole: bool| {
        let whole = json!({ "box": { "min": [0, 0, 0], "max": [10, 11, 9] } });
        match hole {
            true => json!({ "difference": { "of": whole, "minus": [ball()] } }),
            false => whole,
        }
    };
    // The whole is of one material, the ball of another one, if there is any.
    let melting = |conductivity: f64, at: f64| {
        json!({
            "conductivity": conductivity, "density": 1, "heat_capacity": 1,
            "melting_temperature": at, "latent_heat": 2, "liquid": { "conductivity": 0.2 }
        })
    };
    let materials = |hole: bool, melts: bool| match (melts, hole) {
        (true, true) => json!({ "m": melting(0.7, 300.0), "ball": melting(0.5, 301.0) }),
        (true, false) => json!({ "m": melting(0.7, 300.0) }),
        (false, _) => json!({ "m": { "diffusivity": 0.7 } }),
    };
    let scene = |hole: bool, melts: bool| {
        let mut fill = vec![json!({ "shape": shape(hole), "material": "m" })];
        if hole && melts {
            fill.push(json!({ "shape": ball(), "material": "ball" }));
        }
        let case = json!({
            "title": "box",
            "dimension": 3,
            "particles": {
                "spacing": 0.25,
                "fill": fill
            },
            "kernel": { "name": "cubic_spline", "support_ratio": 2 },
            "materials": materials(hole, melts),
            "initial": [{ "value": "300 + 10*sin(7.3*x + 5.1*y - 3.7*z)" }],
            "boundaries": [
                { "periodic": { "axes": ["y"] } },
                { "wall": { "faces": ["x_min"], "kind": { "value": "300 + 5*t" } } },
                { "held": {
                    "where": { "sphere": { "center": [8, 8, 6], "radius": 1 } }, "value": 250
                } }
            ],
            "exact": { "name": "uniform", "value": 300 },
            "probes": [{ "name": "inside", "at": [9, 2, 2] }],
            "time": { "end": 0.5, "step": 0.01 }
        });
        case::from_json("box", case, &[]).unwrap_or_else(|error| panic!("{error}"))
    };
    // What goes by enthalpies, round the end of the last axis.
    let plane = || {
        let case = json!({
            "title": "plane",
            "dimension": 2,
            "particles": {
                "spacing": 0.25,
                "fill": [{ "shape": { "box": { "min": [0, 0], "max": [75, 75] } }, "material": "m" }]
            },
            "kernel": { "name": "cubic_spline", "support_ratio": 2 },
            "materials": { "m": {
                "conductivity": [[200, 0.6], [400, 0.8]], "density": 1, "heat_capacity": 1,
                "melting_temperature": 300, "latent_heat": 2, "liquid": { "conductivity": 0.2 }
            } },
            "initial": [{ "value": "300 + 10*sin(7.3*x + 5.1*y)" }],
            "boundaries": [
                { "periodic": { "axes": ["y"] } },
                { "held": { "where": { "sphere": { "center": [8, 8], "radius": 1 } }, "value": 250 } }
            ],
            "time": { "end": 0.5, "step": 0.01 }
        });
        case::from_json("plane", case, &[]).unwrap_or_else(|error| panic!("{error}"))
    };
    let outcome = |scene: &Scene, path: PathWish, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let options = RunOptions { path, ..RunOptions::new(&Machine::Cpu) };
            study::run(scene, &options, &mut |_| ControlFlow::Continue(())).expect("it runs")
        })
    };
    let numbers = |outcome: &Outcome| {
        let report = &outcome.report;
        let field: Vec<u64> = outcome.state.iter().map(|value| value.to_bits()).collect();
        let rest = serde_json::to_value((
            report.field,
            &report.conserved,
            &report.error,
            &report.probes,
            report.density,
            report.dt,
        ));
        (field, rest.expect("JSON"), report.path.clone())
    };
    for (scene, path, name) in [
        (scene(false, false), PathWish::Lattice, "lattice"),
        (scene(true, false), PathWish::Lattice, "mixed"),
        (scene(true, false), PathWish::List, "list"),
        (scene(false, true), PathWish::Lattice, "lattice"),
        (scene(true, true), PathWish::Lattice, "mixed"),
        (scene(true, true), PathWish::List, "list"),
        (plane(), PathWish::Lattice, "lattice"),
    ] {
        assert!(scene.problem.particles.len() > 60_000 - 3000, "several tasks");
        let one = numbers(&outcome(&scene, path, 1));
        assert_eq!(one.2, name);
        for threads in [2, 3, 5] {
            assert!(numbers(&outcome(&scene, path, threads)) == one, "{name}, {threads} threads");
        }
    }
}
