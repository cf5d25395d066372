//! What Euler's steps change of the flows to and from what melts: the same on every path and machine, and nothing
//! is lost on the way.

#[expect(dead_code, reason = "these scenes are no shipped cases")]
#[path = "cases/support.rs"]
mod cases;
#[path = "melting/fields.rs"]
mod fields;
#[expect(dead_code, reason = "the tests of one material use the rest")]
#[path = "melting/support.rs"]
mod support;

use diffusph::case::Scene;
use diffusph::model::lattice::LatticeScene;
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::{Backend, Machine, PathWish, Precision};
use diffusph::study;
use serde_json::{Value, json};

use cases::load;
use fields::{furthest, temperatures};
use support::on_gpu;

/// Steps of every run.
const STEPS: u32 = 30;

/// A sheet of `counts` particles that is hot on both sides of where two periodic ends meet, beside held
/// particles; perhaps with a hole, perhaps of two materials.
fn sheet(counts: [u32; 2], hole: bool, two: bool) -> Scene {
    let [x, y] = counts.map(|count| f64::from(count) * 0.01);
    let disc = |radius: f64, part: f64| json!({ "sphere": { "center": [part * x, 0.5 * y], "radius": radius * x } });
    let part = |from: f64, to: f64| {
        let part = json!({ "box": { "min": [from * x, 0], "max": [to * x, y] } });
        match hole {
            true => json!({ "difference": { "of": part, "minus": [disc(0.1, 0.45)] } }),
            false => part,
        }
    };
    let fill = match two {
        false => json!([{ "shape": part(0.0, 1.0), "material": "tin" }]),
        true => json!([
            { "shape": part(0.0, 0.5), "material": "tin" },
            { "shape": part(0.5, 1.0), "material": "lead" }
        ]),
    };
    let metal = |melts: f64| {
        json!({
            "conductivity": 60, "density": 7000, "heat_capacity": 230, "melting_temperature": melts,
            "latent_heat": 6e4, "liquid": { "conductivity": 30 }
        })
    };
    let mut materials = json!({ "tin": metal(505.0) });
    if two {
        materials["lead"] = metal(600.0);
    }
    let case = json!({
        "title": "sheet", "dimension": 2,
        "particles": { "spacing": 0.01, "fill": fill },
        "kernel": { "name": "wendland_c2", "support_ratio": 2.6 },
        "materials": materials,
        "initial": [
            { "value": 480 },
            { "value": 900, "where": { "box": { "min": [0.3 * x, 0], "max": [0.8 * x, 0.3 * y] } } },
            { "value": 900, "where": { "box": { "min": [0.2 * x, 0.8 * y], "max": [0.6 * x, y] } } }
        ],
        "boundaries": [
            { "periodic": { "axes": ["y"] } },
            { "held": { "where": { "box": { "min": [0.65 * x, 0.2 * y], "max": [0.85 * x, 0.4 * y] } }, "value": 300 } },
            { "wall": { "faces": ["x_min"], "kind": { "value": 800 } } },
            { "wall": { "faces": ["x_max"], "kind": "insulated" } }
        ],
        "time": {
            "end": format!("{STEPS}*0.15*spacing^2/3.73e-5"), "method": "euler",
            "step": "0.15*spacing^2/3.73e-5"
        }
    });
    load(&case).unwrap_or_else(|error| panic!("{error}"))
}

/// The same with steps that do not know of fronts.
fn heun(scene: &Scene) -> Scene {
    let mut case: Value = scene.resolved.clone();
    case["time"]["method"] = json!("heun");
    load(&case).unwrap_or_else(|error| panic!("{error}"))
}

/// The step of [`sheet`], s.
fn step(scene: &Scene) -> f64 {
    0.15 * scene.problem.spacing.powi(2) / 3.73e-5
}

