//! Interfaces between materials whose place is known: those on the faces of a lattice's cells.
//!
//! The harmonic mean of a pair takes the interface to lie half way. On a lattice it is known how far a pair
//! runs through each material: with that the resistances add up to the true one, k = 1 / sum of share / k,
//! and steady layers are exact for every support, also where a layer is thinner than that. A contact
//! resistance R (m2 K/W) adds R over the distance across the face that the pair crosses.

use glam::DVec3;

use crate::model::lattice::{ABSENT, sites_with_particles};
use crate::model::{PairMean, Problem};

/// A resistance where two materials meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactResistance {
    /// The materials, indices into [`Problem::materials`], the smaller first.
    pub between: [u16; 2],
    /// R, m2 K/W (over the diffusivity's unit, where there is only that), not negative.
    pub resistance: f64,
}

/// What lies between the particles of a pair.
#[derive(Debug)]
pub(super) struct Interfaces<'a> {
    problem: &'a Problem,
    counts: [usize; 3],
    /// Material at each site, or [`NOTHING`].
    material: Vec<u16>,
}

/// The material of a site without a particle.
const NOTHING: u16 = u16::MAX;

impl<'a> Interfaces<'a> {
    /// Those of `problem`, if they make any difference: several materials that are joined by harmonic means
    /// on a lattice, and a support beyond the next cells or a contact resistance.
    pub(super) fn of(problem: &'a Problem) -> Option<Self> {
        // Up to two spacings a pair runs half through the cell of each.
        let is_wide = problem.kernel.support_radius() > 2.0 * problem.spacing * (1.0 + 1e-9);
        let counts = is_wide || !problem.contacts.is_empty();
        if !counts || problem.pair_mean != PairMean::Harmonic {
            return None;
        }
        let first = problem.particles.material.first();
        if problem.particles.material.iter().all(|m| Some(m) == first) {
            return None;
        }
        let (counts, order) = sites_with_particles(problem)?;
        let of_particle = |particle: u32| match particle {
            ABSENT => NOTHING,
            _ => problem.particles.material[particle as usize],
        };
        let material = match order {
            Some(order) => order.into_iter().map(of_particle).collect(),
            None => problem.particles.material.clone(),
        };
        Some(Self { problem, counts, material })
    }

    /// What the weight of the pair `a`, `b` is multiplied by, which is that of the harmonic mean: 1 where
    /// they lie within one material. The same for the pair `b`, `a`, to the last bit.
    pub(super) fn factor(&self, a: usize, b: usize) -> f64 {
        let [a, b] = [a.min(b), a.max(b)];
        let [of_a, of_b] = [a, b].map(|particle| self.problem.particles.material[particle]);
        let k = |material: u16| self.problem.materials[usize::from(material)].conductivity;
        let harmonic = 0.5 / k(of_a) + 0.5 / k(of_b);
        let resistance = self.resistance([a, b], [of_a, of_b]);
        if resistance == harmonic { 1.0 } else { harmonic / resistance }
    }

    /// What resists along the way from `a` to `b`, over its length.
    fn resistance(&self, [a, b]: [usize; 2], [of_a, of_b]: [u16; 2]) -> f64 {
        let Problem { domain, particles, spacing, materials, .. } = self.problem;
        let [at_a, at_b] = [a, b].map(|particle| particles.position[particle]);
        let steps = domain.nearest_image(at_b - at_a) / *spacing;
        let steps = [steps.x, steps.y, steps.z].map(|step| step.round() as i64);
        let start = ((at_a - domain.min) / *spacing - DVec3::splat(0.5)).to_array();
        let start = start.map(|place| place.round() as i64);
        let (mut at, mut material, mut passed, mut sum) = (start, of_a, 0.0, 0.0);
        for (share, axes) in crossings(steps) {
            sum += (share - passed) / materials[usize::from(material)].conductivity;
            let mut across = f64::INFINITY;
            for axis in (0..3).filter(|axis| axes[*axis]) {
                at[axis] += steps[axis].signum();
                across = across.min(steps[axis].unsigned_abs() as f64 * spacing);
            }
            let next = match self.at(at) {
                // What is nowhere resists like what is nearer.
                NOTHING => {
                    if share < 0.5 {
                        of_a
                    } else {
                        of_b
                    }
                }
                material => material,
            };
            if next != material {
                sum += self.contact([material, next]) / across;
            }
            (material, passed) = (next, share);
        }
        sum + (1.0 - passed) / materials[usize::from(of_b)].conductivity
    }

    /// The material at a site, which may lie beyond the ends of a periodic axis.
    fn at(&self, at: [i64; 3]) -> u16 {
        let mut site = 0;
        for axis in (0..self.problem.dimension).rev() {
            let count = self.counts[axis] as i64;
            let is_periodic = self.problem.domain.periodic[axis];
            let place = if is_periodic { at[axis].rem_euclid(count) } else { at[axis] };
            if !(0..count).contains(&place) {
                return NOTHING;
            }
            site = site * self.counts[axis] + place as usize;
        }
        self.material[site]
    }

    fn contact(&self, [a, b]: [u16; 2]) -> f64 {
        let between = [a.min(b), a.max(b)];
        let contact = self.problem.contacts.iter().find(|contact| contact.between == between);
        contact.map_or(0.0, |contact| contact.resistance)
    }
}

/// Where a way of so many steps along each axis crosses faces of cells, as shares of its length, ascending,
/// and across which axes.
fn crossings(steps: [i64; 3]) -> Vec<(f64, [bool; 3])> {
    let mut found: Vec<(f64, [bool; 3])> = Vec::new();
    for (axis, step) in steps.iter().enumerate() {
        let count = step.unsigned_abs();
        for k in 0..count {
            let mut axes = [false; 3];
            axes[axis] = true;
            // Twice the numerator is whole, so that equal shares are equal to the last bit.
            found.push(((2 * k + 1) as f64 / (2 * count) as f64, axes));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.dedup_by(|next, last| {
        let is_same = next.0 == last.0;
        if is_same {
            (0..3).for_each(|axis| last.1[axis] |= next.1[axis]);
        }
        is_same
    });
    found
}

#[cfg(test)]
#[path = "interfaces_tests.rs"]
mod tests;
