//! Several materials of which one melts or conducts as its temperature, on every path and machine.

#[expect(dead_code, reason = "these scenes are no shipped cases")]
#[path = "cases/support.rs"]
mod cases;
#[path = "melting/fields.rs"]
mod fields;
#[expect(dead_code, reason = "the tests of one material use the rest")]
#[path = "melting/support.rs"]
mod support;

use diffusph::case::Scene;
use diffusph::model::lattice::MixedScene;
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::{Backend, Machine, PathWish, Precision};
use serde_json::{Value, json};

use cases::load;
use fields::{furthest, temperatures};
use support::{on_gpu, run_on};

/// Two bars of conductivities 3 and 10 that touch, the right one as given.
fn bars(right: &Value, method: &str) -> Value {
    let bar = |from: f64, to: f64, material: &str| json!({ "shape": { "box": { "min": [from, 0], "max": [to, 0.2] } }, "material": material });
    let mut left = json!({ "conductivity": 3, "density": 1000, "heat_capacity": 2 });
    if right.get("melting_temperature").is_some() {
        left["conductivity"] = json!([[300, 3], [400, 4]]);
    }
    json!({
        "title": "bars", "dimension": 2,
        "particles": { "spacing": 0.02, "fill": [bar(0.0, 0.4, "left"), bar(0.4, 1.0, "right")] },
        "kernel": { "name": "wendland_c2", "support_ratio": 2.6 },
        "materials": { "left": left, "right": right },
        "initial": [{ "value": 300 }],
        "boundaries": [
            { "wall": { "faces": ["x_min"], "kind": { "value": 700 } } },
            { "wall": { "faces": ["x_max"], "kind": { "flux": -1000 } } },
            { "wall": { "faces": ["y_min"], "kind": "insulated" } },
            { "held": { "where": { "box": { "min": [0.3, 0.15], "max": [0.5, 0.2] } }, "value": 320 } }
        ],
        "time": { "end": 100, "method": method, "tolerance": { "relative": 1e-5 } }
    })
}

#[test]
fn materials_that_meet_exchange_heat_by_their_temperatures() {
    let plain = json!({ "conductivity": 10, "density": 1000, "heat_capacity": 1 });
    let table = json!([[300, 10], [400, 10.000001]]);
    let as_table = json!({ "conductivity": table, "density": 1000, "heat_capacity": 1 });
    let melts = json!({
        "conductivity": 10, "density": 1000, "heat_capacity": 1,
        "melting_temperature": 330, "latent_heat": 100, "liquid": { "conductivity": 4 }
    });
    for method in ["rkl2", "tr_bdf2"] {
        let of = |right: &Value, path| {
            let scene = load(&bars(right, method)).unwrap_or_else(|error| panic!("{error}"));
            let (report, values) = temperatures(&scene, &Machine::Cpu, path);
            let drift = report.conserved.relative_drift.abs();
            assert!(drift < 1e-12, "{method}, {path:?}: {drift:e}");
            (report, values)
        };
        let (_, of_plain) = of(&plain, PathWish::List);
        let (_, of_table) = of(&as_table, PathWish::List);
        assert!(
            furthest(&of_plain, &of_table) < 1e-3,
            "{method}: {}",
            furthest(&of_plain, &of_table)
        );
        let (report, list) = of(&melts, PathWish::List);
        let (mixed, lattice) = of(&melts, PathWish::Lattice);
        assert_eq!(mixed.path, "mixed");
        assert!(report.front.expect("it melts").liquid_volume > 1e-3, "{:?}", report.front);
        assert!(furthest(&list, &lattice) < 1e-3, "{method}: {}", furthest(&list, &lattice));
        assert!(furthest(&list, &of_plain) > 1.0, "melting is noticed");
    }
}

/// What melts beside the left bar, whose conductivity depends on temperature then.
fn melting() -> Value {
    json!({
        "conductivity": 10, "density": 1000, "heat_capacity": 1,
        "melting_temperature": 330, "latent_heat": 100, "liquid": { "conductivity": 4 }
    })
}

