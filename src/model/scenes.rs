//! Small scenes for unit tests.

use glam::DVec3;

use super::integrator::{Method, MethodChoice, Preconditioner};
use super::problem::{Problem, StepChoice, TimePlan};
use super::{Correction, Domain, Kernel, KernelKind, Material, PairMean, Particles};

/// A lattice of `counts` particles at distance `spacing`, one material with D = 1, value 0.
pub(crate) fn lattice(
    kind: KernelKind,
    dimension: usize,
    counts: [usize; 3],
    spacing: f64,
    support_ratio: f64,
) -> Problem {
    let mut position = Vec::new();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            for x in 0..counts[0] {
                position.push(cell_center([x, y, z], dimension, spacing));
            }
        }
    }
    let n = position.len();
    let mut max = DVec3::ZERO;
    for axis in 0..dimension {
        max[axis] = counts[axis] as f64 * spacing;
    }
    Problem {
        dimension,
        spacing,
        domain: Domain { min: DVec3::ZERO, max, periodic: [false; 3] },
        particles: Particles {
            position,
            volume: vec![spacing.powi(dimension as i32); n],
            material: vec![0; n],
        },
        materials: vec![Material::diffusive("rock", 1.0, 1000.0)],
        kernel: Kernel::new(kind, dimension, support_ratio * spacing).expect("kernel is defined"),
        pair_mean: PairMean::Harmonic,
        contacts: Vec::new(),
        correction: Correction::Moment,
        initial: vec![0.0; n],
        held: Vec::new(),
        walls: Vec::new(),
        surfaces: Vec::new(),
        sources: Vec::new(),
        time: TimePlan {
            end: 1.0,
            step: StepChoice::Automatic,
            method: MethodChoice::Given(Method::Euler),
            breaks: Vec::new(),
            linear_tolerance: None,
            preconditioner: Preconditioner::TwoLevel,
            output_every: 1.0,
            probe_every: 1.0,
        },
        probes: Vec::new(),
    }
}

fn cell_center(index: [usize; 3], dimension: usize, spacing: f64) -> DVec3 {
    let mut x = DVec3::ZERO;
    for axis in 0..dimension {
        x[axis] = (index[axis] as f64 + 0.5) * spacing;
    }
    x
}

/// Numbers in [0, 1), the same on every machine.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
