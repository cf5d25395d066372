//! The modes of a box lattice: waves that every stencil with mirrors or periodic ends only scales.
//!
//! With a mirror half a spacing behind its last particle, an axis of n particles has the cosines
//! cos(theta (j + 1/2)), theta = k pi / n (the type-2 cosine transform); a periodic one has
//! cos(theta j) + sin(theta j), theta = 2 k pi / n (the Hartley transform). A stencil scales their
//! product by its symbol, sum w (cos(theta_x i) cos(theta_y j) cos(theta_z k) - 1), the Laplacian by
//! -|theta|^2 / dx^2.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustdct::DctPlanner;
use rustdct::rustfft::FftPlanner;
use rustdct::rustfft::num_complex::Complex;

use crate::model::lattice::{Edge, LatticeScene, LineClass};

/// The modes of a lattice.
pub(super) struct Modes {
    counts: [usize; 3],
    periodic: [bool; 3],
}

/// A transform of one line.
type OfLine = Box<dyn Fn(&mut [f64]) + Sync>;

impl Modes {
    /// Those of a lattice whose open ends are mirrors.
    pub(super) fn of(lattice: &LatticeScene) -> Self {
        let periodic = [0, 1, 2].map(|axis| lattice.edges[axis] == Edge::Periodic);
        Self { counts: lattice.counts, periodic }
    }

    /// The amplitudes of a field by site.
    pub(super) fn amplitudes(&self, field: &[f64]) -> Vec<f64> {
        (0..3).fold(field.to_vec(), |values, axis| self.along(&values, axis, &self.forward(axis)))
    }

    /// The field by site with these amplitudes.
    pub(super) fn field(&self, amplitudes: &[f64]) -> Vec<f64> {
        (0..3).fold(amplitudes.to_vec(), |values, axis| {
            self.along(&values, axis, &self.backward(axis))
        })
    }

    /// The value with these amplitudes at a place, in spacings from the lower corner of the box.
    pub(super) fn at(&self, amplitudes: &[f64], place: [f64; 3]) -> f64 {
        let waves = [0, 1, 2].map(|axis| self.waves(axis, place[axis]));
        let [nx, ny, _] = self.counts;
        let line = |(line, amplitudes): (usize, &[f64])| {
            let sum: f64 = amplitudes.iter().zip(&waves[0]).map(|(a, wave)| a * wave).sum();
            sum * waves[1][line % ny] * waves[2][line / ny]
        };
        amplitudes.par_chunks(nx).enumerate().map(line).sum()
    }

    /// `amplitudes` after `time` (s), each with its rate (1/s).
    pub(super) fn after(&self, amplitudes: &[f64], rates: &[f64], time: f64) -> Vec<f64> {
        amplitudes.par_iter().zip(rates).map(|(a, rate)| a * (rate * time).exp()).collect()
    }

    /// Rates of the modes by a stencil of these lines, 1/s.
    pub(super) fn of_stencil(&self, classes: &[LineClass]) -> Vec<f64> {
        let entries: Vec<([usize; 3], f64)> = classes.iter().flat_map(entries).collect();
        let reach = entries.iter().flat_map(|(steps, _)| *steps).max().unwrap_or(0);
        // cos(step theta) by axis, step and mode: one product of three a neighbour is left.
        let cosines = [0, 1, 2].map(|axis| {
            let of = |step: usize| {
                let cosine = move |k| (step as f64 * self.angle(axis, k)).cos();
                (0..self.counts[axis]).map(cosine).collect()
            };
            (0..=reach).map(of).collect::<Vec<Vec<f64>>>()
        });
        self.map(|mode| {
            let of = |(steps, weight): &([usize; 3], f64)| {
                let [x, y, z] = [0, 1, 2].map(|axis: usize| cosines[axis][steps[axis]][mode[axis]]);
                weight * (x * y * z - 1.0)
            };
            entries.iter().map(of).sum()
        })
    }

