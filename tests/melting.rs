//! Enthalpy: melting and freezing, conductivities that depend on temperature, on every path and machine.

#[path = "cases/support.rs"]
mod cases;
#[path = "melting/support.rs"]
mod support;

use diffusph::case::Scene;
use diffusph::report::run::RunReport;
use diffusph::solver::gpu::TILE;
use diffusph::solver::{Machine, MachineKind, PathChoice, PathWish, Plan, Precision};
use serde_json::{Value, json};

use cases::{load, shipped};
use support::{on_gpu, run, run_on, steady};

fn melting_rod(n: u32, more: &[&str]) -> Scene {
    let spacing = format!("particles.spacing=0.4/{n}");
    let keys: Vec<&str> = std::iter::once(&*spacing).chain(more.iter().copied()).collect();
    shipped("melting_rod", &keys)
}

/// How far the front is from the exact one, in spacings.
fn off(report: &RunReport, n: u32) -> f64 {
    let front = report.front.expect("it melts");
    (front.position - front.exact.expect("Neumann's solution")) * f64::from(n) / 0.4
}

#[test]
fn the_front_of_the_melting_rod_is_neumanns() {
    for n in [50, 100, 200, 400, 800] {
        let (report, _) = run(&melting_rod(n, &[]));
        assert_eq!(report.path, "lattice");
        assert!(off(&report, n).abs() < 0.012, "n = {n}: {} dx", off(&report, n));
        assert!(report.conserved.relative_drift.abs() < 1e-12);
        if n == 800 {
            let front = report.front.expect("it melts");
            assert!((front.exact.expect("exact") - 0.0197790903).abs() < 1e-10);
            assert!((front.position / 0.0197790903 - 1.0).abs() < 2e-5, "{}", front.position);
        }
    }
    let (lattice, a) = run(&melting_rod(100, &[]));
    let (list, b) = run_on(&melting_rod(100, &[]), &Machine::Cpu, PathWish::List);
    assert_eq!((&*lattice.path, &*list.path), ("lattice", "list"));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9));
    // At 50 the front has passed two particles and a half: what does not know where in a particle it is is late.
    let (heun, _) = run(&melting_rod(50, &["time.method=heun"]));
    assert!(off(&heun, 50) < -0.09, "{} dx", off(&heun, 50));
    // Heat that counts twice is noticed.
    let twice = melting_rod(
        200,
        &["materials.metal.latent_heat=2*63.7e3", "exact.latent_heat=19300*63.7e3"],
    );
    assert!(off(&run(&twice).0, 200).abs() > 1.0);
}

#[test]
fn other_latent_heats_have_their_fronts() {
    for (latent, exact) in [("6.37e3", 0.0332186384), ("630e3", 0.0076576295)] {
        let heat = format!("materials.metal.latent_heat={latent}");
        for n in [200, 400] {
            let (report, _) = run(&melting_rod(n, &[&heat]));
            let front = report.front.expect("it melts");
            assert!((front.exact.expect("exact") / exact - 1.0).abs() < 1e-8);
            assert!(off(&report, n).abs() < 0.2, "{latent}, n = {n}: {} dx", off(&report, n));
        }
    }
}

#[test]
fn temperatures_beside_the_front_are_of_first_order_or_better() {
    let error = |n: u32| run(&melting_rod(n, &[])).0.error.expect("exact").l2_relative;
    let errors = [100, 200, 400, 800, 1600].map(error);
    // What the front's phase in its cell does goes up and down: over four octaves it falls.
    let slope = (errors[0] / errors[4]).log2() / 4.0;
    assert!(slope > 1.5, "{errors:?}: {slope}");
}

#[test]
fn implicit_steps_of_a_hundred_limits_keep_the_front() {
    for n in [400, 800] {
        let step = "time.step=100*0.5*spacing^2/1.28e-4";
        let (report, _) = run(&melting_rod(n, &["time.method=tr_bdf2", step]));
        assert!(off(&report, n).abs() < 0.2, "n = {n}: {} dx", off(&report, n));
        assert!(report.conserved.relative_drift.abs() < 1e-12, "{:?}", report.conserved);
    }
}

#[test]
fn methods_agree_on_the_front() {
    for method in ["heun", "rkl2", "tr_bdf2"] {
        let keys = [&*format!("time.method={method}"), "time.tolerance.relative=1e-5"];
        let (report, _) = run(&melting_rod(200, &keys));
        assert!(off(&report, 200).abs() < 0.01, "{method}: {} dx", off(&report, 200));
        assert!(report.conserved.relative_drift.abs() < 1e-12, "{method}: {:?}", report.conserved);
    }
}

