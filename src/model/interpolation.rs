//! The value between particles and at walls, to second order.

use glam::DVec3;

use super::operator::PairWeight;
use super::wall::WalledFace;
use super::{Problem, ScalarField, Wall, WallKind};

/// A probe this close to a particle (in spacings) reads that particle.
const AT_PARTICLE: f64 = 1e-9;
/// A direction in which the neighbours spread less than this fraction of the support radius does
/// not enter the fit: its slope could not be told.
const SMALLEST_SPREAD: f64 = 1e-3;

/// A value at a fixed point as a weighted sum of particle values and of what walls impose there.
#[derive(Clone, Debug)]
pub struct Interpolation {
    terms: Vec<(u32, f64)>,
    imposed: Vec<Imposed>,
}

/// `factor` x what a wall imposes at `at` (m).
#[derive(Clone, Debug)]
struct Imposed {
    field: ScalarField,
    at: DVec3,
    factor: f64,
}

impl Interpolation {
    /// The interpolation at `x` (m). At a particle it is that particle's value; on a wall, the mean
    /// of the value half a spacing inside and of its ghost, which is what the wall's relation says;
    /// elsewhere the linear moving least squares fit (Lancaster and Salkauskas 1981) over the
    /// particles within the support radius, weighted by the kernel: exact for linear fields, so
    /// second order. `None` where no particle is within the support radius.
    pub fn at(problem: &Problem, x: DVec3) -> Option<Self> {
        if let Some(wall) = wall_at(problem, x) {
            return Self::on_wall(problem, wall, x);
        }
        let near = Near::collect(problem, x);
        if let Some(&(index, _, _)) =
            near.terms.iter().find(|(_, r, _)| r.length() <= AT_PARTICLE * problem.spacing)
        {
            return Some(Self { terms: vec![(index, 1.0)], imposed: Vec::new() });
        }
        let total: f64 = near.terms.iter().map(|(_, _, w)| w).sum();
        (total > 0.0).then(|| near.fit(total, problem.kernel.support_radius()))
    }

    /// The interpolation at `x` (m) on `wall`: ((1 + s) C + c) / 2, with C half a spacing inside.
    fn on_wall(problem: &Problem, wall: &Wall, x: DVec3) -> Option<Self> {
        let depth = 0.5 * problem.spacing;
        let mut inside = x;
        inside[wall.face.axis] += if wall.face.upper { -depth } else { depth };
        let mut value = Self::at(problem, inside)?;
        let (nearest, _) = *value.terms.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let a = nearest as usize;
        let conductivity = PairWeight::new(problem).conductivity(a, a);
        let mirror = wall.condition.mirror(conductivity, depth, x)?;
        let share = 0.5 * (1.0 + mirror.scale);
        value.terms.iter_mut().for_each(|(_, c)| *c *= share);
        value.imposed.iter_mut().for_each(|imposed| imposed.factor *= share);
        let factor = 0.5 * mirror.offset;
        if factor != 0.0 {
            value.imposed.push(Imposed { field: wall.condition.imposed.clone(), at: x, factor });
        }
        Some(value)
    }

    /// The interpolated value of `state`, in the problem's order, at time `t` (s).
    pub fn of(&self, state: &[f64], t: f64) -> f64 {
        let particles: f64 = self.terms.iter().map(|&(index, c)| c * state[index as usize]).sum();
        let walls: f64 = self.imposed.iter().map(|i| i.factor * i.field.at(i.at, t)).sum();
        particles + walls
    }
}

/// The wall with ghosts that covers `x` (m), if `x` lies on one.
fn wall_at(problem: &Problem, x: DVec3) -> Option<&Wall> {
    let near = AT_PARTICLE * problem.spacing;
    let faces = WalledFace::all(&problem.walls, problem.dimension).into_iter();
    let mut on = faces.filter(|walled| walled.face().distance(&problem.domain, x).abs() <= near);
    let has_ghosts = |wall: &&Wall| wall.condition.kind != WallKind::Free;
    on.find_map(|walled| walled.at(x).map(|(_, wall)| wall).filter(has_ghosts))
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
        Interpolation {
            terms: terms.map(|(k, &(index, _, _))| (index, coefficient(k))).collect(),
            imposed: Vec::new(),
        }
    }
}

#[cfg(test)]
#[path = "interpolation_tests.rs"]
mod tests;