/// The bars with equal steps, which leave no step to what rounding makes of an estimate: so many steps of
/// `share` of the longest that explicit Euler may take, 0.0102 s.
fn in_equal_steps(right: &Value, method: &str, share: f64, steps: u32) -> Scene {
    let mut case = bars(right, method);
    let step = share * 0.01;
    // Some of the right bar is liquid.
    case["initial"] = json!([{ "value": "600 - 500*x" }]);
    case["time"] = json!({ "end": step * f64::from(steps), "step": step, "method": method });
    load(&case).unwrap_or_else(|error| panic!("{error}"))
}

/// Methods with the length of their steps and how many they take.
const METHODS: [(&str, f64, u32); 4] =
    [("euler", 1.0, 400), ("heun", 1.0, 200), ("rkl2", 8.0, 60), ("tr_bdf2", 8.0, 60)];

#[test]
fn a_gpu_does_what_the_cpu_does() {
    for (method, share, steps) in METHODS {
        let scene = in_equal_steps(&melting(), method, share, steps);
        let (report, on_cpu) = temperatures(&scene, &Machine::Cpu, PathWish::List);
        assert!(report.front.expect("it melts").liquid_volume > 1e-3, "{method}");
        // Of 700 K, 1e-6 and 1e-5 where differences have the words of f32.
        for (precision, most, kept) in [
            (Precision::F64, 1e-11, 1e-14),
            (Precision::Compensated, 7e-4, 1e-6),
            (Precision::F32, 7e-3, 1e-6),
        ] {
            for path in [PathWish::List, PathWish::Lattice, PathWish::MatrixFree] {
                // A search takes long on a software adapter.
                if path == PathWish::MatrixFree && (precision == Precision::F32 || method == "heun")
                {
                    continue;
                }
                let (report, here) = temperatures(&scene, &on_gpu(precision), path);
                let what = format!("{method} {} {}", report.path, precision.name());
                let (off, drift) =
                    (furthest(&on_cpu, &here), report.conserved.relative_drift.abs());
                assert!(off < most && drift < kept, "{what}: {off:e} K, drift {drift:e}");
            }
        }
    }
}

#[test]
fn rates_on_a_gpu_know_what_materials_exchange() {
    let mut problem = in_equal_steps(&melting(), "euler", 1.0, 400).problem;
    // Some melt, some have.
    let x = |p: usize| problem.particles.position[p].x;
    let initial: Vec<f64> = (0..problem.initial.len()).map(|p| 500.0 - 200.0 * x(p)).collect();
    problem.initial.clone_from(&initial);
    let rates_of = |problem: &diffusph::model::Problem| {
        let Machine::Gpu { device, precision } = on_gpu(Precision::F64) else { unreachable!() };
        let mut backend = GpuBackend::new(problem, 0.01, &device, precision).expect("backend");
        backend.rate(0.0).expect("rates").as_ref().to_vec()
    };
    let expected = CpuBackend::of(&problem).rate(0.0).expect("rates").as_ref().to_vec();
    let largest = expected.iter().fold(0.0, |m: f64, rate| m.max(rate.abs()));
    let off = furthest(&expected, &rates_of(&problem)) / largest;
    assert!(off < 1e-12, "{off:e}");
    // The curve of one material for the other's is noticed, and so is one that goes on without melting.
    let mut swapped = problem.clone();
    let curves = [0, 1].map(|m: usize| problem.materials[m].curve.clone());
    let [left, right] = curves;
    (swapped.materials[0].curve, swapped.materials[1].curve) = (right, left);
    assert!(furthest(&expected, &rates_of(&swapped)) / largest > 1e-3);
    let mut solid = problem.clone();
    solid.materials[1].curve = None;
    assert!(furthest(&expected, &rates_of(&solid)) / largest > 1e-3);
}