/// `scene` on a GPU by lattice, in parts if a buffer may take so many bytes.
fn by_lattice(scene: &Scene, precision: Precision, chunk_bytes: Option<u64>) -> GpuBackend {
    let Machine::Gpu { device, precision } = on_gpu(precision) else {
        panic!("it is a GPU");
    };
    let problem = &scene.problem;
    let lattice = LatticeScene::of(problem).expect("a lattice");
    let (walls, _) = study::lattice_walls(problem, &lattice).expect("good walls");
    let options = GpuOptions { chunk_bytes, ..GpuOptions::new(precision) };
    let backend = GpuBackend::lattice(problem, &lattice, walls, step(scene), &device, options);
    backend.unwrap_or_else(|error| panic!("{error}"))
}

/// The same in one part, or by list.
fn backend(scene: &Scene, precision: Precision, on_lattice: bool) -> GpuBackend {
    if on_lattice {
        return by_lattice(scene, precision, None);
    }
    let Machine::Gpu { device, precision } = on_gpu(precision) else {
        panic!("it is a GPU");
    };
    let backend = GpuBackend::new(&scene.problem, step(scene), &device, precision);
    backend.unwrap_or_else(|error| panic!("{error}"))
}

/// Takes `scene` by lattice, which has to be taken as `path`, and by list: to the same temperatures, with all energy.
fn paths_agree(scene: &Scene, path: &str, name: &str) {
    let (report, on_sites) = temperatures(scene, &Machine::Cpu, PathWish::Lattice);
    let (by_list, listed) = temperatures(scene, &Machine::Cpu, PathWish::List);
    assert_eq!(&*report.path, path, "{name}");
    assert!(report.front.expect("it melts").liquid_volume > 0.0, "{name}");
    let off = furthest(&on_sites, &listed);
    assert!(off < 1e-9, "{name}: {off:e} K");
    for report in [report, by_list] {
        let drift = report.conserved.relative_drift.abs();
        assert!(drift < 1e-12, "{name}, {}: {drift:e}", report.path);
    }
    let (_, without) = temperatures(&heun(scene), &Machine::Cpu, PathWish::List);
    assert!(furthest(&without, &listed) > 0.1, "{name}: fronts are noticed");
}

#[test]
fn paths_of_the_cpu_agree_and_keep_the_energy() {
    // The large ones are worked on in parts, which meet at the periodic ends as well; the hole of the last is passed over.
    for (counts, hole, two) in [
        ([50, 40], false, false),
        ([50, 40], true, false),
        ([50, 40], false, true),
        ([50, 40], true, true),
        ([120, 100], false, false),
        ([180, 250], false, false),
        ([180, 250], true, false),
        ([180, 250], false, true),
        ([700, 160], true, false),
    ] {
        let name = format!("{counts:?}, hole: {hole}, two: {two}");
        paths_agree(&sheet(counts, hole, two), if hole { "mixed" } else { "lattice" }, &name);
    }
}

