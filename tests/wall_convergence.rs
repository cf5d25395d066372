//! Walls against exact solutions: steady profiles to round-off, transients at second order.

use diffusph::case::{self, Scene};
use diffusph::exact::{Side, Slab, SlabSetup, Solution};
use diffusph::model::interpolation::Interpolation;
use diffusph::model::operator::rows::{Rows, assemble, cell_grid};
use diffusph::model::{KernelKind, Problem};
use diffusph::report::Norms;
use diffusph::solver::Backend;
use diffusph::solver::cpu::CpuBackend;
use glam::DVec3;
use serde_json::{Value, json};

/// Particles of the bars: four octaves.
const COUNTS: [usize; 4] = [40, 80, 160, 320];

/// A bar of `n` particles between 0 and `length` with these kinds of walls at its ends.
struct Bar {
    n: usize,
    length: f64,
    kernel: KernelKind,
    support_ratio: f64,
    diffusivity: f64,
    initial: f64,
    left: Value,
    right: Value,
}

impl Bar {
    /// The bar of unit length, diffusivity and flux, whose right end is held at 0.
    fn unit(n: usize, kernel: KernelKind, support_ratio: f64) -> Self {
        let (left, right) = (json!({ "flux": 1 }), json!({ "value": 0 }));
        let (length, diffusivity, initial) = (1.0, 1.0, 0.0);
        Self { n, length, kernel, support_ratio, diffusivity, initial, left, right }
    }

    fn scene(&self) -> Scene {
        let wall = |face: &str, kind: &Value| json!({ "wall": { "faces": [face], "kind": kind } });
        let shape = json!({ "box": { "min": [0], "max": [self.length] } });
        let case = json!({
            "title": "bar",
            "dimension": 1,
            "particles": {
                "spacing": self.length / self.n as f64,
                "fill": [{ "shape": shape, "material": "bar" }]
            },
            "kernel": { "name": self.kernel.name(), "support_ratio": self.support_ratio },
            "materials": { "bar": { "diffusivity": self.diffusivity } },
            "initial": [{ "value": self.initial }],
            "boundaries": [wall("x_min", &self.left), wall("x_max", &self.right)],
            "time": { "end": 1 }
        });
        case::from_json("bar", case, &[]).unwrap_or_else(|error| panic!("{error}"))
    }

    fn problem(&self) -> Problem {
        self.scene().problem
    }
}

/// A scene as a matrix.
struct Assembled {
    order: Vec<u32>,
    rows: Rows,
    rate_bound: f64,
}

impl Assembled {
    fn new(problem: &Problem) -> Self {
        let grid = cell_grid(problem);
        let (survey, rows) = assemble(problem, &grid);
        Self { order: grid.into_order(), rows, rate_bound: survey.rate_bound }
    }

    fn rate(&self, state: &[f64], t: f64) -> Vec<f64> {
        let mut source = Vec::new();
        self.rows.sources().source_at(t, &mut source);
        let mut rate = vec![0.0; state.len()];
        self.rows.apply(state, &source, &mut rate, |_, rate| rate);
        rate
    }

    fn in_problem_order(&self, state: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; state.len()];
        for (&particle, value) in self.order.iter().zip(state) {
            out[particle as usize] = *value;
        }
        out
    }
}