/// A short rod of the same metal between walls that go up to 500 K and back to 300 K.
fn there_and_back(end: f64) -> Scene {
    let mut case =
        serde_json::from_str::<Value>(include_str!("../cases/melting_rod.json")).expect("JSON");
    case["particles"]["fill"][0]["shape"]["box"]["max"] = json!([0.02]);
    case["particles"]["spacing"] = json!(0.001);
    case["boundaries"] = json!([
        { "wall": { "faces": ["x_min", "x_max"], "kind": { "value": "300 + 200*(1 - step(t - 20))" } } }
    ]);
    case["time"]["end"] = json!(end);
    if end > 20.0 {
        case["time"]["breaks"] = json!([20]);
    }
    for key in ["exact", "probes", "output"] {
        case.as_object_mut().expect("an object").remove(key);
    }
    load(&case).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn what_melts_and_freezes_again_is_what_it_was() {
    let (hot, state) = run(&there_and_back(20.0));
    assert!((hot.front.expect("it melts").position - 0.02).abs() < 1e-12, "all is liquid");
    assert!(state.iter().all(|enthalpy| *enthalpy > 800.0));
    let (cold, state) = run(&there_and_back(80.0));
    assert_eq!(cold.front.expect("it melts").position, 0.0);
    let worst = state.iter().map(|enthalpy| (enthalpy - 300.0).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst:e}");
    assert!(cold.conserved.relative_drift.abs() < 1e-12);
}

/// A bar of 0.4 m that melts at 300 K, from 280 to `hot` (K) in a step.
fn half_hot(hot: f64, walls: Value) -> Value {
    json!({
        "title": "half hot", "dimension": 1,
        "particles": { "spacing": 0.01,
            "fill": [{ "shape": { "box": { "min": [0], "max": [0.4] } }, "material": "m" }] },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "materials": { "m": {
            "conductivity": [[250, 2], [300, 4]], "density": 1000, "heat_capacity": 1,
            "melting_temperature": 300, "latent_heat": 50,
            "liquid": { "conductivity": 1, "heat_capacity": 2 }
        } },
        "initial": [
            { "value": 280 }, { "value": hot, "where": { "box": { "min": [0.2], "max": [0.4] } } }
        ],
        "boundaries": walls
    })
}

#[test]
fn steady_states_of_what_melts_keep_its_energy_or_its_walls() {
    let value =
        |face: &str, value: f64| json!({ "wall": { "faces": [face], "kind": { "value": value } } });
    let held = steady(half_hot(280.0, json!([value("x_min", 260.0), value("x_max", 340.0)])));
    let insulated = json!([{ "wall": { "faces": ["x_min", "x_max"], "kind": "insulated" } }]);
    for machine in [Machine::Cpu, on_gpu(Precision::F64)] {
        // Heat flows k of the solid, 3.2 on average from 260 K, times 40 K, then 1 times 40 K.
        let (report, state) = run_on(&held, &machine, PathWish::Auto);
        let solid = 0.4 * (40.0 * 3.2) / (40.0 * 3.2 + 40.0);
        let front = 0.4 - report.front.expect("it melts").position;
        assert!((front - solid).abs() < 0.01, "{front} {solid}");
        let fall = |x: f64| 40.0 * (0.4 - x) / (0.4 - solid);
        for (x, value) in held.problem.particles.position.iter().zip(&*held.problem.values(&state))
        {
            if x.x > solid {
                assert!((value - (340.0 - fall(x.x))).abs() < 1e-8, "{x} {value}");
            }
        }
        // The heat of 320 K, 20 + 50 / 1 + 2 x 20, or a part of it, shared by two halves.
        for (hot, wanted) in [(290.0, 285.0), (320.0, 300.0), (345.0, 305.0)] {
            let scene = steady(half_hot(hot, insulated.clone()));
            let (report, state) = run_on(&scene, &machine, PathWish::Auto);
            let values = scene.problem.values(&state);
            let off = values.iter().map(|value| (value - wanted).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{hot}: {off:e}");
            let drift = report.conserved.relative_drift.abs();
            assert!(drift < 1e-13, "{hot}: {drift:e}");
            let liquid = report.front.expect("it melts").position / 0.4;
            let expected = if hot == 320.0 { 0.7 } else { f64::from(hot > 320.0) };
            assert!((liquid - expected).abs() < 1e-12, "{hot}: {liquid}");
        }
    }
}

/// Everything at once: a range of melting, a table, a held corner, a flux, a moving source, a hole.
fn everything(method: &str, hole: bool) -> Value {
    let body = json!({ "box": { "min": [0, 0], "max": [0.04, 0.03] } });
    let shape = match hole {
        true => {
            json!({ "difference": {
            "of": body, "minus": [{ "sphere": { "center": [0.02, 0.011], "radius": 0.004 } }]
        } })
        }
        false => body,
    };
    json!({
        "title": "everything", "dimension": 2,
        "particles": { "spacing": 0.001, "fill": [{ "shape": shape, "material": "m" }] },
        "kernel": { "name": "wendland_c2", "support_ratio": 2.5 },
        "materials": { "m": {
            "conductivity": [[300, 40], [500, 25]], "density": 7000, "heat_capacity": 500,
            "melting_temperature": [480, 520], "latent_heat": 2e5,
            "liquid": { "conductivity": 18, "density": 6500, "heat_capacity": 700 }
        } },
        "initial": [{ "value": "300 + 3000*x" }, { "amount": 4e4, "at": [0.01, 0.02] }],
        "boundaries": [
            { "held": { "where": { "box": { "min": [0, 0], "max": [0.005, 0.004] } }, "value": 300 } },
            { "wall": { "faces": ["x_max"], "kind": { "flux": 2e5 } } },
            { "wall": { "faces": ["y_max"], "kind": { "value": "450 + 150*sin(3*t)" } } },
            { "wall": { "faces": ["x_min", "y_min"], "kind": "insulated" } }
        ],
        "sources": [{ "power": 3e4, "path": [[0.01, 0.025], [0.03, 0.025]], "speed": 0.02 }],
        "time": { "end": 1.5, "method": method, "tolerance": { "relative": 1e-4 } }
    })
}

#[test]
fn with_everything_at_once_energy_is_conserved() {
    for method in ["euler", "heun", "rkl2", "tr_bdf2"] {
        for (hole, path) in
            [(false, PathWish::Lattice), (true, PathWish::Lattice), (true, PathWish::List)]
        {
            let mut case = everything(method, hole);
            if method == "euler" {
                case["time"].as_object_mut().expect("an object").remove("tolerance");
            }
            let scene = load(&case).unwrap_or_else(|error| panic!("{error}"));
            let (report, _) = run_on(&scene, &Machine::Cpu, path);
            let front = report.front.expect("it melts");
            assert!(front.liquid_volume > 1e-7, "{method}: {front:?}");
            let drift = report.conserved.relative_drift.abs();
            assert!(drift < 1e-12, "{method} on {}: {drift:e}", report.path);
        }
    }
}

#[test]
fn a_gpu_melts_as_the_cpu_does() {
    for (method, most) in [
        ("euler", [1e-9, 5e-4, 2e-2]),
        ("rkl2", [1e-9, 5e-4, 2e-2]),
        ("tr_bdf2", [1e-3, 2e-2, 0.5]),
    ] {
        for path in [PathWish::Lattice, PathWish::List] {
            let steps =
                if method == "euler" { "0.2*spacing^2/1.28e-4" } else { "5*spacing^2/1.28e-4" };
            let keys =
                [&*format!("time.method={method}"), &format!("time.step={steps}"), "time.end=5"];
            let scene = melting_rod(100, &keys);
            let (_, cpu) = run_on(&scene, &Machine::Cpu, path);
            for (precision, most) in
                [Precision::F64, Precision::Compensated, Precision::F32].into_iter().zip(most)
            {
                let (report, gpu) = run_on(&scene, &on_gpu(precision), path);
                let worst = cpu.iter().zip(&gpu).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                let drift = report.conserved.relative_drift.abs();
                let kept = match precision {
                    Precision::F64 => 1e-12,
                    Precision::Compensated => 1e-7,
                    Precision::F32 => 1e-5,
                };
                let what = format!("{method} {path:?} {}", precision.name());
                assert!(worst < most && drift < kept, "{what}: {worst:e} K, drift {drift:e}");
            }
        }
    }
}

#[test]
fn a_gpu_does_everything_at_once_as_the_cpu_does() {
    for (hole, path) in
        [(false, PathWish::Lattice), (true, PathWish::List), (true, PathWish::MatrixFree)]
    {
        let mut case = everything("euler", hole);
        case["time"].as_object_mut().expect("an object").remove("tolerance");
        let scene = load(&case).unwrap_or_else(|error| panic!("{error}"));
        let (_, cpu) = run_on(&scene, &Machine::Cpu, PathWish::List);
        for (precision, most, kept) in
            [(Precision::F64, 1e-8, 1e-12), (Precision::Compensated, 0.05, 1e-6)]
        {
            let (report, gpu) = run_on(&scene, &on_gpu(precision), path);
            let worst = cpu.iter().zip(&gpu).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let drift = report.conserved.relative_drift.abs();
            let what = format!("{path:?} {}", precision.name());
            assert!(worst < most && drift < kept, "{what}: {worst:e} K, drift {drift:e}");
            assert!(report.front.expect("it melts").liquid_volume > 1e-7, "{what}");
        }
    }
}

fn refused(change: impl Fn(&mut Value), expected: &str) {
    let mut case = everything("rkl2", false);
    change(&mut case);
    let error = load(&case).map(|_| ()).expect_err("it is refused");
    assert!(error.contains(expected), "{error}\nis not: {expected}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let material = |key: &'static str, value: Value| {
        move |case: &mut Value| {
            let material = case["materials"]["m"].as_object_mut().expect("an object");
            match value {
                Value::Null => material.remove(key),
                _ => material.insert(key.to_owned(), value.clone()),
            };
        }
    };
    refused(
        material("melting_temperature", Value::Null),
        "materials.m.latent_heat: not used: the material has no melting_temperature",
    );
    refused(material("latent_heat", Value::Null), "materials.m.latent_heat: missing key");
    refused(material("latent_heat", json!(-1)), "materials.m.latent_heat: is -1, must be positive");
    refused(
        material("melting_temperature", json!([500, 400])),
        "materials.m.melting_temperature[1]: is 400, must be no less than where melting begins",
    );
    refused(
        material("melting_temperature", json!([500])),
        "expected one temperature or two, found 1",
    );
    refused(material("diffusivity", json!(1)), "materials.m.conductivity: not used");
    refused(
        material("conductivity", json!([[300, 5], [300, 6]])),
        "materials.m.conductivity[1][0]: is 300, must be above the temperature before",
    );
    refused(
        material("conductivity", json!([[300, -5]])),
        "materials.m.conductivity[0][1]: is -5, must be positive",
    );
    refused(material("conductivity", json!("350 - T")), "must be positive and finite at T = ");
    refused(
        material("conductivity", json!("((T - 350)/10)^2 - 1")),
        "must be positive and finite at T = ",
    );
    refused(material("conductivity", json!("5 + x")), "\"x\" has no meaning here");
    refused(
        |case| {
            case["boundaries"][1]["wall"]["kind"] =
                json!({ "convection": { "coefficient": 1, "ambient": 300 } })
        },
        "a convection wall needs materials whose conductivity does not depend on temperature",
    );
    refused(
        |case| case["sources"][0] = json!({ "linear": -1 }),
        "a source in proportion to the temperature needs materials",
    );
    refused(
        |case| {
            case["time"]["method"] = json!("tr_bdf2");
            case["time"]["preconditioner"] = json!("two_level");
        },
        "time.preconditioner: not used: Newton's method",
    );
}

#[test]
fn scenes_that_do_not_melt_pay_nothing() {
    let plain = r#"materials={"metal":{"conductivity":"1.28e-4*19300*129","density":19300,"heat_capacity":129}}"#;
    let no_exact = "exact=null";
    let (melting, _) = run(&melting_rod(800, &["time.end=0.5", no_exact]));
    let (conducting, _) = run(&melting_rod(800, &["time.end=0.5", no_exact, plain]));
    // The enthalpy, the copy of it that a run falls back to, place, lines and enthalpy of the particle that melts, the latter
    // before a step and after it, and between which places there is the curve.
    assert_eq!(melting.memory_bytes - conducting.memory_bytes, 800 * 16 + 24 + 16);
    assert!(conducting.front.is_none());
    // On a GPU a step reads one enthalpy and writes another, and tiles of what melts are listed.
    let machine = on_gpu(Precision::F64);
    let keys = ["time.end=0.01", no_exact, plain];
    let bytes = |keys: &[&str]| {
        let scene = melting_rod(800, keys);
        let (kind, wish) = (MachineKind::Gpu(Precision::F64), PathWish::Lattice);
        let choice = PathChoice::new(&scene.problem, kind, wish).expect("a path");
        let plan = Plan::new(&scene.problem, kind, &choice, 1);
        let (report, _) = run_on(&scene, &machine, wish);
        (report.memory_bytes, plan.memory_bytes(&scene.problem, 1))
    };
    let ((melting, planned), (conducting, planned_without)) = (bytes(&keys[..2]), bytes(&keys));
    assert_eq!(planned - planned_without, 800 * 3 * 8 + 5 * 4 * (800 / TILE as u64));
    // Beside those the curve and what the device counts.
    let more = (melting - conducting) - (planned - planned_without);
    assert!(more < 600, "{more} bytes");
}
