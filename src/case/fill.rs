//! Fills shapes with particles on one lattice.

use std::collections::TryReserveError;
use std::ops::Range;

use glam::DVec3;

use super::error::CaseError;
use super::number::show;
use super::shape::Shape;
use crate::model::{Domain, Particles};

/// Particles sit on a shape's surface up to this fraction of the spacing.
pub(super) const TOLERANCE: f64 = 1e-9;

/// The most particles a scene may have: indices are u32, and backends reserve the top ones.
const MOST: u32 = u32::MAX - 2;

/// Bytes of the host arrays for one particle: position, volume, material, initial value.
const BYTES: f64 = 24.0 + 8.0 + 2.0 + 8.0;

/// A bounded shape of one material.
pub(super) struct Fill {
    /// Path in the case file.
    pub(super) path: String,
    /// What is filled.
    pub(super) shape: Shape,
    /// Lower and upper corner of the box around it, m.
    pub(super) bounds: (DVec3, DVec3),
    /// Index of the material.
    pub(super) material: u16,
}

/// The lattice that every fill shares: sites at origin + (i + 1/2) spacing.
pub(super) struct Lattice {
    /// Lower corner of the first fill's bounding box, m.
    pub(super) origin: DVec3,
    /// Distance of neighbours, m.
    pub(super) spacing: f64,
    /// 1, 2 or 3.
    pub(super) dimension: usize,
    /// The box around every fill; on its periodic axes its upper edge is its lower one.
    pub(super) domain: Domain,
}

impl Lattice {
    /// The particles of the fills, in their order; in each x runs fastest, then y, then z.
    pub(super) fn fill(&self, fills: &[Fill]) -> Result<Particles, CaseError> {
        self.check_count(fills)?;
        let volume = self.spacing.powi(self.dimension as i32);
        let mut particles = Particles::default();
        for (index, fill) in fills.iter().enumerate() {
            let before = particles.len();
            let mut count = 0;
            self.for_each_site(fill, |_| count += 1);
            reserve(&mut particles, fill, count)?;
            self.for_each_site(fill, |x| {
                particles.position.push(x);
            });
            if particles.len() == before {
                let path = fill.path.clone();
                return Err(CaseError::EmptyFill { path, spacing: self.spacing });
            }
            self.check_overlap(&particles.position[before..], fill, &fills[..index])?;
            particles.material.resize(particles.len(), fill.material);
            particles.volume.resize(particles.len(), volume);
        }
        Ok(particles)
    }

    /// Refuses a scene by the boxes around its fills, before anything is allocated.
    fn check_count(&self, fills: &[Fill]) -> Result<(), CaseError> {
        let sites = |fill: &Fill| {
            let extent = (fill.bounds.1 - fill.bounds.0) / self.spacing;
            // An axis thinner than half a spacing may still hold a layer of sites.
            let layers = |n: &f64| n.round().max(1.0);
            extent.to_array()[..self.dimension].iter().map(layers).product::<f64>()
        };
        let count: f64 = fills.iter().map(sites).sum();
        if count <= f64::from(MOST) {
            return Ok(());
        }
        let gib = count * BYTES / (1u64 << 30) as f64;
        Err(CaseError::TooManyParticles { count, limit: MOST, gib })
    }

    fn for_each_site(&self, fill: &Fill, mut visit: impl FnMut(DVec3)) {
        let [along_x, along_y, along_z] = [0, 1, 2].map(|axis| self.range(fill, axis));
        for z in along_z {
            for y in along_y.clone() {
                for x in along_x.clone() {
                    let site = self.site([x, y, z]);
                    let inside = fill.shape.contains(site, TOLERANCE * self.spacing);
                    if inside && !self.repeats(site) {
                        visit(site);
                    }
                }
            }
        }
    }

    /// Whether the site lies on the upper edge of a periodic axis, or past it: it is the image of
    /// one at the lower edge.
    fn repeats(&self, site: DVec3) -> bool {
        let edge = self.domain.max - TOLERANCE * self.spacing;
        (0..self.dimension).any(|axis| self.domain.periodic[axis] && site[axis] >= edge[axis])
    }

    /// Indices along an axis that cover the fill, one to spare at either end for rounding.
    fn range(&self, fill: &Fill, axis: usize) -> Range<i64> {
        if axis >= self.dimension {
            return 0..1;
        }
        let index = |edge: f64| (edge - self.origin[axis]) / self.spacing;
        let (min, max) = (index(fill.bounds.0[axis]), index(fill.bounds.1[axis]));
        (min.floor() as i64 - 1)..(max.ceil() as i64 + 1)
    }

    fn site(&self, index: [i64; 3]) -> DVec3 {
        let mut x = DVec3::ZERO;
        for axis in 0..self.dimension {
            x[axis] = self.origin[axis] + (index[axis] as f64 + 0.5) * self.spacing;
        }
        x
    }

    /// A site of two fills would hold two particles.
    fn check_overlap(
        &self,
        sites: &[DVec3],
        fill: &Fill,
        earlier: &[Fill],
    ) -> Result<(), CaseError> {
        let tolerance = TOLERANCE * self.spacing;
        for other in earlier {
            if let Some(&x) = sites.iter().find(|&&x| other.shape.contains(x, tolerance)) {
                return Err(CaseError::Overlap {
                    first: other.path.clone(),
                    second: fill.path.clone(),
                    point: show(x, self.dimension),
                });
            }
        }
        Ok(())
    }
}

/// Makes room for exactly the fill's `count` particles: growing by doubling could take twice as
/// much.
fn reserve(particles: &mut Particles, fill: &Fill, count: usize) -> Result<(), CaseError> {
    make_room(particles, count).map_err(|_| CaseError::OutOfMemory {
        path: fill.path.clone(),
        count,
        bytes: count as f64 * BYTES,
    })
}

fn make_room(particles: &mut Particles, count: usize) -> Result<(), TryReserveError> {
    particles.position.try_reserve_exact(count)?;
    particles.material.try_reserve_exact(count)?;
    particles.volume.try_reserve_exact(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_is_not_there_is_an_error() {
        let bounds = (DVec3::ZERO, DVec3::ONE);
        let shape = Shape::Box { min: bounds.0, max: bounds.1, dimension: 3 };
        let fill = Fill { path: "particles.fill[0]".to_owned(), shape, bounds, material: 0 };
        let mut particles = Particles::default();
        let error = reserve(&mut particles, &fill, usize::MAX / 1000).expect_err("no memory");
        let text = error.to_string();
        let expected = "particles.fill[0]: no memory for 18446744073709551 particles (774763251";
        assert!(text.starts_with(expected) && text.ends_with(" bytes)"), "{text}");
        assert!(reserve(&mut particles, &fill, 3).is_ok());
    }
}