/// A sheet of two that melt, one of which conducts less than the other.
fn of_other_conductivities(counts: [u32; 2], hole: bool) -> Scene {
    let mut case: Value = sheet(counts, hole, true).resolved.clone();
    case["materials"]["lead"]["conductivity"] = json!(25);
    case["materials"]["lead"]["liquid"]["conductivity"] = json!(15);
    load(&case).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn paths_of_the_cpu_agree_where_what_meets_conducts_differently() {
    for (counts, hole) in [([50, 40], false), ([50, 40], true), ([180, 250], false)] {
        let scene = of_other_conductivities(counts, hole);
        paths_agree(&scene, "mixed", &format!("{counts:?}, hole: {hole}"));
    }
}

#[test]
fn places_without_a_particle_do_not_melt() {
    let scene = sheet([50, 40], true, false);
    // So much colder, the 0 that stands for none is a melting enthalpy.
    let by = 515.0;
    let mut case: Value = scene.resolved.clone();
    let lowered = |value: &mut Value| *value = json!(value.as_f64().expect("a temperature") - by);
    lowered(&mut case["materials"]["tin"]["melting_temperature"]);
    (0..3).for_each(|k| lowered(&mut case["initial"][k]["value"]));
    lowered(&mut case["boundaries"][1]["held"]["value"]);
    lowered(&mut case["boundaries"][2]["wall"]["kind"]["value"]);
    let colder = load(&case).unwrap_or_else(|error| panic!("{error}"));
    let (report, fields) = temperatures(&scene, &Machine::Cpu, PathWish::Lattice);
    let (_, lowered) = temperatures(&colder, &Machine::Cpu, PathWish::Lattice);
    assert_eq!(&*report.path, "mixed");
    let lowered: Vec<f64> = lowered.iter().map(|value| value + by).collect();
    let off = furthest(&fields, &lowered);
    assert!(off < 1e-9, "{off:e} K");
}

#[test]
fn a_gpu_has_the_fronts_of_the_cpu_on_every_path() {
    let sheets = [(false, false), (true, false), (false, true)];
    let sheets = sheets.map(|(hole, two)| (sheet([50, 40], hole, two), hole));
    // Rows where these meet are left to the stencil, but for those beside a hole.
    let others = [false, true].map(|hole| (of_other_conductivities([50, 40], hole), hole));
    for (scene, hole) in sheets.into_iter().chain(others) {
        let (_, cpu) = temperatures(&scene, &Machine::Cpu, PathWish::List);
        for path in [PathWish::Lattice, PathWish::List, PathWish::MatrixFree] {
            for (precision, most, kept) in [
                (Precision::F64, 1e-9, 1e-12),
                (Precision::Compensated, 2e-2, 1e-6),
                (Precision::F32, 0.2, 1e-4),
            ] {
                let (report, gpu) = temperatures(&scene, &on_gpu(precision), path);
                let (off, drift) = (furthest(&cpu, &gpu), report.conserved.relative_drift.abs());
                let what = format!("{} {}, hole: {hole}", report.path, precision.name());
                assert!(off < most && drift < kept, "{what}: {off:e} K, drift {drift:e}");
            }
        }
        let (_, without) = temperatures(&heun(&scene), &Machine::Cpu, PathWish::List);
        assert!(furthest(&without, &cpu) > 1.0, "fronts are noticed");
    }
}

#[test]
fn what_has_melted_by_less_than_f32_can_tell_has_its_flows() {
    // In f32 the melting point is 2.4e-5 K higher: enthalpies of a few steps lie between.
    let case = json!({
        "title": "bar", "dimension": 1,
        "particles": { "spacing": 0.01, "fill": [
            { "shape": { "box": { "min": [0], "max": [0.4] } }, "material": "silicon" }
        ] },
        "kernel": { "name": "wendland_c2", "support_ratio": 2.6 },
        "materials": { "silicon": {
            "conductivity": 60, "density": 7000, "heat_capacity": 230, "melting_temperature": 1687.15,
            "latent_heat": 6e4, "liquid": { "conductivity": 30 }
        } },
        "initial": [{ "value": 1687.15 }],
        "boundaries": [
            { "held": { "where": { "box": { "min": [0], "max": [0.1] } }, "value": 1687.15001 } }
        ],
        "time": { "end": "40*0.1*spacing^2/3.7e-5", "method": "euler", "step": "0.1*spacing^2/3.7e-5" }
    });
    let scene = load(&case).unwrap_or_else(|error| panic!("{error}"));
    let given =
        |machine: &Machine, path| temperatures(&scene, machine, path).0.conserved.boundary_exchange;
    let cpu = given(&Machine::Cpu, PathWish::List);
    for path in [PathWish::Lattice, PathWish::List, PathWish::MatrixFree] {
        let off = given(&on_gpu(Precision::F64), path) / cpu - 1.0;
        assert!(cpu > 0.0 && off.abs() < 1e-4, "{path:?}: {off:e} of {cpu:e}");
    }
}

#[test]
fn a_state_in_parts_has_the_fronts_of_one() {
    let scene = sheet([50, 40], false, false);
    let after = |chunk_bytes: Option<u64>| {
        let mut backend = by_lattice(&scene, Precision::F64, chunk_bytes);
        backend.euler(0.0, step(&scene), u64::from(STEPS)).expect("steps");
        (backend.chunk_count(), backend.read().expect("values").as_ref().to_vec())
    };
    let (one, whole) = after(None);
    let (several, parts) = after(Some(8 * 50 * 11));
    assert!(one == 1 && several >= 4, "{one} and {several} parts");
    assert!(furthest(&whole, &parts) < 1e-9, "{:e} K", furthest(&whole, &parts));
}

#[test]
fn looks_and_copies_between_steps_on_a_gpu_change_nothing() {
    let scene = sheet([30, 24], false, false);
    let step = step(&scene);
    for precision in Precision::ALL {
        for on_lattice in [true, false] {
            let start = || backend(&scene, precision, on_lattice);
            let after = |counts: &[u64]| {
                let mut backend = start();
                for &count in counts {
                    backend.euler(0.0, step, count).expect("steps");
                    assert!(backend.is_finite().expect("a look"));
                    backend.read().expect("values");
                }
                backend.read().expect("values")
            };
            let at_once = after(&[20]);
            let what = format!("{}, on a lattice: {on_lattice}", precision.name());
            assert_eq!(at_once, after(&[1; 20]), "{what}");
            assert_ne!(at_once, after(&[19]), "{what}: a step is noticed");
            let mut backend = start();
            backend.save().expect("a copy");
            let initial = backend.read().expect("values");
            assert_eq!(initial.as_ref()[0] as f32, scene.problem.initial[0] as f32, "{what}");
            backend.euler(0.0, step, 7).expect("steps");
            backend.restore().expect("what was saved");
            assert_eq!(backend.read().expect("values"), initial, "{what}: restored");
            backend.euler(0.0, step, 12).expect("steps");
            backend.save().expect("a copy");
            backend.euler(0.0, step, 3).expect("steps");
            backend.restore().expect("what was saved");
            backend.euler(0.0, step, 8).expect("steps");
            assert_eq!(backend.read().expect("values"), at_once, "{what}: restored later");
        }
    }
}

#[test]
fn a_state_is_good_again_after_one_that_was_lost() {
    let scene = sheet([30, 24], false, false);
    let step = step(&scene);
    for precision in Precision::ALL {
        let mut backend = backend(&scene, precision, true);
        backend.save().expect("a copy");
        for count in [1, 2] {
            backend.euler(0.0, 1e6 * step, 101).expect("steps");
            assert!(!backend.is_finite().expect("a look"), "{}", precision.name());
            let lost = backend.read().expect("values").as_ref().iter().any(|c| !c.is_finite());
            assert!(lost, "{}", precision.name());
            backend.restore().expect("what was saved");
            backend.euler(0.0, step, count).expect("steps");
            assert!(backend.is_finite().expect("a look"), "{}, {count}", precision.name());
            backend.restore().expect("what was saved");
        }
    }
}

#[test]
fn steps_go_on_from_what_others_have_added() {
    let scene = sheet([30, 24], false, false);
    // Some melts by it at once, and some of what melted is solid again.
    let positions = scene.problem.particles.position.iter();
    let change = positions.map(|p| 300.0 * (40.0 * p.x).sin() * (30.0 * p.y).cos());
    let change: Vec<f64> = change.collect();
    fn after<B: Backend>(mut backend: B, step: f64, change: &[f64], times: u32) -> Vec<f64> {
        let mut x = backend.vector().expect("a vector");
        backend.euler(0.0, step, 10).expect("steps");
        for _ in 0..times {
            backend.load(change, &mut x).expect("values");
            backend.add(&x).expect("a sum");
            backend.euler(0.0, step, 5).expect("steps");
        }
        backend.read().expect("values").as_ref().to_vec()
    }
    let step = step(&scene);
    let on_cpu = |times| after(CpuBackend::of(&scene.problem), step, &change, times);
    let cpu = on_cpu(2);
    for (precision, most) in
        [(Precision::F64, 1e-9), (Precision::Compensated, 2e-2), (Precision::F32, 0.2)]
    {
        for on_lattice in [true, false] {
            let backend = backend(&scene, precision, on_lattice);
            let off = furthest(&cpu, &after(backend, step, &change, 2));
            assert!(off < most, "{}, on a lattice: {on_lattice}: {off:e} K", precision.name());
        }
    }
    assert!(furthest(&cpu, &on_cpu(1)) > 1.0, "what is added is noticed");
}
