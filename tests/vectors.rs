//! Operations on vectors: the GPU against the CPU, on every path and in every precision.

use diffusph::model::lattice::LatticeScene;
use diffusph::model::sum::CompensatedSum;
use diffusph::model::{Condition, Face, KernelKind, Problem, ScalarField, Wall, WallKind};
use diffusph::solver::cpu::CpuBackend;
use diffusph::solver::{Backend, Precision};

use agreement::{Path, SCRIPT, Script, apart, assert_agreement, gpu, readings, step};
use scenes::{COUNTS, boundaries};
use support::{Random, epsilon, random_lattice};

#[path = "vectors/agreement.rs"]
mod agreement;
#[expect(dead_code, reason = "the tests of the lattice use the rest")]
#[path = "lattice_path/scenes.rs"]
mod scenes;
#[expect(dead_code, reason = "the tests of the passes use the rest")]
#[path = "gpu_passes/support.rs"]
mod support;

/// A disordered scene of several materials and volumes, with walls of `kind`, and held particles.
fn disordered(kind: WallKind, dimension: usize) -> Problem {
    let mut problem = random_lattice(KernelKind::WendlandC2, dimension, [33, 9, 6][dimension - 1]);
    problem.domain.periodic = [dimension == 3, false, false];
    let varied = ScalarField::new("varied", |x, t| 300.0 + 20.0 * (1e6 * x.x + 400.0 * t).sin())
        .depending_on(true, true);
    let steady = ScalarField::new("steady", |x, _| 1e-6 * (1.0 + x.y / (x.y + 1e-6)));
    let condition = match kind {
        WallKind::Free => Condition::free(),
        WallKind::Insulated => Condition::insulated(),
        WallKind::Value => Condition::value(varied),
        WallKind::Flux => Condition::flux(ScalarField::new("steady", |x, _| 100.0 * x.x)),
        WallKind::Convection => Condition::convection(steady, varied),
    };
    for axis in usize::from(dimension == 3)..dimension {
        for upper in [false, true] {
            let condition = condition.clone();
            let face = Face { axis, upper };
            problem.walls.push(Wall { name: "wall".into(), face, covers: None, condition });
        }
    }
    problem.held = vec![0, 3, 11];
    problem
}

fn ordered(dimension: usize, boundary: usize) -> Problem {
    let boundary = boundaries(dimension).swap_remove(boundary);
    scenes::scene(KernelKind::CubicSpline, 2.0, COUNTS[dimension - 1], boundary).problem
}

#[test]
fn every_boundary_agrees_on_every_path() {
    for boundary in 0..boundaries(2).len() {
        let problem = ordered(2, boundary);
        for path in [Path::List, Path::MatrixFree, Path::Lattice, Path::SplitLattice] {
            for precision in Precision::ALL {
                assert_agreement(&problem, path, precision, &format!("{boundary}"));
            }
        }
    }
}

#[test]
fn every_dimension_agrees() {
    for dimension in [1, 3] {
        for boundary in [2, 8] {
            let problem = ordered(dimension, boundary);
            for path in [Path::List, Path::Lattice, Path::SplitLattice] {
                assert_agreement(
                    &problem,
                    path,
                    Precision::F64,
                    &format!("{dimension}-D {boundary}"),
                );
            }
        }
    }
    // Walls on a support of one spacing, and an order of particles that is not that of sites.
    let boundary = boundaries(2).swap_remove(7);
    let mut problem = scenes::scene(KernelKind::WendlandC2, 1.5, COUNTS[1], boundary).problem;
    problem.particles.position.reverse();
    problem.initial.reverse();
    assert!(LatticeScene::of(&problem).expect("a lattice").order.is_some());
    for precision in Precision::ALL {
        assert_agreement(&problem, Path::Lattice, precision, "reversed");
    }
}

#[test]
fn disordered_scenes_of_several_materials_agree() {
    for kind in WallKind::ALL {
        let problem = disordered(kind, 2);
        for precision in Precision::ALL {
            for path in [Path::List, Path::MatrixFree] {
                assert_agreement(&problem, path, precision, &format!("{kind:?}"));
            }
        }
        assert_agreement(&problem, Path::ChunkedList, Precision::F64, &format!("{kind:?}"));
    }
    assert_agreement(&disordered(WallKind::Convection, 3), Path::List, Precision::F64, "3-D");
}

