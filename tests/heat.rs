//! Heat: materials with conductivity and capacity, the poster's rod and square, contact, point sources.

use std::ops::ControlFlow;

use diffusph::case::Scene;
use diffusph::model::Problem;
use diffusph::model::operator::rows::{cell_grid, survey};
use diffusph::report::run::RunReport;
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::{Backend, Machine, PathWish, Precision};
use diffusph::study::{self, RunOptions};
use serde_json::{Value, json};

use cases::{load, shipped};

#[path = "cases/support.rs"]
mod cases;
#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

fn run_on(scene: &Scene, path: PathWish) -> (RunReport, Vec<f64>) {
    let options = RunOptions { path, ..RunOptions::new(&Machine::Cpu) };
    let outcome = study::run(scene, &options, &mut |_| ControlFlow::Continue(()))
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(outcome.stopped.is_none(), "{:?}", outcome.stopped);
    (outcome.report, outcome.state)
}

fn run(scene: &Scene) -> RunReport {
    run_on(scene, PathWish::Auto).0
}

fn l2(report: &RunReport) -> f64 {
    report.error.as_ref().expect("an exact solution").l2_relative
}

/// log2 of the ratios of consecutive errors.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

fn assert_order_two(errors: &[f64]) {
    let found = orders(errors);
    assert!(found.iter().all(|order| (order - 2.0).abs() < 0.05), "{found:?} of {errors:?}");
}

