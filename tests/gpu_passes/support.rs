//! What the tests share: one device, random numbers, scenes.

use std::sync::OnceLock;

use diffusph::gpu::{self, Device};
use diffusph::model::integrator::{Method, MethodChoice, Preconditioner};
use diffusph::model::operator::PairWeight;
use diffusph::model::{
    Correction, Domain, Kernel, KernelKind, Material, PairMean, Particles, Problem, StepChoice,
    TimePlan,
};
use diffusph::solver::Precision;
use diffusph::solver::gpu::{GpuBackend, GpuOptions};
use glam::DVec3;

/// The device that all tests of this process share.
pub(crate) fn device() -> &'static Device {
    static DEVICE: OnceLock<Device> = OnceLock::new();
    DEVICE.get_or_init(|| {
        let adapter = gpu::choose(None, true)
            .expect("these tests need an adapter")
            .expect("a software adapter is allowed");
        Device::open(&adapter).expect("the adapter opens")
    })
}

/// `problem` on the device by list and matrix-free; `dt` (s) is the step that weights are relative to.
pub(crate) fn by_neighbors(
    problem: &Problem,
    dt: f64,
    precision: Precision,
) -> [(&'static str, GpuBackend); 2] {
    [("list", false), ("matrix-free", true)].map(|(name, matrix_free)| {
        let options = GpuOptions { matrix_free, ..GpuOptions::new(precision) };
        let backend = GpuBackend::with_options(problem, dt, device(), options);
        (name, backend.unwrap_or_else(|error| panic!("{name}: {error}")))
    })
}

/// The spacing of the numbers just above 1 in which rates are computed.
pub(crate) fn epsilon(precision: Precision) -> f64 {
    match precision {
        Precision::F32 | Precision::Compensated => f64::from(f32::EPSILON),
        Precision::F64 => f64::EPSILON,
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014, OOPSLA, 453).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Of a conductivity over three decades, and a capacity between 0.6 and 1.6.
    fn material(&mut self) -> Material {
        let conductivity = 1e-11 * 10_f64.powf(-3.0 * self.unit());
        Material { conductivity, capacity: 0.6 + self.unit(), ..material(1.0) }
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A scene of one material with unit volumes and a field of zeros; tests change what they need.
pub(crate) fn scene(
    kind: KernelKind,
    support_radius: f64,
    domain: Domain,
    dimension: usize,
    position: Vec<DVec3>,
) -> Problem {
    let count = position.len();
    Problem {
        dimension,
        spacing: support_radius / 2.0,
        domain,
        particles: Particles { position, volume: vec![1.0; count], material: vec![0; count] },
        materials: vec![material(1.0)],
        kernel: Kernel::new(kind, dimension, support_radius).expect("defined in this dimension"),
        pair_mean: PairMean::Harmonic,
        contacts: Vec::new(),
        correction: Correction::Moment,
        initial: vec![0.0; count],
        walls: Vec::new(),
        surfaces: Vec::new(),
        sources: Vec::new(),
        held: Vec::new(),
        time: TimePlan {
            end: 1.0,
            step: StepChoice::Given(1.0),
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

pub(crate) fn material(diffusivity: f64) -> Material {
    Material::diffusive("m", diffusivity, 1000.0)
}

/// A jittered lattice of `side` particles along each axis, periodic along x, with random fields,
/// volumes, capacities and conductivities of contrast 1e3. SI units of a rock: extreme numbers for f32.
pub(crate) fn random_lattice(kind: KernelKind, dimension: usize, side: usize) -> Problem {
    let mut random = Random(7 + dimension as u64);
    let spacing = 1e-6;
    let along = |axis| if axis < dimension { side } else { 1 };
    let mut position = Vec::new();
    for n in 0..side.pow(dimension as u32) {
        let at = [n % side, n / side % side, n / (side * side)];
        let mut x = DVec3::ZERO;
        for axis in 0..dimension {
            x[axis] = spacing * (at[axis] as f64 + 0.5 + 0.2 * (random.unit() - 0.5));
        }
        position.push(x);
    }
    let max = DVec3::from_array([0, 1, 2].map(|axis| match axis < dimension {
        true => along(axis) as f64 * spacing,
        false => 0.0,
    }));
    let domain = Domain { min: DVec3::ZERO, max, periodic: [true, false, false] };
    let mut problem = scene(kind, 2.0 * spacing, domain, dimension, position);
    let volume = spacing.powi(dimension as i32);
    problem.materials = (0..10).map(|_| random.material()).collect();
    for i in 0..problem.particles.len() {
        problem.particles.volume[i] = volume * (0.8 + 0.4 * random.unit());
        problem.particles.material[i] = (random.next() % 10) as u16;
        problem.initial[i] = 300.0 + 20.0 * random.unit();
    }
    problem
}

/// Roundings of a term at most, each worth one epsilon of the term: pair mean 6, volume, capacity and scale
/// 3, field difference 1, and 16 of the kernel, which rounding of the offsets moves as well.
const ROUNDINGS_OF_A_TERM: f64 = 32.0;

/// The rate of every particle in f64, and the tolerance of its sum where terms and additions are
/// rounded to `epsilon`.
pub(crate) fn brute_force(problem: &Problem, epsilon: f64) -> Vec<(f64, f64)> {
    let weight = PairWeight::new(problem);
    let position = &problem.particles.position;
    let count = position.len();
    let of = |a: usize| {
        let (mut sum, mut terms, mut neighbors) = (0.0, 0.0, 0);
        for b in (0..count).filter(|&b| b != a) {
            let dist = problem.domain.nearest_image(position[a] - position[b]).length();
            if dist < problem.kernel.cutoff() {
                let term = weight.of(a, b, dist) * (problem.initial[b] - problem.initial[a]);
                sum += term;
                // The fields themselves are rounded to the precision of the device.
                terms += term.abs() + weight.of(a, b, dist) * problem.initial[a].abs();
                neighbors += 1;
            }
        }
        let roundings = ROUNDINGS_OF_A_TERM + f64::from(neighbors);
        (sum, roundings * epsilon * terms)
    };
    (0..count).map(of).collect()
}

/// The first place where two sequences differ.
pub(crate) fn first_difference<T: PartialEq>(a: &[T], b: &[T]) -> Option<usize> {
    let shorter = a.len().min(b.len());
    (0..shorter).find(|&i| a[i] != b[i]).or((a.len() != b.len()).then_some(shorter))
}