    /// Rates of the modes by diffusion with `diffusivity` (m2/s) on a lattice of `spacing` (m), 1/s.
    pub(super) fn of_diffusion(&self, diffusivity: f64, spacing: f64) -> Vec<f64> {
        let scale = -diffusivity / (spacing * spacing);
        let square = |axis: usize, k: usize| self.angle(axis, k).powi(2);
        self.map(|[x, y, z]| scale * (square(0, x) + square(1, y) + square(2, z)))
    }

    /// A function of each mode, which has a number along each axis.
    fn map(&self, of: impl Fn([usize; 3]) -> f64 + Sync) -> Vec<f64> {
        let [nx, ny, nz] = self.counts;
        let mode = |mode: usize| of([mode % nx, mode / nx % ny, mode / (nx * ny)]);
        (0..nx * ny * nz).into_par_iter().map(mode).collect()
    }

    /// The angle from one particle to the next of mode `k` along an axis, the least of those that
    /// the particles cannot tell apart.
    fn angle(&self, axis: usize, k: usize) -> f64 {
        let n = self.counts[axis] as f64;
        match self.periodic[axis] {
            false => PI * k as f64 / n,
            true if 2 * k <= self.counts[axis] => 2.0 * PI * k as f64 / n,
            true => 2.0 * PI * (k as f64 - n) / n,
        }
    }

    /// Each mode along an axis at a place, with the factor of the way back.
    fn waves(&self, axis: usize, place: f64) -> Vec<f64> {
        let n = self.counts[axis];
        let wave = |k: usize| {
            let angle = self.angle(axis, k);
            match self.periodic[axis] {
                true => ((angle * (place - 0.5)).cos() + (angle * (place - 0.5)).sin()) / n as f64,
                false if k == 0 => 1.0 / n as f64,
                false => 2.0 / n as f64 * (angle * place).cos(),
            }
        };
        (0..n).map(wave).collect()
    }

    fn forward(&self, axis: usize) -> OfLine {
        let n = self.counts[axis];
        if self.periodic[axis] {
            return hartley(n, 1.0);
        }
        let transform = DctPlanner::new().plan_dct2(n);
        Box::new(move |line| transform.process_dct2(line))
    }

    fn backward(&self, axis: usize) -> OfLine {
        let n = self.counts[axis];
        if self.periodic[axis] {
            return hartley(n, 1.0 / n as f64);
        }
        let transform = DctPlanner::new().plan_dct3(n);
        Box::new(move |line| {
            transform.process_dct3(line);
            line.iter_mut().for_each(|x| *x *= 2.0 / n as f64);
        })
    }

    /// `values` with every line along an axis transformed.
    fn along(&self, values: &[f64], axis: usize, transform: &OfLine) -> Vec<f64> {
        let n = self.counts[axis];
        let stride: usize = self.counts[..axis].iter().product();
        let mut lines = vec![0.0; values.len()];
        lines.par_chunks_mut(n).enumerate().for_each(|(line, out)| {
            let first = line / stride * stride * n + line % stride;
            for (k, x) in out.iter_mut().enumerate() {
                *x = values[first + k * stride];
            }
            transform(out);
        });
        let back = |site: usize| {
            let (inner, rest) = (site % stride, site / stride);
            lines[(rest / n * stride + inner) * n + rest % n]
        };
        (0..values.len()).into_par_iter().map(back).collect()
    }
}

/// The Hartley transform of lines of n numbers, times a factor.
fn hartley(n: usize, factor: f64) -> OfLine {
    let transform = FftPlanner::new().plan_fft_forward(n);
    Box::new(move |line| {
        let mut complex: Vec<Complex<f64>> = line.iter().map(|&x| Complex::new(x, 0.0)).collect();
        transform.process(&mut complex);
        for (x, c) in line.iter_mut().zip(complex) {
            *x = factor * (c.re - c.im);
        }
    })
}