#[test]
fn the_rod_is_second_order_and_as_good_as_known() {
    let at = |n: u32, more: &[&str]| {
        let spacing = format!("particles.spacing=0.1/{n}");
        let keys: Vec<&str> = std::iter::once(&*spacing).chain(more.iter().copied()).collect();
        shipped("rod", &keys)
    };
    let counts = [40, 80, 160, 320];
    let errors = counts.map(|n| l2(&run(&at(n, &[]))));
    assert_order_two(&errors);
    assert!(errors[3] < 1e-6, "{:e}", errors[3]);
    // Other methods do not have the luck that the error of that step takes from that of space.
    let tolerance = ["time.method=rkl2", "time.tolerance.relative=1e-8"];
    let errors = counts.map(|n| l2(&run(&at(n, &tolerance))));
    assert_order_two(&errors);
    assert!(errors[3] < 3.4e-6, "{:e}", errors[3]);
    let (lattice, a) = run_on(&at(40, &[]), PathWish::Auto);
    let (list, b) = run_on(&at(40, &[]), PathWish::List);
    assert_eq!((&*lattice.path, &*list.path), ("lattice", "list"));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-10));
    // The diffusivity alone is the same scene; what is conserved is then another total.
    let alone = at(40, &[r#"materials={"gold":{"diffusivity":1.28e-4}}"#]);
    let (report, c) = run_on(&alone, PathWish::Auto);
    assert!(a.iter().zip(&c).all(|(a, c)| (a - c).abs() < 1e-10));
    let ratio = lattice.conserved.last / report.conserved.last;
    assert!((ratio / (19300.0 * 129.0) - 1.0).abs() < 1e-12, "{ratio}");
}

#[test]
fn the_square_has_the_known_errors() {
    let known = [(10, 5.0e-2), (20, 1.24e-2), (40, 3.1e-3), (80, 7.7e-4)];
    let tolerance = ["time.method=rkl2", "time.tolerance.relative=1e-7"];
    let mut errors = Vec::new();
    for (n, known) in known {
        let spacing = format!("particles.spacing=0.1/{n}");
        let keys: Vec<&str> = std::iter::once(&*spacing).chain(tolerance).collect();
        let error = l2(&run(&shipped("square", &keys)));
        assert!((error / known - 1.0).abs() < 0.05, "n = {n}: {error:e}");
        errors.push(error);
    }
    assert_order_two(&errors[1..]);
}

#[test]
fn the_rod_and_the_square_are_the_same_on_a_gpu() {
    let keys = [["particles.spacing=0.1/40"], ["particles.spacing=0.1/20"]];
    for (name, keys) in ["rod", "square"].into_iter().zip(keys) {
        let scene = shipped(name, &keys);
        let expected = l2(&run(&scene));
        for path in [PathWish::Lattice, PathWish::List] {
            for (precision, most) in [(Precision::F64, 1e-9), (Precision::Compensated, 1e-3)] {
                let machine = Machine::Gpu { device: support::device().clone(), precision };
                let options = RunOptions { path, ..RunOptions::new(&machine) };
                let outcome = study::run(&scene, &options, &mut |_| ControlFlow::Continue(()));
                let found = l2(&outcome.expect("it runs").report);
                let off = (found / expected - 1.0).abs();
                assert!(off < most, "{name}, {path:?}, {}: {off:e}", precision.name());
            }
        }
    }
}

#[test]
fn the_rod_and_the_square_have_the_published_values() {
    let value = |scene: &Scene, x: [f64; 2], t: f64| {
        let at = glam::DVec3::new(x[0], x[1], 0.0);
        scene.exact.as_ref().expect("a solution").at(at, t)
    };
    let rod = shipped("rod", &[]);
    for (x, expected) in [(0.01, 431.7062733), (0.02, 375.3518236), (0.05, 305.4250772)] {
        assert!((value(&rod, [x, 0.0], 2.0) - expected).abs() < 1e-7, "{x}");
    }
    let square = shipped("square", &[]);
    let centre = [
        (0.5, 299.98812),
        (1.0, 297.87013),
        (2.0, 268.33248),
        (3.0, 220.64659),
        (4.0, 174.95529),
        (5.0, 136.91202),
        (8.0, 64.41916),
        (10.0, 38.87166),
    ];
    for (t, expected) in centre {
        assert!((value(&square, [0.05; 2], t) - expected).abs() < 1e-5, "{t}");
    }
}

#[test]
fn the_square_is_second_order() {
    let error = |n: u32| {
        let spacing = format!("particles.spacing=0.1/{n}");
        let keys = [&*spacing, "time.method=rkl2", "time.tolerance.relative=1e-7"];
        l2(&run(&shipped("square", &keys)))
    };
    assert_order_two(&[10, 20, 40, 80].map(error));
}

/// A line of three layers of these capacities between held ends.
fn layers(capacities: [f64; 3], conductivities: [f64; 3], time: Value) -> Value {
    let names = ["a", "b", "c"];
    let fill: Vec<Value> = (0..3)
        .map(|k| json!({
            "shape": { "box": { "min": [f64::from(k) / 3.0], "max": [f64::from(k + 1) / 3.0] } },
            "material": names[k as usize]
        }))
        .collect();
    let material = |k: usize| json!({ "conductivity": conductivities[k], "density": 1, "heat_capacity": capacities[k] });
    json!({
        "title": "layers",
        "dimension": 1,
        "particles": { "spacing": 1.0 / 30.0, "fill": fill },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "materials": { "a": material(0), "b": material(1), "c": material(2) },
        "initial": [{ "value": 0 }],
        "boundaries": [
            { "wall": { "faces": ["x_min"], "kind": { "value": 0 } } },
            { "wall": { "faces": ["x_max"], "kind": { "value": 1 } } }
        ],
        "time": time,
        "exact": { "name": "expression", "value": "x" }
    })
}

#[test]
fn capacities_do_not_bend_a_steady_profile() {
    let linf = |case: &Value| {
        let scene = load(case).expect("a case");
        run(&scene).error.expect("an exact solution").linf
    };
    let steady = json!({ "end": 1, "method": "steady" });
    assert!(linf(&layers([1.0, 10.0, 1.0], [1.0; 3], steady.clone())) < 1e-8);
    let long = json!({ "end": 200, "method": "tr_bdf2", "step": 5, "linear_tolerance": 1e-11 });
    assert!(linf(&layers([1.0, 10.0, 1.0], [1.0; 3], long)) < 1e-8);
    // Were the pair formed from k / (rho c), the middle layer would conduct ten times less.
    assert!(linf(&layers([1.0; 3], [1.0, 0.1, 1.0], steady)) > 0.1);
}

#[test]
fn different_capacities_conserve_energy_with_every_method() {
    for method in ["euler", "heun", "rkl2", "tr_bdf2"] {
        let mut case =
            layers([1.0, 10.0, 3.0], [1.0, 0.2, 5.0], json!({ "end": 0.05, "method": method }));
        case["initial"] = json!([{ "value": "1 + sin(9*x)" }]);
        case["sources"] = json!([{ "rate": "3*x*sin(40*t)", "linear": -0.7 }]);
        for path in [PathWish::Auto, PathWish::List] {
            let (report, _) = run_on(&load(&case).expect("a case"), path);
            let drift = report.conserved.relative_drift.abs();
            assert!(drift < 1e-12, "{method} {path:?}: {drift:e}");
        }
    }
}

#[test]
fn bodies_in_contact_take_the_mean_by_effusivity() {
    for ratio in [10.0, 100.0, 1000.0] {
        // Both bodies span many spacings: the slow one's layer is sqrt(4 D t) = 20 of them.
        let case = json!({
            "title": "contact",
            "dimension": 1,
            "particles": { "spacing": 0.005, "fill": [
                { "shape": { "box": { "min": [-4], "max": [0] } }, "material": "fast" },
                { "shape": { "box": { "min": [0], "max": [1] } }, "material": "slow" }
            ] },
            "kernel": { "name": "cubic_spline", "support_ratio": 2 },
            "materials": {
                "fast": { "conductivity": ratio, "density": 1, "heat_capacity": ratio },
                "slow": { "conductivity": 1, "density": 1, "heat_capacity": 1 }
            },
            "initial": [{ "value": 1 }, { "value": 0, "where": { "box": { "min": [0], "max": [1] } } }],
            "boundaries": [{ "wall": { "faces": ["x_min", "x_max"], "kind": "insulated" } }],
            "time": { "end": 0.0025, "method": "rkl2", "tolerance": { "relative": 1e-6 } },
            "exact": {
                "name": "contact", "axis": "x", "at": 0,
                "below": { "material": "fast", "initial": 1 },
                "above": { "material": "slow", "initial": 0 }
            }
        });
        let (report, state) = run_on(&load(&case).expect("a case"), PathWish::Auto);
        // The plane lies half way between two particles; their heat flows meet there.
        let [fast, slow] = [state[799], state[800]];
        let plane = (ratio * fast + slow) / (ratio + 1.0);
        let expected = ratio / (ratio + 1.0);
        assert!((plane - expected).abs() < 1e-3, "{ratio}: {plane} {expected}");
        let linf = report.error.expect("an exact solution").linf;
        assert!(linf < 2e-3, "{ratio}: {linf:e}");
    }
}

#[test]
fn amounts_and_fluxes_are_energies() {
    // 6 J into 2 kg of 3 J/(kg K), by deposit and by flux.
    let case = |initial: Value, boundaries: Value| {
        let case = json!({
            "title": "energy",
            "dimension": 1,
            "particles": { "spacing": 0.1, "fill": [
                { "shape": { "box": { "min": [0], "max": [1] } }, "material": "m" }
            ] },
            "kernel": { "name": "cubic_spline", "support_ratio": 2 },
            "materials": { "m": { "conductivity": 5, "density": 2, "heat_capacity": 3 } },
            "initial": initial,
            "boundaries": boundaries,
            "time": { "end": 2 }
        });
        run(&load(&case).expect("a case"))
    };
    let walls = |left: Value| {
        json!([
            { "wall": { "faces": ["x_min"], "kind": left } },
            { "wall": { "faces": ["x_max"], "kind": "insulated" } }
        ])
    };
    let deposit = case(json!([{ "amount": 6, "at": [0.5] }]), walls(json!("insulated")));
    let flux = case(json!([]), walls(json!({ "flux": 3 })));
    for report in [&deposit, &flux] {
        assert!((report.field.mean - 1.0).abs() < 1e-12, "{}", report.field.mean);
        assert!((report.conserved.last - 6.0).abs() < 1e-11);
    }
}

/// A plate with sources of power.
fn plate(sources: Value, boundaries: Value) -> Value {
    json!({
        "title": "plate",
        "dimension": 2,
        "particles": { "spacing": 0.05, "fill": [
            { "shape": { "box": { "min": [0, 0], "max": [1, 0.6] } }, "material": "m" }
        ] },
        "kernel": { "name": "wendland_c2", "support_ratio": 3 },
        "materials": { "m": { "conductivity": 2, "density": 4, "heat_capacity": 5 } },
        "initial": [],
        "boundaries": boundaries,
        "sources": sources,
        "time": { "end": 0.5 }
    })
}

#[test]
fn what_a_point_gives_is_its_power_also_beside_walls_and_on_its_way() {
    let all =
        json!([{ "wall": { "faces": ["x_min", "x_max", "y_min", "y_max"], "kind": "insulated" } }]);
    let inflow = |problem: &Problem, t: f64| {
        let rate = CpuBackend::of(problem).rate(t).expect("rate");
        let capacities = problem.capacities();
        rate.as_ref().iter().zip(&capacities).map(|(r, c)| r * c).sum::<f64>()
    };
    let places =
        [json!([0.5, 0.3]), json!([0.5123, 0.311]), json!([0.0, 0.0]), json!([0.97, 0.01])];
    for place in places {
        let scene = load(&plate(json!([{ "power": "7*(1 + t)", "at": place }]), all.clone()));
        let found = inflow(&scene.expect("a case").problem, 0.5);
        assert!((found / 10.5 - 1.0).abs() < 1e-13, "{place}: {found}");
    }
    let moving = json!([{
        "power": 3, "path": [[0.1, 0.1], [0.9, 0.1], [0.9, 0.5]], "speed": 4, "start": 0.1
    }]);
    let scene = load(&plate(moving, all.clone())).expect("a case");
    for (t, expected) in [(0.05, 0.0), (0.1, 3.0), (0.2345, 3.0), (0.35, 3.0), (0.41, 0.0)] {
        let found = inflow(&scene.problem, t);
        assert!((found - expected).abs() < 1e-12, "{t}: {found}");
    }
    // It begins and ends at steps, so that what has entered is the power times its duration.
    let report = run(&scene);
    assert!((report.conserved.boundary_exchange - 0.9).abs() < 2e-3, "{:?}", report.conserved);
    let mut case = plate(json!([]), all);
    case["sources"] = json!([{ "power": 3, "path": [[0.1, 0.1], [0.9, 0.1]], "speed": 4 }]);
    case["time"]["method"] = json!("rkl2");
    let report = run(&load(&case).expect("a case"));
    assert!((report.conserved.boundary_exchange - 0.6).abs() < 1e-3, "{:?}", report.conserved);
    assert!(report.conserved.relative_drift.abs() < 1e-12);
}

#[test]
fn a_continuous_line_source_approaches_its_solution() {
    // T(r) - T(R) = Q / (2 pi k) ln(R / r) in the long run, between the held rim and the spread.
    let case = json!({
        "title": "line source",
        "dimension": 2,
        "particles": { "spacing": 0.02, "fill": [
            { "shape": { "box": { "min": [-1, -1], "max": [1, 1] } }, "material": "m" }
        ] },
        "kernel": { "name": "cubic_spline", "support_ratio": 2 },
        "materials": { "m": { "conductivity": 2, "density": 1, "heat_capacity": 1 } },
        "initial": [],
        "boundaries": [{ "wall": { "faces": ["x_min", "x_max", "y_min", "y_max"],
            "kind": { "value": "-5/(2*pi*2)*ln(sqrt(x^2 + y^2))" } } }],
        "sources": [{ "power": 5, "at": [0, 0] }],
        "time": { "end": 1, "method": "steady" },
        "probes": [{ "name": "half", "at": [0.51, 0.01] }, { "name": "tenth", "at": [0.11, 0.01] }]
    });
    let report = run(&load(&case).expect("a case"));
    for probe in &report.probes {
        let r = f64::hypot(probe.at[0], probe.at[1]);
        let expected = -5.0 / (2.0 * std::f64::consts::PI * 2.0) * r.ln();
        assert!((probe.value / expected - 1.0).abs() < 3e-3, "{r}: {} {expected}", probe.value);
    }
}

#[test]
fn bad_materials_and_powers_are_refused_by_their_path() {
    let with = |material: Value, sources: Value| {
        let mut case = plate(sources, json!([]));
        case["materials"]["m"] = material;
        load(&case).expect_err("a bad case")
    };
    let heat = json!({ "conductivity": 2, "density": 4, "heat_capacity": 5 });
    let faults = [
        (
            json!({ "diffusivity": 1, "conductivity": 2 }),
            "materials.m.conductivity: not used: the material has a diffusivity",
        ),
        (json!({ "diffusivity": 1, "heat_capacity": 2 }), "materials.m.heat_capacity: not used"),
        (json!({ "conductivity": 1, "density": 2 }), "materials.m.heat_capacity: missing key"),
        (json!({ "conductivity": 1, "heat_capacity": 2 }), "materials.m.density: missing key"),
        (json!({ "density": 2 }), "materials.m.diffusivity: missing key"),
        (
            json!({ "conductivity": 0, "density": 2, "heat_capacity": 1 }),
            "materials.m.conductivity: is 0",
        ),
    ];
    for (material, message) in faults {
        let found = with(material.clone(), json!([]));
        assert!(found.starts_with(message), "{material}: {found}");
    }
    let powers = [
        (json!({ "power": 1, "at": [3, 3] }), "sources[0].at: no particle within the support"),
        (
            json!({ "power": 1, "path": [[3, 3], [4, 4]], "speed": 1 }),
            "sources[0].path: no particle",
        ),
        (json!({ "power": 1 }), "sources[0].at: missing key"),
        (json!({ "power": 1, "path": [[0, 0], [1, 0]] }), "sources[0].speed: missing key"),
        (
            json!({ "power": 1, "path": [[0, 0]], "speed": 1 }),
            "sources[0].path: is 1, must be at least two points",
        ),
        (json!({ "power": 1, "at": [0.5, 0.3], "rate": 2 }), "sources[0].rate: not used"),
        (json!({ "power": 1, "at": [0.5, 0.3], "speed": 2 }), "sources[0].speed: not used"),
        (json!({ "rate": 1, "at": [0.5, 0.3] }), "sources[0].at: not used: it belongs to a power"),
    ];
    for (source, message) in powers {
        let found = with(heat.clone(), json!([source]));
        assert!(found.starts_with(message), "{source}: {found}");
    }
}

#[test]
fn explicit_steps_are_bounded_by_the_least_capacity() {
    let even = load(&layers([1.0; 3], [1.0; 3], json!({ "end": 1 }))).expect("a case").problem;
    let light =
        load(&layers([1.0, 0.01, 1.0], [1.0; 3], json!({ "end": 1 }))).expect("a case").problem;
    let bound = |problem: &Problem| survey(problem, &cell_grid(problem)).rate_bound;
    // Next to the walls, a mirrored value adds half as much again in the even case.
    let ratio = bound(&light) / bound(&even);
    assert!(ratio > 50.0 && ratio <= 100.0, "{ratio}");
}

/// Three layers with a resistance between the first two, the middle one two spacings thin.
fn layers_in_contact(support_ratio: f64, contacts: bool) -> Value {
    let bar = |from: f64, to: f64, material: &str| json!({ "shape": { "box": { "min": [from], "max": [to] } }, "material": material });
    let material = |conductivity: f64| json!({ "conductivity": conductivity, "density": 1000, "heat_capacity": 1 });
    let mut case = json!({
        "title": "layers", "dimension": 1,
        "particles": { "spacing": 0.025,
            "fill": [bar(0.0, 0.4, "one"), bar(0.4, 0.45, "two"), bar(0.45, 1.0, "three")] },
        "kernel": { "name": "cubic_spline", "support_ratio": support_ratio },
        "materials": { "one": material(1.0), "two": material(0.02), "three": material(10.0) },
        "initial": [{ "value": 300 }],
        "boundaries": [
            { "wall": { "faces": ["x_min"], "kind": { "value": 400 } } },
            { "wall": { "faces": ["x_max"], "kind": { "value": 300 } } }
        ],
        "time": { "end": 1, "method": "steady", "linear_tolerance": 1e-12 },
        "exact": { "name": "layers", "axis": "x", "layers": [
            { "material": "one", "to": 0.4 },
            { "material": "two", "to": 0.45 },
            { "material": "three" }
        ] }
    });
    if contacts {
        case["contacts"] = json!([{ "between": ["two", "one"], "resistance": 0.7 }]);
        case["exact"]["layers"][0]["resistance"] = json!(0.7);
    }
    case
}

#[test]
fn steady_layers_are_exact_for_every_support_and_with_contacts() {
    for (support_ratio, contacts) in [(2.0, false), (2.0, true), (3.5, false), (3.5, true)] {
        let scene = load(&layers_in_contact(support_ratio, contacts))
            .unwrap_or_else(|error| panic!("{error}"));
        for path in [PathWish::Lattice, PathWish::List] {
            let (report, _) = run_on(&scene, path);
            let error = report.error.expect("layers").linf;
            assert!(error < 1e-8, "{support_ratio}, {contacts}, {path:?}: {error:e}");
        }
    }
    // Beside an insulated wall along the layers the contact goes on.
    let mut sheet = layers_in_contact(2.0, true);
    sheet["dimension"] = json!(2);
    for fill in sheet["particles"]["fill"].as_array_mut().expect("fills") {
        let bar = &mut fill["shape"]["box"];
        bar["min"].as_array_mut().expect("a point").push(json!(0));
        bar["max"].as_array_mut().expect("a point").push(json!(0.2));
    }
    let insulated = json!({ "wall": { "faces": ["y_min", "y_max"], "kind": "insulated" } });
    sheet["boundaries"].as_array_mut().expect("walls").push(insulated);
    let error = run(&load(&sheet).expect("a case")).error.expect("layers").linf;
    assert!(error < 1e-7, "{error:e}");
    // Off the lattice nobody knows where the layers meet: half way is wrong for wide supports.
    let mut scene = load(&layers_in_contact(3.5, false)).expect("a case");
    scene.problem.particles.position[3].x += 1e-3;
    assert!(run(&scene).error.expect("layers").linf > 1.0);
}