/// The values at time `end`, exact in time: the classic Runge-Kutta method of fourth order with
/// steps below the stability limit, whose error is far below that of the space.
fn solved(problem: &Problem, end: f64) -> Vec<f64> {
    let assembled = Assembled::new(problem);
    let steps = (end * assembled.rate_bound / 0.6).ceil();
    let dt = end / steps;
    let mut state: Vec<f64> =
        assembled.order.iter().map(|&p| problem.initial[p as usize]).collect();
    let moved = |state: &[f64], rate: &[f64], dt: f64| -> Vec<f64> {
        state.iter().zip(rate).map(|(c, r)| c + dt * r).collect()
    };
    for step in 0..steps as u64 {
        let t = step as f64 * dt;
        let k1 = assembled.rate(&state, t);
        let k2 = assembled.rate(&moved(&state, &k1, 0.5 * dt), t + 0.5 * dt);
        let k3 = assembled.rate(&moved(&state, &k2, 0.5 * dt), t + 0.5 * dt);
        let k4 = assembled.rate(&moved(&state, &k3, dt), t + dt);
        for (i, value) in state.iter_mut().enumerate() {
            *value += dt / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    assembled.in_problem_order(&state)
}

/// The order seen between each count and the next.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).abs().log2()).collect()
}

fn norms(problem: &Problem, state: &[f64], exact: &Solution, t: f64) -> Norms {
    let expected = exact.evaluate(&problem.particles.position, t);
    Norms::new(state, &expected, &problem.particles.volume)
}

/// Solves matrix x = right by Gaussian elimination with pivoting.
fn gauss(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| matrix[a][k].abs().total_cmp(&matrix[b][k].abs()));
        let pivot = pivot.expect("k < n");
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        let (upper, lower) = matrix.split_at_mut(k + 1);
        for (row, value) in lower.iter_mut().zip(k + 1..n) {
            let factor = row[k] / upper[k][k];
            row.iter_mut().zip(&upper[k]).for_each(|(x, p)| *x -= factor * p);
            right[value] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}

/// The steady state, by a direct solution.
fn steady(problem: &Problem) -> Vec<f64> {
    let assembled = Assembled::new(problem);
    let n = problem.particles.len();
    let zero = assembled.rate(&vec![0.0; n], 0.0);
    let mut matrix = vec![vec![0.0; n]; n];
    for b in 0..n {
        let mut unit = vec![0.0; n];
        unit[b] = 1.0;
        for (a, rate) in assembled.rate(&unit, 0.0).into_iter().enumerate() {
            matrix[a][b] = rate - zero[a];
        }
    }
    let solution = gauss(matrix, zero.iter().map(|r| -r).collect());
    assembled.in_problem_order(&solution)
}

#[test]
fn steady_flux_and_convection_are_exact_for_every_kernel_and_support() {
    let flux = (json!({ "flux": 1.5 }), 1.5);
    // 4 (ambient - C(0)) = 1.5 with C(0) = 0.5 + 1.5 / 2.
    let convection = (json!({ "convection": { "coefficient": 4, "ambient": 1.625 } }), 1.5);
    for (left, q) in [flux, convection] {
        for kernel in KernelKind::ALL {
            for support_ratio in [1.5, 2.0, 2.6, 3.0, 4.0] {
                let right = json!({ "value": 0.5 });
                let diffusivity = 2.0;
                let bar = Bar::unit(20, kernel, support_ratio);
                let problem = Bar { left: left.clone(), right, diffusivity, ..bar }.problem();
                let exact = |x: f64| 0.5 + q / 2.0 * (1.0 - x);
                let pairs = steady(&problem).into_iter().zip(&problem.particles.position);
                let worst = pairs.map(|(c, x)| (c - exact(x.x)).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-11, "{kernel:?} {support_ratio}: {worst:e}");
            }
        }
    }
}

/// The errors of the first particle, of the field (rms) and of the wall, all over the wall's value,
/// at t = 0.01.
fn transient_flux(n: usize, kernel: KernelKind, support_ratio: f64) -> [f64; 3] {
    let end = 0.01;
    let problem = Bar::unit(n, kernel, support_ratio).problem();
    let exact = Solution::Slab(Slab::new(SlabSetup {
        axis: 0,
        from: 0.0,
        to: 1.0,
        left: Side::Flux(1.0),
        right: Side::Value(0.0),
        initial: 0.0,
        diffusivity: 1.0,
    }));
    let state = solved(&problem, end);
    let at_wall = exact.at(DVec3::ZERO, end);
    let first = state[0] - exact.at(problem.particles.position[0], end);
    let probe = Interpolation::at(&problem, DVec3::ZERO).expect("particles").of(&state, end);
    let field = norms(&problem, &state, &exact, end).root_mean_square;
    [first / at_wall, field / at_wall, probe / at_wall - 1.0]
}

#[test]
fn transient_flux_is_second_order() {
    let table = |kernel, support_ratio| COUNTS.map(|n| transient_flux(n, kernel, support_ratio));
    let column = |table: &[[f64; 3]; 4], k: usize| table.map(|row| row[k]);
    // Figures of an independent computation: ghosts one by one in a dense matrix, and the matrix
    // exponential in time.
    let c4 = table(KernelKind::WendlandC4, 3.0);
    let c2 = table(KernelKind::WendlandC2, 4.0);
    let cubic = table(KernelKind::CubicSpline, 2.0);
    let near = |found: f64, expected: f64, within: f64| (found / expected - 1.0).abs() < within;
    assert!(near(c4[0][0], -6.44644e-4, 1e-4) && near(c4[3][0], -1.03011e-5, 1e-4), "{c4:?}");
    assert!(near(c2[0][0], -3.22584e-3, 1e-4) && near(c2[3][0], -5.02662e-5, 1e-4), "{c2:?}");
    assert!(near(cubic[0][1], 4.0e-4, 0.02) && near(cubic[3][1], 6.2e-6, 0.02), "{cubic:?}");
    assert!(near(cubic[0][2], 3.9e-3, 0.02), "{cubic:?}");
    for (name, errors) in [
        ("C4, first particle", column(&c4, 0)),
        ("C2, first particle", column(&c2, 0)),
        ("cubic, field", column(&cubic, 1)),
        ("cubic, wall", column(&cubic, 2)),
    ] {
        let found = orders(&errors);
        assert!((found[2] - 2.0).abs() < 0.1, "{name}: {found:?}");
    }
}

/// The poster's rod: 300, its left end at 500 from t = 0, its right end at 300.
fn rod(n: usize) -> (Problem, Solution) {
    let (left, right, initial) = (json!({ "value": 500 }), json!({ "value": 300 }), 300.0);
    let (length, diffusivity) = (0.1, 1.28e-4);
    let bar = Bar::unit(n, KernelKind::CubicSpline, 2.0);
    let exact = Slab::new(SlabSetup {
        axis: 0,
        from: 0.0,
        to: length,
        left: Side::Value(500.0),
        right: Side::Value(300.0),
        initial,
        diffusivity,
    });
    (Bar { left, right, initial, length, diffusivity, ..bar }.problem(), Solution::Slab(exact))
}

#[test]
fn the_rod_with_mirrors_converges_with_slope_two() {
    let end = 2.0;
    let errors = COUNTS.map(|n| {
        let (problem, exact) = rod(n);
        norms(&problem, &solved(&problem, end), &exact, end).l2_relative
    });
    let slope = (errors[0] / errors[3]).log2() / 3.0;
    assert!((slope - 2.0).abs() < 0.05, "{slope}");
    assert!((errors[3] / 3.28e-6 - 1.0).abs() < 0.01, "{errors:?}");
    // Explicit Euler at 0.2 dx^2 / alpha cancels part of the error.
    let (problem, exact) = rod(320);
    let dt = 0.2 * problem.spacing.powi(2) / 1.28e-4;
    let steps = (end / dt).ceil();
    let mut backend = CpuBackend::of(&problem);
    backend.euler(0.0, end / steps, steps as u64).expect("steps");
    let state = backend.read().expect("read");
    let euler = norms(&problem, state.as_ref(), &exact, end).l2_relative;
    assert!((euler / 8.75e-7 - 1.0).abs() < 0.01, "{euler:e}");
}

#[test]
fn transient_convection_and_a_swinging_wall_are_second_order() {
    let convection = json!({ "convection": { "coefficient": 3, "ambient": 2 } });
    let setup = SlabSetup {
        axis: 0,
        from: 0.0,
        to: 1.0,
        left: Side::Convection { coefficient: 3.0, ambient: 2.0 },
        right: Side::Value(0.0),
        initial: 0.0,
        diffusivity: 1.0,
    };
    let convective = Solution::Slab(Slab::new(setup));
    let swinging = Solution::OscillatingSlab(diffusph::exact::OscillatingSlab::new(
        diffusph::exact::OscillatingSlabSetup {
            axis: 0,
            from: 0.0,
            to: 1.0,
            mean: 0.0,
            amplitude: 1.0,
            angular_frequency: 40.0,
            right: 0.0,
            initial: 0.0,
            diffusivity: 1.0,
        },
    ));
    let swing = json!({ "value": "sin(40*t)" });
    for (left, exact) in [(convection, convective), (swing, swinging)] {
        for (kernel, support_ratio) in [
            (KernelKind::CubicSpline, 2.0),
            (KernelKind::WendlandC4, 3.0),
            (KernelKind::WendlandC2, 4.0),
        ] {
            let errors = COUNTS.map(|n| {
                let bar = Bar { left: left.clone(), ..Bar::unit(n, kernel, support_ratio) };
                let problem = bar.problem();
                norms(&problem, &solved(&problem, 0.1), &exact, 0.1).l2
            });
            let found = orders(&errors);
            assert!((found[2] - 2.0).abs() < 0.1, "{} {kernel:?}: {found:?}", exact.name());
        }
    }
}

#[test]
fn a_wall_one_particle_off_is_first_order() {
    // The negative control of the orders above: the left end imposes its value half a spacing
    // further out, as a layer of held particles would.
    let end = 2.0;
    let errors = COUNTS.map(|n| {
        let (mut problem, exact) = rod(n);
        problem.domain.min.x -= 0.5 * problem.spacing;
        norms(&problem, &solved(&problem, end), &exact, end).l2_relative
    });
    let found = orders(&errors);
    assert!(found[2] < 1.2, "{found:?}");
}

#[test]
fn an_insulated_box_keeps_its_total_over_many_steps() {
    let insulated = json!("insulated");
    let bar = Bar::unit(40, KernelKind::WendlandC4, 3.0);
    let mut problem = Bar { left: insulated.clone(), right: insulated, ..bar }.problem();
    for (value, x) in problem.initial.iter_mut().zip(&problem.particles.position) {
        *value = 1.0 + (9.0 * x.x).sin();
    }
    let total = |state: &[f64]| {
        state.iter().zip(&problem.particles.volume).map(|(c, v)| c * v).sum::<f64>()
    };
    let assembled = Assembled::new(&problem);
    let before = total(&problem.initial);
    let dt = 0.9 / assembled.rate_bound;
    let mut backend = CpuBackend::new(&problem, assembled.order, assembled.rows);
    backend.euler(0.0, dt, 100_000).expect("steps");
    let drift = total(backend.read().expect("read").as_ref()) / before - 1.0;
    assert!(drift.abs() < 1e-13, "{drift:e}");
    assert_eq!(backend.exchange().expect("exchange"), 0.0);
}
