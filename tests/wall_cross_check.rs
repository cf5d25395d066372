//! Walls of every kind: the CPU path against the GPU, and the balance of both.

use diffusph::model::operator::rows::{cell_grid, survey, wall_fold};
use diffusph::model::{
    Condition, Face, KernelKind, Problem, Region, ScalarField, Source, Surface, Wall, WallKind,
};
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use diffusph::solver::{Backend, Precision};
use glam::DVec3;

use support::{brute_force, by_neighbors, device, epsilon, random_lattice};

#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

/// The step that weights on the device are relative to, s.
const STEP: f64 = 1e-3;
/// Steps of a run: more than the device holds changing sources for at once.
const STEPS: u64 = 150;

/// A condition of this kind whose numbers vary in space, and with `changing` in time, in the size
/// of [`random_lattice`]'s scenes.
fn condition(kind: WallKind, changing: bool) -> Condition {
    let varied = move |low: f64, high: f64| {
        let at = move |x: DVec3, t: f64| {
            let phase =
                1e6 * (x.x + 0.7 * x.y - 0.3 * x.z) + if changing { 400.0 * t } else { 0.0 };
            low + (high - low) * (0.5 + 0.5 * phase.sin())
        };
        ScalarField::new("varied", at).depending_on(true, changing)
    };
    let steady = ScalarField::new("steady", |x, _| 1e-6 * (1.0 + x.y / (x.y + 1e-6)));
    match kind {
        WallKind::Free => Condition::free(),
        WallKind::Insulated => Condition::insulated(),
        WallKind::Value => Condition::value(varied(300.0, 330.0)),
        WallKind::Flux => Condition::flux(varied(-1e-4, 2e-4)),
        WallKind::Convection => Condition::convection(steady, varied(280.0, 300.0)),
    }
}

fn wall(face: Face, condition: Condition) -> Wall {
    Wall { name: "wall".into(), face, covers: None, condition }
}

/// A disordered scene with walls of `kind` wherever it is not periodic, a patch of a second kind,
/// and some held particles.
fn walled(kernel: KernelKind, dimension: usize, kind: WallKind, changing: bool) -> Problem {
    let mut problem = random_lattice(kernel, dimension, [33, 9, 6][dimension - 1]);
    problem.domain.periodic[0] = dimension == 3;
    for axis in usize::from(dimension == 3)..dimension {
        for upper in [false, true] {
            problem.walls.push(wall(Face { axis, upper }, condition(kind, changing)));
        }
    }
    let middle = 0.5 * problem.domain.max[0];
    let covers = Some(Region::new(move |x| x.x > middle));
    let patch = wall(problem.walls[0].face, condition(WallKind::Insulated, false));
    problem.walls.push(Wall { covers, ..patch });
    problem.held = vec![0, 3, 11];
    problem
}

fn gpu(problem: &Problem, precision: Precision) -> GpuBackend {
    GpuBackend::new(problem, STEP, device(), precision).expect("backend")
}

/// What roundings allow each rate at time `t`: those of the pairs, and 32 for each number that the
/// walls add.
fn rate_tolerance(problem: &Problem, precision: Precision, t: f64) -> Vec<f64> {
    let both = f64::EPSILON + epsilon(precision);
    let mut allowed: Vec<f64> =
        brute_force(problem, both).into_iter().map(|(_, tolerance)| tolerance).collect();
    let largest = problem.initial.iter().fold(0.0, |s: f64, c| s.max(c.abs()));
    let grid = cell_grid(problem);
    let fold = wall_fold(problem, &grid);
    let mut add = |rank: u32, size: f64| {
        allowed[grid.order()[rank as usize] as usize] += 32.0 * both * size;
    };
    for &(row, _, weight) in &fold.weight {
        add(row, weight.abs() * largest);
    }
    let mut source = Vec::new();
    fold.rows.source_at(t, &mut source);
    for (k, &rank) in fold.rows.rank().iter().enumerate() {
        add(rank, fold.rows.diagonal()[k].abs() * largest + source[k].abs());
    }
    allowed
}

/// How many rates of the two scenes, one on the CPU and one on the GPU, by list and matrix-free, differ by
/// more than roundings explain.
fn rates_apart(on_cpu: &Problem, on_gpu: &Problem, precision: Precision, t: f64) -> [usize; 2] {
    let here = CpuBackend::of(on_cpu).rate(t).expect("rate");
    let allowed = rate_tolerance(on_cpu, precision, t);
    by_neighbors(on_gpu, STEP, precision).map(|(_, mut backend)| {
        let there = backend.rate(t).expect("rate");
        let pairs = here.as_ref().iter().zip(there.as_ref()).zip(&allowed);
        let agree = |((a, b), allowed): &((&f64, &f64), &f64)| (*a - *b).abs() <= **allowed;
        pairs.filter(|pair| !agree(pair)).count()
    })
}

