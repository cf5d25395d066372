use diffusph::model::{KernelKind, PairMean, Problem};
use diffusph::solver::gpu::GpuBackend;
use diffusph::solver::{Backend, Precision};

use crate::support::{brute_force, by_neighbors, device, epsilon, random_lattice};

/// How many rates are off by more than roundings explain, by list and matrix-free.
fn wrong_rates(on_device: &Problem, expected: &Problem, precision: Precision) -> [usize; 2] {
    let expected = brute_force(expected, epsilon(precision));
    by_neighbors(on_device, 1e-3, precision).map(|(_, mut backend)| {
        let rate = backend.rate(0.0).expect("rate");
        assert_eq!(rate.as_ref().len(), expected.len());
        let wrong = |&(&got, &(sum, tolerance)): &(&f64, &(f64, f64))| {
            let off = (got - sum).abs();
            off > tolerance || off.is_nan()
        };
        rate.as_ref().iter().zip(&expected).filter(wrong).count()
    })
}

#[test]
fn rates_equal_brute_force_in_every_kernel_and_dimension() {
    for kernel in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
            for pair_mean in PairMean::ALL {
                for precision in Precision::ALL {
                    let side = [33, 9, 6][dimension - 1];
                    let mut problem = random_lattice(kernel, dimension, side);
                    problem.pair_mean = pair_mean;
                    let wrong = wrong_rates(&problem, &problem, precision);
                    assert_eq!(
                        wrong,
                        [0, 0],
                        "{kernel:?} {dimension}-D {pair_mean:?} {precision:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn uniform_scenes_take_the_shorter_path_to_the_same_rates() {
    for precision in Precision::ALL {
        let mut problem = random_lattice(KernelKind::CubicSpline, 3, 6);
        problem.particles.material.fill(0);
        problem.particles.volume.fill(1e-18);
        let backend = GpuBackend::new(&problem, 1e-3, device(), precision).expect("backend");
        assert!(backend.choices().expect("a list").uniform);
        assert_eq!(wrong_rates(&problem, &problem, precision), [0, 0]);
    }
}

#[test]
fn the_check_notices_one_volume_one_neighbor_and_one_value() {
    let problem = random_lattice(KernelKind::WendlandC4, 2, 9);
    let mut volume = problem.clone();
    volume.particles.volume[40] *= 1.01;
    let mut neighbor = problem.clone();
    neighbor.particles.position[40].x += 0.05 * neighbor.spacing;
    let mut value = problem.clone();
    value.initial[40] += 0.1;
    for wrong in [volume, neighbor, value] {
        let found = wrong_rates(&problem, &wrong, Precision::F32);
        assert!(found.iter().all(|&wrong| wrong > 0), "{found:?}");
    }
}
