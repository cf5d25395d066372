//! The scenes of the benchmark: uniform lattices in a box, with free edges.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use crate::model::integrator::{Method, MethodChoice, Preconditioner};
use crate::model::{
    Correction, Domain, Kernel, KernelKind, Material, PairMean, Particles, Problem, StepChoice,
    TimePlan, lattice,
};

/// Bytes that a scene holds of a particle: position, volume, material and initial value.
pub(super) const PARTICLE_BYTES: u64 = 24 + 8 + 2 + 8;

/// The kernel of every scene.
const KERNEL: KernelKind = KernelKind::CubicSpline;

/// Particles along an axis of the box with about `size` particles.
pub(super) fn side(size: u64, dimension: usize) -> u64 {
    (size as f64).powf(1.0 / dimension as f64).round() as u64
}

/// How many particles the box with about `size` particles has.
pub(super) fn count(size: u64, dimension: usize) -> u64 {
    side(size, dimension).saturating_pow(dimension as u32)
}

/// Neighbours of a particle that is far from every edge.
pub(super) fn inner_neighbors(dimension: usize, support_ratio: f64) -> u64 {
    let mut neighbors = 0;
    lattice::for_each_neighbor(&kernel(dimension, 1.0, support_ratio), 1.0, |_| neighbors += 1);
    neighbors
}

/// A unit box with about `size` particles of D = 1 m2/s and a smooth initial field.
pub(super) fn scene(size: u64, dimension: usize, support_ratio: f64) -> Problem {
    let side = side(size, dimension) as usize;
    let spacing = 1.0 / side as f64;
    let count = side.pow(dimension as u32);
    let center = |particle: usize| {
        let mut x = DVec3::ZERO;
        let mut rest = particle;
        for axis in 0..dimension {
            x[axis] = ((rest % side) as f64 + 0.5) * spacing;
            rest /= side;
        }
        x
    };
    let position: Vec<DVec3> = (0..count).into_par_iter().map(center).collect();
    let value = |x: &DVec3| {
        1.0 + 0.5 * x.to_array()[..dimension].iter().map(|x| (TAU * x).cos()).product::<f64>()
    };
    let initial = position.par_iter().map(value).collect();
    let max = DVec3::from_array([0, 1, 2].map(|axis| if axis < dimension { 1.0 } else { 0.0 }));
    Problem {
        dimension,
        spacing,
        domain: Domain { min: DVec3::ZERO, max, periodic: [false; 3] },
        particles: Particles {
            position,
            volume: vec![spacing.powi(dimension as i32); count],
            material: vec![0; count],
        },
        materials: vec![Material::diffusive("unit", 1.0, 1000.0)],
        kernel: kernel(dimension, spacing, support_ratio),
        pair_mean: PairMean::Harmonic,
        contacts: Vec::new(),
        correction: Correction::Moment,
        initial,
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

/// Gives a scene another support radius, `support_ratio` spacings.
pub(super) fn widen(problem: &mut Problem, support_ratio: f64) {
    problem.kernel = kernel(problem.dimension, problem.spacing, support_ratio);
}

fn kernel(dimension: usize, spacing: f64, support_ratio: f64) -> Kernel {
    Kernel::new(KERNEL, dimension, support_ratio * spacing)
        .expect("the cubic spline is defined in every dimension")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::lattice::LatticeScene;

    #[test]
    fn scenes_are_lattices_of_the_size_asked_for() {
        for (size, dimension, expected) in [(10_000, 2, 10_000), (10_000, 3, 10_648)] {
            let mut problem = scene(size, dimension, 2.0);
            assert_eq!(
                (problem.particles.len() as u64, count(size, dimension)),
                (expected, expected)
            );
            let lattice = LatticeScene::of(&problem).expect("it is a lattice");
            assert!(lattice.order.is_none(), "in the order of its sites");
            let reach = lattice.reach;
            widen(&mut problem, 3.0);
            let wider = LatticeScene::of(&problem).expect("it is one still");
            assert!(wider.reach > reach);
            problem.particles.position[7].x += 0.1 * problem.spacing;
            assert!(LatticeScene::of(&problem).is_err());
        }
    }

    #[test]
    fn inner_particles_have_the_neighbours_of_the_lattice() {
        let counts = [(2, 2.0), (2, 3.0), (3, 2.0), (3, 3.0)].map(|(d, r)| inner_neighbors(d, r));
        // Points of the square and cubic lattice strictly within 2 and 3 spacings, but for the
        // middle one.
        assert_eq!(counts, [8, 24, 26, 92]);
    }
}