#[test]
fn auto_takes_a_gpu_where_several_materials_melt() {
    let scene = in_equal_steps(&melting(), "euler", 1.0, 2);
    let (report, _) = run_on(&scene, &on_gpu(Precision::F64), PathWish::Auto);
    assert_eq!((report.path, report.backend), ("mixed".into(), "gpu".into()));
}

#[test]
fn several_materials_that_melt_have_a_state_in_one_part() {
    let problem = in_equal_steps(&melting(), "euler", 1.0, 2).problem;
    let scene = MixedScene::of(&problem).expect("a lattice in part");
    let (_, rows) = scene.assemble(&problem);
    let Machine::Gpu { device, precision } = on_gpu(Precision::F64) else { unreachable!() };
    let with = |chunk_bytes| {
        let options = GpuOptions { chunk_bytes, ..GpuOptions::new(precision) };
        GpuBackend::mixed(&problem, &scene, &rows, 0.01, &device, options)
    };
    with(None).expect("a backend");
    let counts = scene.lattice.counts.map(|count| count as u64);
    let [eight_lines, all] = [8, counts[1]].map(|lines| lines * counts[0] * precision.bytes());
    let error = with(Some(eight_lines)).expect_err("several curves").to_string();
    assert!(error.contains("several materials") && error.contains(&all.to_string()), "{error}");
}

#[test]
fn steps_of_potentials_do_what_steps_of_enthalpies_do() {
    let temperatures_with = |left: &Value, melts_at: &Value, path| {
        let mut right = melting();
        right["melting_temperature"] = melts_at.clone();
        let mut case = bars(&right, "euler");
        case["materials"]["left"]["conductivity"] = left.clone();
        case["initial"] = json!([{ "value": "300 + 300*step(0.4-x)" }]);
        case["time"] = json!({ "end": 10, "method": "euler" });
        let scene = load(&case).unwrap_or_else(|error| panic!("{error}"));
        let (report, values) = temperatures(&scene, &Machine::Cpu, path);
        let drift = report.conserved.relative_drift.abs();
        assert!(drift < 1e-12, "{path:?}: {drift:e}");
        assert!(report.front.expect("it melts").liquid_volume > 1e-3, "{:?}", report.front);
        values
    };
    // A conductivity that changes has no potentials that tell enthalpies.
    let table = json!([[300, 3], [400, 3.0 + 1e-9]]);
    for melts_at in [json!(330), json!([320, 345])] {
        for path in [PathWish::List, PathWish::Lattice] {
            let by_potentials = temperatures_with(&json!(3), &melts_at, path);
            let by_enthalpies = temperatures_with(&table, &melts_at, path);
            let off = furthest(&by_potentials, &by_enthalpies);
            assert!(off < 1e-5, "{melts_at}, {path:?}: {off:e}");
            let other = temperatures_with(&json!(3.1), &melts_at, path);
            let other = furthest(&by_potentials, &other);
            assert!(other > 0.1, "another conductivity is noticed: {other:e}");
        }
    }
}

/// The bars without conductivities that change, so that potentials tell enthalpies; the left one melts too if `both`
/// do. Steps of 5 ms.
fn told(both: bool) -> Scene {
    told_of(melting(), both)
}

/// The same with this as the right bar.
fn told_of(right: Value, both: bool) -> Scene {
    let mut case = bars(&right, "euler");
    let left = &mut case["materials"]["left"];
    left["conductivity"] = json!(3);
    // Liquid where they meet: there a potential tells its enthalpy only to rounding.
    let (mut hottest, mut right) = (600, "300 + 300*step(0.6-x) + 50*sin(7*x)");
    if both {
        left["melting_temperature"] = json!(560);
        left["latent_heat"] = json!(60);
        left["liquid"] = json!({ "conductivity": 5 });
        (hottest, right) = (900, "200 + 800*y");
    }
    case["initial"] = json!([
        { "value": format!("{hottest} + 50*sin(7*x)") },
        { "value": right, "where": { "box": { "min": [0.4, 0], "max": [1, 0.2] } } }
    ]);
    case["time"] = json!({ "end": 2, "method": "euler", "step": 5e-3 });
    load(&case).unwrap_or_else(|error| panic!("{error}"))
}

