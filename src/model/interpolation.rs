//! The value between particles: second-order interpolation by moving least squares.

use glam::DVec3;

use super::Problem;

/// A probe this close to a particle (in spacings) reads that particle.
const AT_PARTICLE: f64 = 1e-9;
/// A direction in which the neighbours spread less than this fraction of the support radius does
/// not enter the fit: its slope could not be told.
const SMALLEST_SPREAD: f64 = 1e-3;

/// A value at a fixed point as a weighted sum of particle values: sum_b c_b C_b with
/// sum_b c_b = 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolation {
    terms: Vec<(u32, f64)>,
}

impl Interpolation {
    /// The interpolation at `x` (m). At a particle it is that particle's value; elsewhere the
    /// linear moving least squares fit (Lancaster and Salkauskas 1981) over the particles within
    /// the support radius, weighted by the kernel: exact for linear fields, so second order.
    /// `None` where no particle is within the support radius.
    pub fn at(problem: &Problem, x: DVec3) -> Option<Self> {
        let near = Near::collect(problem, x);
        if let Some(&(index, _, _)) =
            near.terms.iter().find(|(_, r, _)| r.length() <= AT_PARTICLE * problem.spacing)
        {
            return Some(Self { terms: vec![(index, 1.0)] });
        }
        let total: f64 = near.terms.iter().map(|(_, _, w)| w).sum();
        (total > 0.0).then(|| near.fit(total, problem.kernel.support_radius()))
    }

    /// The interpolated value of `state`, in the problem's order.
    pub fn of(&self, state: &[f64]) -> f64 {
        self.terms.iter().map(|&(index, c)| c * state[index as usize]).sum()
    }
}

/// Particles near a point: index, vector from the point (m), kernel weight.
struct Near {
    terms: Vec<(u32, DVec3, f64)>,
}

impl Near {
    fn collect(problem: &Problem, x: DVec3) -> Self {
        let terms = (0_u32..)
            .zip(&problem.particles.position)
            .map(|(index, &p)| (index, problem.domain.nearest_image(p - x)))
            .filter(|(_, r)| r.length() < problem.kernel.support_radius())
            .map(|(index, r)| (index, r, problem.kernel.w(r.length())))
            .collect();
        Self { terms }
    }

    /// The weights of the linear fit's value at the point. Directions are made orthogonal one by
    /// one (Gram and Schmidt, in the weighted inner product, starting from the constant), and one
    /// without spread is left out: a sheet of particles is fitted along the sheet.
    fn fit(&self, total: f64, support_radius: f64) -> Interpolation {
        let weighted = |f: &[f64], g: &[f64]| -> f64 {
            self.terms.iter().zip(f).zip(g).map(|(((_, _, w), f), g)| w * f * g).sum::<f64>()
                / total
        };
        // Each basis function as its values at the particles and its value at the point.
        let mut basis: Vec<(Vec<f64>, f64)> = vec![(vec![1.0; self.terms.len()], 1.0)];
        for axis in 0..3 {
            let mut values: Vec<f64> =
                self.terms.iter().map(|(_, r, _)| r[axis] / support_radius).collect();
            let mut at_point = 0.0;
            for (other, other_at_point) in &basis {
                let along = weighted(&values, other);
                values.iter_mut().zip(other).for_each(|(v, o)| *v -= along * o);
                at_point -= along * other_at_point;
            }
            let norm = weighted(&values, &values).sqrt();
            if norm > SMALLEST_SPREAD {
                values.iter_mut().for_each(|v| *v /= norm);
                basis.push((values, at_point / norm));
            }
        }
        let coefficient = |k: usize| -> f64 {
            let value: f64 = basis.iter().map(|(values, at_point)| values[k] * at_point).sum();
            value * self.terms[k].2 / total
        };
        let terms = self.terms.iter().enumerate();
        Interpolation { terms: terms.map(|(k, &(index, _, _))| (index, coefficient(k))).collect() }
    }
}

#[cfg(test)]
#[path = "interpolation_tests.rs"]
mod tests;