#[test]
fn rates_agree_for_every_kind_dimension_kernel_and_precision() {
    for kind in WallKind::ALL {
        for kernel in KernelKind::ALL {
            for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
                for precision in Precision::ALL {
                    let problem = walled(kernel, dimension, kind, precision == Precision::F64);
                    let apart = rates_apart(&problem, &problem, precision, 0.013);
                    assert_eq!(apart, [0, 0], "{kind:?} {kernel:?} {dimension}-D {precision:?}");
                }
            }
        }
    }
}

/// The same with sources, one of them everywhere.
fn fed(kind: WallKind, dimension: usize, changing: bool) -> Problem {
    let mut problem = walled(KernelKind::CubicSpline, dimension, kind, changing);
    let count = problem.particles.len() as u32;
    let source = |particles, rate, linear| Source {
        name: "source".into(),
        particles,
        rate,
        linear: ScalarField::constant(linear),
    };
    let wave = ScalarField::new("wave", |x, t| 3e4 * (1e6 * x.x + 300.0 * t).sin());
    problem.sources = vec![
        source(None, wave.depending_on(true, changing), -40.0),
        source(Some((count / 3..count / 2).collect()), ScalarField::constant(0.0), 9.0),
    ];
    problem
}

#[test]
fn sources_agree_and_a_changed_one_is_noticed() {
    for dimension in 1..=3 {
        for precision in Precision::ALL {
            for kind in [WallKind::Free, WallKind::Value] {
                let problem = fed(kind, dimension, precision == Precision::F64);
                let apart = rates_apart(&problem, &problem, precision, 0.013);
                assert_eq!(apart, [0, 0], "{kind:?} {dimension}-D {precision:?}");
                let mut changed = problem.clone();
                changed.sources[1].linear = ScalarField::constant(9.1);
                let apart = rates_apart(&problem, &changed, precision, 0.013);
                assert!(
                    apart.iter().all(|&apart| apart > 0),
                    "{kind:?} {dimension}-D {precision:?}"
                );
            }
        }
    }
}

#[test]
fn a_changed_wall_is_noticed() {
    for precision in Precision::ALL {
        for kind in [WallKind::Value, WallKind::Flux, WallKind::Convection] {
            let problem = walled(KernelKind::WendlandC4, 2, kind, false);
            let mut changed = problem.clone();
            let condition = &mut changed.walls[1].condition;
            let imposed = condition.imposed.clone();
            condition.imposed = ScalarField::new("off", move |x, t| 1.01 * imposed.at(x, t))
                .depending_on(true, false);
            let apart = rates_apart(&problem, &changed, precision, 0.0);
            assert!(apart.iter().all(|&apart| apart > 0), "{kind:?} {precision:?}: {apart:?}");
        }
    }
}

/// The total of `state`, value x volume.
fn total(problem: &Problem, state: &[f64]) -> f64 {
    state.iter().zip(&problem.capacities()).map(|(c, v)| c * v).sum()
}

#[test]
fn fields_and_balances_agree_after_many_steps_that_change_in_time() {
    for kind in WallKind::ALL {
        for changing in [false, true] {
            let problem = fed(kind, 2, changing);
            let survey = survey(&problem, &cell_grid(&problem));
            let dt = 0.9 / survey.rate_bound;
            let mut here = CpuBackend::of(&problem);
            here.euler(0.0, dt, STEPS).expect("steps");
            let field = here.read().expect("read").as_ref().to_vec();
            let scale = 330.0 * problem.capacities().iter().sum::<f64>();
            let gained = total(&problem, &field) - total(&problem, &problem.initial);
            let given = here.exchange().expect("exchange");
            assert!((gained - given).abs() < 1e-13 * scale, "{kind:?}: {gained} {given}");
            for precision in Precision::ALL {
                // A step is a mean of old values: roundings add up and do not grow.
                let roundings = (64.0 + survey.most_neighbors as f64) * STEPS as f64;
                let allowed = roundings * epsilon(precision);
                for (path, mut there) in by_neighbors(&problem, dt, precision) {
                    there.euler(0.0, dt, STEPS).expect("steps");
                    let on_device = there.read().expect("read");
                    let apart = field.iter().zip(on_device.as_ref()).map(|(a, b)| (a - b).abs());
                    let apart = apart.fold(0.0, f64::max) / 330.0;
                    assert!(apart <= allowed, "{kind:?} {path} {precision:?}: {apart:e}");
                    let off = (there.exchange().expect("exchange") - given).abs() / scale;
                    assert!(off <= allowed, "{kind:?} {path} {precision:?}: exchange {off:e}");
                }
            }
        }
    }
}

