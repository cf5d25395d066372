//! The largest eigenvalue of the operator on an infinite lattice, from its plane waves.

use std::f64::consts::PI;

use glam::DVec3;

use crate::model::lattice::for_each_neighbor;
use crate::model::{Kernel, lattice};

/// lambda_max dx^2 / D of the operator on a lattice of one material, over the waves that fit into a
/// periodic box of `counts` particles; `corrected` for the moment-corrected operator.
///
/// A plane wave exp(i k x) is an eigenvector there: lambda = sum_b V 2 D |F| (1 - cos k r_b). Nothing is
/// assembled and nothing is iterated, so that this is independent of every other way to the limit.
pub fn lattice_eigenvalue(
    kernel: &Kernel,
    spacing: f64,
    counts: [usize; 3],
    corrected: bool,
) -> f64 {
    let volume = spacing.powi(kernel.dimension() as i32);
    let factor = match corrected {
        true => 1.0 / lattice::effective_diffusivity_ratio(kernel, spacing),
        false => 1.0,
    };
    let mut terms = Vec::new();
    for_each_neighbor(kernel, spacing, |offset| {
        let weight = -2.0 * factor * volume * kernel.dw_over_r(offset.length());
        terms.push((offset / spacing, weight * spacing * spacing));
    });
    // Waves in the other directions are mirror images of these.
    let [x, y, z] = counts.map(|count| {
        let wave = move |number: usize| 2.0 * PI * number as f64 / count as f64;
        (0..=count / 2).map(wave)
    });
    let waves = x.flat_map(|x| {
        let z = z.clone();
        y.clone().flat_map(move |y| z.clone().map(move |z| DVec3::new(x, y, z)))
    });
    let of_wave =
        |k: DVec3| -> f64 { terms.iter().map(|(r, w)| w * (1.0 - k.dot(*r).cos())).sum() };
    waves.map(of_wave).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::KernelKind;

    #[test]
    fn limits_of_the_cubic_lattice_are_the_published_ones() {
        let published = [(1, 0.5, 0.5), (2, 0.3665, 0.3713), (3, 0.3308, 0.3374)];
        for (dimension, plain, corrected) in published {
            let counts = std::array::from_fn(|axis| if axis < dimension { 16 } else { 1 });
            let kernel = Kernel::new(KernelKind::CubicSpline, dimension, 0.5).expect("a kernel");
            for (is_corrected, expected) in [(false, plain), (true, corrected)] {
                let limit = 2.0 / lattice_eigenvalue(&kernel, 0.25, counts, is_corrected);
                assert!((limit / expected - 1.0).abs() < 1e-3, "{dimension}-D: {limit}");
            }
        }
    }

    #[test]
    fn a_wrong_constant_is_noticed_by_the_plain_operator_alone() {
        let right = Kernel::new(KernelKind::CubicSpline, 2, 0.5).expect("a kernel");
        let wrong = right.with_factor(1.02);
        let ratio = |corrected| {
            let of = |kernel| lattice_eigenvalue(kernel, 0.25, [8, 8, 1], corrected);
            of(&wrong) / of(&right)
        };
        assert!((ratio(false) - 1.02).abs() < 1e-12);
        assert!((ratio(true) - 1.0).abs() < 1e-12, "the moment takes it out");
    }
}