/// The steps to the neighbours of a class of lines, whatever their sides, with their weights: twice
/// that of a step along x, which goes to both.
fn entries(class: &LineClass) -> Vec<([usize; 3], f64)> {
    let sides = |x: usize| if x == 0 { 1.0 } else { 2.0 };
    let along = |&[y, z]: &[isize; 2]| {
        let [y, z] = [y, z].map(isize::unsigned_abs);
        (0..class.weights.len()).map(move |x| ([x, y, z], sides(x) * class.weights[x]))
    };
    class.lines.iter().flat_map(along).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;
    use crate::solver::cpu::CpuBackend;
    use crate::solver::{Backend, MachineKind, PathChoice, PathWish};
    use crate::study::{Operator, prepare};
    use serde_json::json;

    fn scene(boundaries: &serde_json::Value) -> case::Scene {
        let text = json!({
            "title": "a wave", "dimension": 3,
            "particles": {
                "spacing": 0.1,
                "fill": [{ "shape": { "box": { "min": [0, 0, 0], "max": [1, 0.9, 0.7] } }, "material": "m" }],
            },
            "kernel": { "name": "wendland_c2", "support_ratio": 2.5 },
            "materials": { "m": { "diffusivity": 1 } },
            "initial": [{ "value": "x^2 + sin(7*y) + x*y*z" }],
            "boundaries": boundaries,
            "time": { "end": 1e-4 },
        });
        case::from_json("wave", text, &[]).expect("a case")
    }

    fn insulated_and_periodic() -> serde_json::Value {
        json!([
            { "periodic": { "axes": ["y"] } },
            { "wall": { "faces": ["x_min", "x_max", "z_min", "z_max"], "kind": "insulated" } }
        ])
    }

    /// The largest difference between the rate that the solver has and that of the modes.
    fn off(scene: &case::Scene, factor: f64) -> f64 {
        let problem = &scene.problem;
        let choice =
            PathChoice::new(problem, MachineKind::Cpu, PathWish::Lattice).expect("a lattice");
        let (prepared, operator) =
            prepare(problem, MachineKind::Cpu, choice, false, true).expect("prepared");
        let Some(Operator::Lattice { scene: lattice, walls }) = operator else {
            panic!("it is a lattice");
        };
        let modes = Modes::of(&lattice);
        let amplitudes = modes.amplitudes(&problem.initial);
        let rates = modes.of_stencil(&lattice.classes);
        let dt = prepared.step.dt;
        let stepped: Vec<f64> =
            amplitudes.iter().zip(rates).map(|(a, rate)| a * (1.0 + factor * dt * rate)).collect();
        let expected = modes.field(&stepped);
        let mut backend = CpuBackend::lattice(problem, lattice, walls);
        backend.euler(0.0, dt, 1).expect("a step");
        let state = backend.read().expect("a state");
        state.as_ref().iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_step_of_the_solver_scales_the_modes_by_the_symbol() {
        let scene = scene(&insulated_and_periodic());
        assert!(off(&scene, 1.0) < 1e-13, "{:e}", off(&scene, 1.0));
        assert!(off(&scene, 1.001) > 1e-6, "a wrong weight is noticed: {:e}", off(&scene, 1.001));
    }

    #[test]
    fn fields_come_back_and_are_met_between_particles() {
        let scene = scene(&insulated_and_periodic());
        let lattice = LatticeScene::of(&scene.problem).expect("a lattice");
        let modes = Modes::of(&lattice);
        let amplitudes = modes.amplitudes(&scene.problem.initial);
        let back = modes.field(&amplitudes);
        for (a, b) in back.iter().zip(&scene.problem.initial) {
            assert!((a - b).abs() < 1e-13, "{a} and {b}");
        }
        let site = 3 + 10 * (4 + 9 * 5);
        let there = modes.at(&amplitudes, [3.5, 4.5, 5.5]);
        assert!((there - back[site]).abs() < 1e-12, "{there} and {}", back[site]);
        assert!((modes.at(&amplitudes, [3.6, 4.5, 5.5]) - back[site]).abs() > 1e-4, "and between");
    }
}
