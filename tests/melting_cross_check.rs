//! Three materials that meet, of which one has no curve and two melt: the GPU against the CPU in 1-D and 2-D,
//! and rates that are none where all is of one temperature.

#[expect(dead_code, reason = "these scenes are no shipped cases")]
#[path = "cases/support.rs"]
mod cases;
#[path = "melting/fields.rs"]
mod fields;
#[expect(dead_code, reason = "the tests of one material use the rest")]
#[path = "melting/support.rs"]
mod support;

use diffusph::case::Scene;
use diffusph::model::Problem;
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::{Backend, Machine, PathWish, Precision};
use serde_json::{Value, json};

use cases::load;
use fields::{furthest, temperatures};
use support::on_gpu;

/// About half of the longest step that explicit Euler may take in 1-D, and that in 2-D, s.
const STEP: f64 = 0.01;

/// The highest temperature, K.
const HOTTEST: f64 = 700.0;

/// Methods with the length of their steps over [`STEP`] and how many they take.
const METHODS: [(&str, f64, u32); 3] =
    [("euler", 1.0, 300), ("rkl2", 8.0, 40), ("tr_bdf2", 8.0, 40)];

/// Three bars in a row, some of the middle one held beside the first; `initial` in K.
fn bars(dimension: usize, initial: &str) -> Value {
    let of = |x: f64, y: f64| [x, y][..dimension].to_vec();
    let part = |from: f64, to: f64| json!({ "box": { "min": of(from, 0.0), "max": of(to, 0.08) } });
    let bar = |from, to, material: &str| json!({ "shape": part(from, to), "material": material });
    let mut boundaries = vec![
        json!({ "wall": { "faces": ["x_min"], "kind": { "value": HOTTEST } } }),
        json!({ "wall": { "faces": ["x_max"], "kind": { "flux": -1000 } } }),
        json!({ "held": { "where": part(0.3, 0.34), "value": 500 } }),
    ];
    if dimension == 2 {
        boundaries.push(json!({ "wall": { "faces": ["y_min"], "kind": "insulated" } }));
    }
    json!({
        "title": "three bars", "dimension": dimension,
        "particles": {
            "spacing": 0.02,
            "fill": [bar(0.0, 0.3, "plain"), bar(0.3, 0.6, "sharp"), bar(0.6, 1.0, "between")]
        },
        "kernel": { "name": "wendland_c2", "support_ratio": 2.6 },
        "materials": {
            "plain": { "conductivity": 5, "density": 1000, "heat_capacity": 1.5 },
            "sharp": {
                "conductivity": 10, "density": 1000, "heat_capacity": 1,
                "melting_temperature": 330, "latent_heat": 100, "liquid": { "conductivity": 4 }
            },
            "between": {
                "conductivity": [[100, 3], [400, 4]], "density": 1000, "heat_capacity": 2,
                "melting_temperature": [220, 260], "latent_heat": 50, "liquid": { "conductivity": 2 }
            }
        },
        "initial": [{ "value": initial }],
        "boundaries": boundaries,
        "time": { "end": STEP, "step": STEP, "method": "euler" }
    })
}

fn scene(case: &Value) -> Scene {
    load(case).unwrap_or_else(|error| panic!("{error}"))
}

/// The bars from hot to cold, where some of both melts, with steps of `share` [`STEP`].
fn melting(
    dimension: usize,
    (method, share, steps): (&str, f64, u32),
    precision: Precision,
) -> Scene {
    let mut case = bars(dimension, "600 - 500*x");
    let step = share * STEP;
    case["time"] = json!({ "end": step * f64::from(steps), "step": step, "method": method });
    // Iterations end where a residual is small: by default so early that paths of one machine are 6e-11 K apart.
    if method == "tr_bdf2" && precision == Precision::F64 {
        case["time"]["linear_tolerance"] = json!(1e-12);
    }
    scene(&case)
}

/// How far temperatures may be off the CPU's (K), and how far energy from closing: some hundred steps of 1e-16
/// of the hottest, and of the digits of f32 where differences have those.
fn allowed(precision: Precision) -> [f64; 2] {
    match precision {
        Precision::F64 => [1e-14 * HOTTEST, 1e-12],
        Precision::Compensated => [1e-6 * HOTTEST, 1e-6],
        Precision::F32 => [1e-5 * HOTTEST, 1e-5],
    }
}