#[test]
fn one_changed_number_is_noticed() {
    for (problem, path) in [Path::Lattice, Path::List, Path::MatrixFree].map(|path| match path {
        Path::Lattice => (ordered(2, 10), path),
        _ => (disordered(WallKind::Value, 2), path),
    }) {
        for precision in Precision::ALL {
            let here = readings(CpuBackend::of(&problem), &problem, SCRIPT);
            let there = |script| readings(gpu(&problem, path, precision), &problem, script);
            let changed = [
                ("source", Script { time: 0.33, ..SCRIPT }),
                ("applied", Script { share: 0.77, ..SCRIPT }),
                ("applied", Script { scale: -0.44, ..SCRIPT }),
                ("kept", Script { keep: 0.55, ..SCRIPT }),
                ("sum", Script { factor: 0.88, ..SCRIPT }),
                ("divided", Script { shift: 1.1, ..SCRIPT }),
                ("source", Script { later: 5.5, ..SCRIPT }),
                ("over aggregates", Script { factor: 0.88, ..SCRIPT }),
            ];
            for (name, script) in changed {
                let apart = apart(&here, &there(script), &problem, precision);
                let noticed = apart.iter().any(|message| message.starts_with(name));
                assert!(noticed, "{path:?} {precision:?} {name}: {apart:?}");
            }
        }
    }
}

#[test]
fn a_changed_scene_is_noticed_in_what_the_outside_gave() {
    let mut on_list = disordered(WallKind::Value, 2);
    on_list.held = (0..27).collect();
    for (problem, path) in [(ordered(2, 10), Path::Lattice), (on_list, Path::List)] {
        let here = readings(CpuBackend::of(&problem), &problem, SCRIPT);
        let mut fewer = problem.clone();
        fewer.held.truncate(problem.held.len() / 2);
        for precision in Precision::ALL {
            let there = readings(gpu(&fewer, path, precision), &fewer, SCRIPT);
            let found = apart(&here, &there, &problem, precision);
            for name in ["rate given", "applied given"] {
                let noticed = found.iter().any(|message| message.starts_with(name));
                assert!(noticed, "{path:?} {precision:?} {name}: {found:?}");
            }
        }
    }
}

/// Steps of Heun's method between steps of Euler's.
fn stepped<B: Backend>(mut backend: B, dt: f64) -> (Vec<f64>, f64) {
    let [mut rate, mut second] = [(); 2].map(|()| backend.vector().expect("vector"));
    let mut time = 0.0;
    for _ in 0..10 {
        backend.euler(time, dt, 3).expect("steps");
        time += 3.0 * dt;
        backend.save().expect("save");
        backend.rate_into(time, &mut rate).expect("rate");
        backend.update(&mut second, 0.0, &[(dt, &rate)]).expect("sum");
        backend.add(&second).expect("add");
        backend.rate_into(time + dt, &mut second).expect("rate");
        backend.restore().expect("restore");
        backend.update(&mut rate, 0.5 * dt, &[(0.5 * dt, &second)]).expect("sum");
        backend.add(&rate).expect("add");
        time += dt;
    }
    assert!(backend.is_finite().expect("check"));
    let field = backend.read().expect("read").as_ref().to_vec();
    (field, backend.exchange().expect("exchange"))
}

