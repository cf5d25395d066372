use diffusph::gpu::Real;
use diffusph::model::{KernelKind, PairMean};
use diffusph::solver::Precision;
use diffusph::solver::gpu::Choices;
use diffusph::solver::gpu::passes::{Neighbors, WallTerms};

use crate::support::{Random, device};

/// Roundings in a pair function at most, as multiples of its largest term: no kernel has more than
/// eleven operations after 1 - q, and a division may be off by 2.5 units in the last place.
const ROUNDINGS: f64 = 16.0;

/// Arguments, and what the device makes of each: shape, shape of the derivative, pair mean.
struct Probed {
    arguments: Vec<[f64; 2]>,
    shape: Vec<f64>,
    mean: Vec<f64>,
}

fn choices(kernel: KernelKind, pair_mean: PairMean, precision: Precision) -> Choices {
    Choices {
        kernel,
        pair_mean,
        dimension: 1,
        periodic: [false; 3],
        held: false,
        walls: WallTerms::None,
        uniform: true,
        neighbors: Neighbors::Listed,
        precision,
        workgroup_size: 64,
    }
}

fn probe(choices: &Choices) -> Probed {
    let real = choices.real();
    let mut random = Random(3);
    // Distances first; as diffusivities the same numbers serve, with a second one beside.
    let first_q = if choices.kernel == KernelKind::Hat { 1 } else { 0 };
    let exact: Vec<f64> = (first_q..1000)
        .flat_map(|n| [f64::from(n) / 1000.0, 10_f64.powf(6.0 * random.unit() - 3.0)])
        .collect();
    let bytes = real.to_bytes(&exact);
    // Both sides see what the device sees.
    let rounded = real.from_bytes(&bytes);
    let arguments = device().storage_with("arguments", &bytes).expect("buffer");
    let count = rounded.len() / 2;
    let shape = device().storage("shape", bytes.len() as u64).expect("buffer");
    let mean = device().storage("mean", bytes.len() as u64 / 2).expect("buffer");
    let pass =
        device().pass(&choices.probe(), &[&arguments, &shape, &mean], count as u64).expect("pass");
    device().submit([&pass]).expect("submission");
    Probed {
        arguments: rounded.chunks_exact(2).map(|a| [a[0], a[1]]).collect(),
        shape: real.from_bytes(&device().read(&shape).expect("shape")),
        mean: real.from_bytes(&device().read(&mean).expect("mean")),
    }
}

/// The sums of |terms| where a kernel is a difference of larger terms: shape and derivative.
fn terms(kind: KernelKind) -> [f64; 2] {
    match kind {
        KernelKind::CubicSpline => [1.0 + 1.5 + 0.75, 9.0 + 12.0],
        KernelKind::QuinticSpline => [243.0 + 6.0 * 32.0 + 15.0, 45.0 * (81.0 + 6.0 * 16.0)],
        _ => [0.0, 0.0],
    }
}

/// How many of the values are off by more than roundings explain, with `perturbation` relative
/// added to the first of each kind.
fn wrong_values(choices: &Choices, perturbation: f64) -> usize {
    let probed = probe(choices);
    let definition = choices.kernel.definition();
    let unit = ROUNDINGS * choices.real().epsilon();
    let terms = terms(choices.kernel);
    let is_off = |got: f64, expected: f64, terms: f64| {
        let tolerance = unit * expected.abs().max(terms);
        let off = (got - expected).abs();
        off > tolerance || off.is_nan()
    };
    let mut wrong = 0;
    for (i, &[q, other]) in probed.arguments.iter().enumerate() {
        let factor = if i == 1 { 1.0 + perturbation } else { 1.0 };
        let shape = factor * (definition.shape)(q);
        let slope = factor * (definition.shape_dw_over_r)(q);
        wrong += usize::from(is_off(probed.shape[2 * i], shape, terms[0]));
        wrong += usize::from(is_off(probed.shape[2 * i + 1], slope, terms[1]));
        if q > 0.0 {
            let mean = factor * choices.pair_mean.of(q, other);
            wrong += usize::from(is_off(probed.mean[i], mean, 0.0));
        }
    }
    wrong
}

#[test]
fn pair_functions_equal_their_twins_and_the_check_notices_a_perturbation() {
    for precision in Precision::ALL {
        for kernel in KernelKind::ALL {
            for pair_mean in PairMean::ALL {
                let choices = choices(kernel, pair_mean, precision);
                assert_eq!(
                    wrong_values(&choices, 0.0),
                    0,
                    "{kernel:?} {pair_mean:?} {precision:?}"
                );
                let large = match choices.real() {
                    Real::F32 => 1e-2,
                    Real::F64 => 1e-10,
                };
                assert_eq!(wrong_values(&choices, large), 3, "{kernel:?} {pair_mean:?}");
            }
        }
    }
}