#[test]
fn a_run_with_changing_walls_can_be_taken_back_and_split() {
    let problem = walled(KernelKind::CubicSpline, 2, WallKind::Value, true);
    let dt = 0.9 / survey(&problem, &cell_grid(&problem)).rate_bound;
    fn check<B: Backend>(mut whole: B, mut split: B, dt: f64) {
        whole.euler(0.0, dt, STEPS).expect("steps");
        split.euler(0.0, dt, 37).expect("steps");
        split.save().expect("save");
        split.euler(37.0 * dt, dt, 90).expect("steps");
        split.restore().expect("restore");
        split.euler(37.0 * dt, dt, STEPS - 37).expect("steps");
        let (a, b) = (whole.read().expect("read"), split.read().expect("read"));
        // The times of the steps are rounded differently.
        let apart = a.as_ref().iter().zip(b.as_ref()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-9);
        let (a, b) = (whole.exchange().expect("exchange"), split.exchange().expect("exchange"));
        assert!((a - b).abs() <= 1e-9 * a.abs());
    }
    check(CpuBackend::of(&problem), CpuBackend::of(&problem), dt);
    check(gpu(&problem, Precision::F64), gpu(&problem, Precision::F64), dt);
}

#[test]
fn chunks_of_the_list_make_no_difference() {
    let problem = walled(KernelKind::WendlandC2, 3, WallKind::Convection, true);
    let whole = GpuOptions::new(Precision::F32);
    let split = GpuOptions { chunk_bytes: Some(32 * 60 * 4), ..whole };
    let after = |options| {
        let mut backend =
            GpuBackend::with_options(&problem, STEP, device(), options).expect("backend");
        backend.euler(0.0, STEP, 70).expect("steps");
        (backend.chunk_count(), backend.read().expect("read"), backend.exchange().expect("read"))
    };
    let (one, several) = (after(whole), after(split));
    assert!(one.0 == 1 && several.0 > 3, "{} {}", one.0, several.0);
    assert_eq!((one.1, one.2), (several.1, several.2));
}

#[test]
fn surfaces_agree_and_close_the_balance() {
    for kind in [WallKind::Flux, WallKind::Convection] {
        let mut problem = random_lattice(KernelKind::CubicSpline, 2, 12);
        problem.domain.periodic = [false; 3];
        let center = 0.5 * problem.domain.max;
        let radius = 0.4 * problem.domain.max.x;
        let circle = move |x: DVec3| center + radius * (x - center).normalize_or(DVec3::X);
        let outside = move |x: DVec3| x.distance(center) > radius;
        let hole = Region::new(move |x| !outside(x));
        // A round hole: nothing is left of what is inside.
        let keep: Vec<usize> = (0..problem.particles.len())
            .filter(|&p| outside(problem.particles.position[p]))
            .collect();
        let particles = &mut problem.particles;
        particles.position = keep.iter().map(|&p| particles.position[p]).collect();
        particles.volume = keep.iter().map(|&p| particles.volume[p]).collect();
        particles.material = keep.iter().map(|&p| particles.material[p]).collect();
        problem.initial = keep.iter().map(|&p| problem.initial[p]).collect();
        problem.surfaces =
            vec![Surface::new("hole", hole.clone(), circle, None, condition(kind, true))];
        for precision in Precision::ALL {
            assert_eq!(rates_apart(&problem, &problem, precision, 0.02), [0, 0], "{kind:?}");
        }
        let mut here = CpuBackend::of(&problem);
        here.euler(0.0, STEP, STEPS).expect("steps");
        let field = here.read().expect("read");
        let gained = total(&problem, field.as_ref()) - total(&problem, &problem.initial);
        let scale = total(&problem, &vec![330.0; problem.particles.len()]);
        let given = here.exchange().expect("exchange");
        assert!((gained - given).abs() < 1e-13 * scale && gained.abs() > 1e-6 * scale);
    }
}