#[test]
fn sums_and_steps_take_turns() {
    for (problem, paths) in [
        (ordered(2, 10), vec![Path::Lattice, Path::SplitLattice]),
        (disordered(WallKind::Value, 2), vec![Path::List, Path::ChunkedList, Path::MatrixFree]),
    ] {
        let (dt, neighbors) = step(&problem);
        let (here, given) = stepped(CpuBackend::of(&problem), dt);
        let volume = &problem.capacities();
        let gained: f64 =
            here.iter().zip(&problem.initial).zip(volume).map(|((a, b), v)| v * (a - b)).sum();
        let total: f64 = 300.0 * volume.iter().sum::<f64>();
        assert!(
            (gained - given).abs() < 1e-13 * total && given.abs() > 1e-4 * total,
            "{gained} {given}"
        );
        for path in paths {
            for precision in Precision::ALL {
                let allowed = (64.0 + neighbors as f64) * 50.0 * epsilon(precision);
                let (there, on_device) = stepped(gpu(&problem, path, precision), dt);
                let off = here.iter().zip(&there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off <= 300.0 * allowed, "{path:?} {precision:?}: {off:e}");
                let off = (on_device - given).abs() / total;
                assert!(off <= allowed, "{path:?} {precision:?}: exchange {off:e}");
            }
        }
    }
}

#[test]
fn what_is_not_finite_is_seen_and_overwritten() {
    let problem = ordered(2, 3);
    for precision in Precision::ALL {
        let mut backend = gpu(&problem, Path::SplitLattice, precision);
        let [mut x, mut y] = [(); 2].map(|()| backend.vector().expect("vector"));
        let mut values = vec![1.0; problem.particles.len()];
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in [0, 70, 142] {
                values.fill(1.0);
                values[place] = bad;
                let is_free = !problem.held.contains(&(place as u32));
                backend.load(&values, &mut x).expect("load");
                assert_eq!(!backend.largest(&x).expect("largest").is_finite(), is_free);
                assert_eq!(!backend.dot(&x, &x).expect("dot").is_finite(), is_free);
            }
        }
        assert!(!backend.largest(&x).expect("largest").is_finite());
        values.fill(3.0);
        backend.load(&values, &mut y).expect("load");
        backend.update(&mut x, 0.0, &[(2.0, &y)]).expect("sum");
        assert_eq!(backend.largest(&x).expect("largest"), 6.0);
        assert!(backend.largest_value().expect("largest") < 311.0);
        values[142] = f64::NAN;
        backend.load(&values, &mut y).expect("load");
        backend.add(&y).expect("add");
        assert!(!backend.largest_value().expect("largest").is_finite());
        assert!(!backend.is_finite().expect("check"));
    }
}

#[test]
fn products_are_summed_well_and_stay_in_range() {
    let mut problem = random_lattice(KernelKind::CubicSpline, 2, 80);
    let count = problem.particles.len();
    assert!(count > 3 * 2048, "more than one workgroup makes a sum of");
    let mut random = Random(3);
    let mut numbers = || (0..count).map(|_| random.unit() - 0.4).collect::<Vec<f64>>();
    let (one, other) = (numbers(), numbers());
    for one_volume in [false, true] {
        if one_volume {
            problem.particles.volume.fill(3e-12);
        }
        for precision in Precision::ALL {
            let mut backend = gpu(&problem, Path::List, precision);
            let [mut x, mut y] = [(); 2].map(|()| backend.vector().expect("vector"));
            for size in [1.0, 1e-25, 1e25] {
                let scaled: Vec<f64> = one.iter().map(|value| size * value).collect();
                backend.load(&scaled, &mut x).expect("load");
                backend.load(&other, &mut y).expect("load");
                let sum = |y: &[f64], of: fn(f64) -> f64| {
                    let mut sum = CompensatedSum::default();
                    let capacities = problem.capacities();
                    let volumes = capacities.iter();
                    volumes.zip(&scaled).zip(y).for_each(|((v, x), y)| sum.add(of(v * x * y)));
                    sum.value()
                };
                let scale = sum(&other, f64::abs);
                let off = backend.dot(&x, &y).expect("dot") - sum(&other, |term| term);
                let allowed = 0.9 * epsilon(precision) * scale;
                assert!(off.abs() <= allowed, "{precision:?} {size:e}: {:e}", off / scale);
                let of_itself = backend.dot(&x, &x).expect("dot");
                let off = of_itself / sum(&scaled, |term| term) - 1.0;
                // The quotient is rounded as well.
                let allowed_of_itself = 2.0 * epsilon(precision);
                assert!(off.abs() < allowed_of_itself, "{precision:?} {size:e}: {off:e}");
                // One value more or less is far more than that.
                let part = problem.capacity(5000) * scaled[5000] * other[5000];
                assert!(part.abs() > 4e-6 * scale && part.abs() > allowed);
            }
        }
    }
}