/// By lattice in part, or by list.
fn on_device(scene: &Scene, precision: Precision, on_lattice: bool) -> GpuBackend {
    let (problem, Machine::Gpu { device, precision }) = (&scene.problem, on_gpu(precision)) else {
        unreachable!()
    };
    if !on_lattice {
        return GpuBackend::new(problem, 5e-3, &device, precision).expect("a backend");
    }
    let scene = MixedScene::of(problem).expect("a lattice in part");
    let (_, rows) = scene.assemble(problem);
    let options = GpuOptions::new(precision);
    GpuBackend::mixed(problem, &scene, &rows, 5e-3, &device, options).expect("a backend")
}

/// The state after steps of 5 ms, with looks after so many of them.
fn after(mut backend: impl Backend, looks: &[u64]) -> Vec<f64> {
    for &count in looks {
        backend.euler(0.0, 5e-3, count).expect("steps");
        backend.read().expect("a field");
        // This one needs all enthalpies in memory.
        backend.largest_value().expect("a number");
    }
    backend.read().expect("a field").as_ref().to_vec()
}

#[test]
fn potentials_of_several_materials_go_on_alike_on_every_machine() {
    for both in [false, true] {
        let scene = told(both);
        let (report, on_cpu) = temperatures(&scene, &Machine::Cpu, PathWish::List);
        let before = scene.problem.values(&scene.problem.initial).into_owned();
        assert!(furthest(&on_cpu, &before) > 10.0, "it changes");
        assert!(report.front.expect("it melts").liquid_volume > 1e-3, "both: {both}");
        for (precision, most, kept) in [
            (Precision::F64, 1e-10, 1e-13),
            (Precision::Compensated, 7e-4, 1e-7),
            (Precision::F32, 2e-2, 1e-5),
        ] {
            for path in [PathWish::List, PathWish::Lattice] {
                let (report, here) = temperatures(&scene, &on_gpu(precision), path);
                let what = format!("{} {}, both: {both}", report.path, precision.name());
                let (off, drift) =
                    (furthest(&on_cpu, &here), report.conserved.relative_drift.abs());
                assert!(off < most && drift < kept, "{what}: {off:e} K, drift {drift:e}");
            }
        }
        let other = temperatures(&told(!both), &Machine::Cpu, PathWish::List).1;
        assert!(furthest(&on_cpu, &other) > 1.0, "what the left one does is noticed");
    }
}

#[test]
fn what_begins_to_melt_by_what_materials_exchange_alone_is_noticed() {
    let values = |colder: u32, on_lattice: Option<bool>| {
        let mut case = bars(&melting(), "euler");
        // From a liquid of the left more flows than its potential says.
        case["materials"]["left"] = json!({
            "conductivity": 3, "density": 1000, "heat_capacity": 2,
            "melting_temperature": 335, "latent_heat": 100, "liquid": { "conductivity": 1 }
        });
        case["initial"] = json!([{ "value": format!("900 - {}*step(x-0.4)", 570 + colder) }]);
        case["boundaries"] = json!([]);
        case["time"] = json!({ "end": 0.05, "method": "euler", "step": 5e-3 });
        let scene = load(&case).unwrap_or_else(|error| panic!("{error}"));
        match on_lattice {
            None => after(CpuBackend::of(&scene.problem), &[10]),
            Some(is_so) => after(on_device(&scene, Precision::F64, is_so), &[10]),
        }
    };
    // So much below melting the right one begins: from 22 K it gets there only with what is added.
    for colder in [14, 18, 22, 26, 30] {
        let on_cpu = values(colder, None);
        // The enthalpies of the right bar's melting are above 330 K.
        assert!(on_cpu.iter().any(|&enthalpy| 330.0 < enthalpy && enthalpy < 430.0), "it melts");
        for on_lattice in [false, true] {
            let off = furthest(&on_cpu, &values(colder, Some(on_lattice)));
            assert!(off < 1e-10, "{colder} K colder, on a lattice: {on_lattice}: {off:e} K");
        }
    }
}