fn agrees(dimension: usize, precisions: &[Precision]) {
    for method in METHODS {
        for &precision in precisions {
            let scene = melting(dimension, method, precision);
            let (cpu, on_cpu) = temperatures(&scene, &Machine::Cpu, PathWish::List);
            assert!(cpu.front.expect("it melts").liquid_volume > 1e-3, "{}", method.0);
            for (path, name) in [
                (PathWish::List, "list"),
                (PathWish::Lattice, "mixed"),
                (PathWish::MatrixFree, "matrix-free"),
            ] {
                let (report, here) = temperatures(&scene, &on_gpu(precision), path);
                assert_eq!((&*report.backend, &*report.path), ("gpu", name));
                let (off, drift) =
                    (furthest(&on_cpu, &here), report.conserved.relative_drift.abs());
                let what =
                    format!("{dimension}-D {} {} {}", method.0, path.name(), precision.name());
                let [most, kept] = allowed(precision);
                assert!(off < most && drift < kept, "{what}: {off:e} K, drift {drift:e}");
            }
        }
    }
}

#[test]
fn three_bars_in_a_row_agree_in_every_precision_on_every_path() {
    agrees(1, &Precision::ALL);
}

#[test]
fn three_bars_in_the_plane_agree() {
    agrees(2, &[Precision::F64]);
}

/// Rates of `problem` on the GPU, K/s.
fn rates_on_gpu(problem: &Problem, precision: Precision, matrix_free: bool) -> Vec<f64> {
    let Machine::Gpu { device, .. } = on_gpu(precision) else { unreachable!() };
    let options = GpuOptions { matrix_free, ..GpuOptions::new(precision) };
    let mut backend = GpuBackend::with_options(problem, STEP, &device, options).expect("backend");
    backend.rate(0.0).expect("rates").as_ref().to_vec()
}

/// The bars at 500 K all over, with nothing from outside.
fn at_one_temperature(dimension: usize) -> Problem {
    let mut case = bars(dimension, "500");
    case["boundaries"] = json!([case["boundaries"][2]]);
    scene(&case).problem
}

#[test]
fn what_is_of_one_temperature_exchanges_no_heat() {
    for dimension in [1, 2] {
        let problem = at_one_temperature(dimension);
        // Potentials differ by a hundred or more where materials meet, which seams take away: what is left is
        // rounding of terms that are each at most the hottest times the sum of the weights, about 1 a step.
        let bound = |precision| match precision {
            Precision::F64 => f64::EPSILON * HOTTEST / STEP,
            _ => f64::from(f32::EPSILON) * HOTTEST / STEP,
        };
        for precision in Precision::ALL {
            for matrix_free in [false, true] {
                let most = |problem: &Problem| {
                    let rates = rates_on_gpu(problem, precision, matrix_free);
                    rates.iter().fold(0.0, |m: f64, rate| m.max(rate.abs()))
                };
                let (rate, bound) = (most(&problem), bound(precision));
                assert!(rate < bound, "{dimension}-D {}: {rate:e} K/s", precision.name());
                // A curve that its neighbours' seams do not fit is noticed, and so is a warmer particle.
                let mut other = problem.clone();
                other.materials[1].curve = other.materials[2].curve.clone();
                assert!(most(&other) > 100.0 * bound);
                let mut warmer = problem.clone();
                warmer.initial[0] *= 1.01;
                assert!(most(&warmer) > 100.0 * bound);
            }
        }
    }
}

#[test]
fn held_particles_of_another_material_take_part() {
    let scene = melting(1, METHODS[0], Precision::F64);
    let mut free = scene.problem.clone();
    free.held.clear();
    let of = |problem: &Problem| {
        let on_cpu = CpuBackend::of(problem).rate(0.0).expect("rates").as_ref().to_vec();
        let here = rates_on_gpu(problem, Precision::F64, false);
        let largest = on_cpu.iter().fold(0.0, |m: f64, rate| m.max(rate.abs()));
        let off = furthest(&on_cpu, &here) / largest;
        assert!(off < 1e-12, "{off:e}");
        (here, largest)
    };
    let ((held, largest), (free, _)) = (of(&scene.problem), of(&free));
    assert!(scene.problem.held.iter().all(|&p| held[p as usize] == 0.0));
    assert!(furthest(&held, &free) > 1e-3 * largest, "what holds a particle is noticed");
}