#[test]
fn sums_keep_what_rounding_would_take() {
    let problem = ordered(2, 1);
    let grown = |precision| {
        let mut backend = gpu(&problem, Path::Lattice, precision);
        let mut x = backend.vector().expect("vector");
        let mut sum = backend.vector().expect("vector");
        backend.load(&vec![1e-9; problem.particles.len()], &mut x).expect("load");
        backend.load(&vec![1.0; problem.particles.len()], &mut sum).expect("load");
        for _ in 0..1000 {
            backend.add(&x).expect("add");
            backend.update(&mut sum, 1.0, &[(1.0, &x)]).expect("sum");
        }
        let state = backend.read().expect("read");
        let pairs = state.as_ref().iter().zip(&problem.initial);
        let worst = pairs.map(|(a, b)| (a - b - 1e-6).abs()).fold(0.0, f64::max);
        let mut one = backend.vector().expect("vector");
        backend.load(&vec![1.0; problem.particles.len()], &mut one).expect("load");
        backend.update(&mut sum, 1.0, &[(-1.0, &one)]).expect("sum");
        (worst, (backend.largest(&sum).expect("largest") - 1e-6).abs())
    };
    let (state, sum) = grown(Precision::F64);
    assert!(state < 1e-10 && sum < 1e-12, "{state:e} {sum:e}");
    let (state, sum) = grown(Precision::Compensated);
    assert!(state < 1e-9 && sum < 1e-12, "{state:e} {sum:e}");
    let (state, sum) = grown(Precision::F32);
    assert!(state > 5e-7 && sum > 5e-7, "{state:e} {sum:e}");
}

#[test]
fn a_sum_that_changes_nothing_is_seen() {
    let problem = ordered(2, 1);
    for (precision, least) in [(Precision::F32, 1e-4), (Precision::Compensated, 1e-11)] {
        let mut backend = gpu(&problem, Path::SplitLattice, precision);
        let mut x = backend.vector().expect("vector");
        for (size, is_still) in [(10.0 * least, false), (1e-2 * least, true), (0.0, true)] {
            let mut values = vec![0.0; problem.particles.len()];
            values[142] = size;
            backend.load(&values, &mut x).expect("load");
            backend.add(&x).expect("add");
            assert_eq!(backend.is_still().expect("check"), is_still, "{precision:?} {size:e}");
        }
    }
}

#[test]
fn a_run_without_vectors_holds_none() {
    for (problem, path) in
        [(ordered(2, 10), Path::Lattice), (disordered(WallKind::Value, 2), Path::List)]
    {
        let mut backend = gpu(&problem, path, Precision::F32);
        let (dt, _) = step(&problem);
        let before = backend.memory_bytes();
        backend.euler(0.0, dt, 5).expect("steps");
        backend.rate(0.0).expect("rate");
        assert_eq!(backend.memory_bytes(), before);
        let first = backend.vector().expect("vector");
        let with_one = backend.memory_bytes();
        let values = 4 * problem.particles.len() as u64;
        assert!(with_one >= before + values);
        let mut second = backend.vector().expect("vector");
        let with_two = backend.memory_bytes();
        assert!((values..values + 2000).contains(&(with_two - with_one)));
        backend.update(&mut second, 1.0, &[(1.0, &first)]).expect("sum");
        drop(first);
        drop(second);
        // What there was at most counts, and two new ones are no more than that.
        assert_eq!(backend.memory_bytes(), with_two);
        // Passes of vectors that are gone are not taken for those of new ones.
        let [mut x, mut y] = [(); 2].map(|()| backend.vector().expect("vector"));
        backend.load(&vec![2.0; problem.particles.len()], &mut x).expect("load");
        backend.update(&mut y, 1.0, &[(1.0, &x)]).expect("sum");
        assert_eq!(backend.largest(&y).expect("largest"), 2.0);
        assert_eq!(backend.memory_bytes(), with_two);
    }
}