#[test]
fn a_look_between_steps_changes_nothing() {
    for both in [false, true] {
        let scene = told(both);
        let on_cpu = |looks: &[u64]| after(CpuBackend::of(&scene.problem), looks);
        assert_eq!(on_cpu(&[400]), on_cpu(&[1; 400]));
        assert_ne!(on_cpu(&[400]), on_cpu(&[399]), "a step is noticed");
        for precision in Precision::ALL {
            for on_lattice in [false, true] {
                let here = |looks: &[u64]| after(on_device(&scene, precision, on_lattice), looks);
                let what = format!("{}, on a lattice: {on_lattice}", precision.name());
                assert_eq!(here(&[60]), here(&[1; 60]), "{what}");
                assert_ne!(here(&[60]), here(&[59]), "{what}: a step is noticed");
            }
        }
    }
}

#[test]
fn a_look_between_steps_over_a_range_changes_nothing_but_rounding() {
    let mut right = melting();
    right["melting_temperature"] = json!([320, 345]);
    for both in [false, true] {
        let scene = told_of(right.clone(), both);
        let on_cpu = |looks: &[u64]| after(CpuBackend::of(&scene.problem), looks);
        let off = furthest(&on_cpu(&[400]), &on_cpu(&[1; 400]));
        assert!(off < 1e-10, "both: {both}: {off:e}");
        assert!(furthest(&on_cpu(&[400]), &on_cpu(&[399])) > 1e-4, "a step is noticed");
    }
}

#[test]
fn rates_after_steps_on_a_gpu_are_those_of_the_state() {
    let scene = told(true);
    let mut on_cpu = CpuBackend::of(&scene.problem);
    for on_lattice in [false, true] {
        let mut here = on_device(&scene, Precision::F64, on_lattice);
        // An odd number: enthalpies of what has never melted were not written in that of the two places.
        here.euler(0.0, 5e-3, 7).expect("steps");
        let rates = here.rate(0.0).expect("rates").as_ref().to_vec();
        if !on_lattice {
            on_cpu.euler(0.0, 5e-3, 7).expect("steps");
        }
        let expected = on_cpu.rate(0.0).expect("rates").as_ref().to_vec();
        let largest = expected.iter().fold(0.0, |m: f64, rate| m.max(rate.abs()));
        let off = furthest(&expected, &rates) / largest;
        assert!(off < 1e-10, "on a lattice: {on_lattice}: {off:e}");
    }
}

#[test]
fn what_was_saved_on_a_gpu_goes_on_as_if_nothing_had_been_between() {
    let scene = told(true);
    for precision in Precision::ALL {
        for on_lattice in [false, true] {
            let mut backend = on_device(&scene, precision, on_lattice);
            backend.euler(0.0, 5e-3, 20).expect("steps");
            backend.save().expect("a copy");
            backend.euler(0.0, 5e-3, 20).expect("steps");
            let expected = backend.read().expect("a field");
            backend.restore().expect("what was saved");
            // A step that is far too long loses it.
            backend.euler(0.0, 1e4, 60).expect("steps");
            assert!(!backend.is_finite().expect("a look"), "{}", precision.name());
            backend.restore().expect("what was saved");
            backend.euler(0.0, 5e-3, 20).expect("steps");
            let what = format!("{}, on a lattice: {on_lattice}", precision.name());
            assert_eq!(backend.read().expect("a field"), expected, "{what}");
            assert!(backend.is_finite().expect("a look"), "{what}");
        }
    }
}
