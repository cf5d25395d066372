//! Fills shapes with particles on one lattice.

use std::ops::Range;

use glam::DVec3;

use super::error::CaseError;
use super::number::show;
use super::shape::Shape;
use crate::model::Particles;

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
}

impl Lattice {
    /// The particles of the fills, in their order; in each x runs fastest, then y, then z.
    pub(super) fn fill(&self, fills: &[Fill]) -> Result<Particles, CaseError> {
        self.check_count(fills)?;
        let mut particles = Particles::default();
        for (index, fill) in fills.iter().enumerate() {
            let before = particles.len();
            self.reserve(&mut particles, fill);
            self.for_each_site(fill, |x| {
                particles.position.push(x);
            });
            if particles.len() == before {
                let path = fill.path.clone();
                return Err(CaseError::EmptyFill { path, spacing: self.spacing });
            }
            self.check_overlap(&particles.position[before..], fill, &fills[..index])?;
            particles.material.resize(particles.len(), fill.material);
        }
        let volume = self.spacing.powi(self.dimension as i32);
        particles.volume = vec![volume; particles.len()];
        Ok(particles)
    }

    /// Refuses a scene by the boxes around its fills, before anything is allocated.
    fn check_count(&self, fills: &[Fill]) -> Result<(), CaseError> {
        let sites = |fill: &Fill| {
            let extent = (fill.bounds.1 - fill.bounds.0) / self.spacing;
            extent.to_array()[..self.dimension].iter().map(|n| n.round()).product::<f64>()
        };
        let count: f64 = fills.iter().map(sites).sum();
        if count <= f64::from(MOST) {
            return Ok(());
        }
        let gib = count * BYTES / (1u64 << 30) as f64;
        Err(CaseError::TooManyParticles { count, limit: MOST, gib })
    }

    /// Makes room for exactly the fill's particles: growing by doubling could take twice as much.
    fn reserve(&self, particles: &mut Particles, fill: &Fill) {
        let mut count = 0;
        self.for_each_site(fill, |_| count += 1);
        particles.position.reserve_exact(count);
        particles.material.reserve_exact(count);
    }

    fn for_each_site(&self, fill: &Fill, mut visit: impl FnMut(DVec3)) {
        let [along_x, along_y, along_z] = [0, 1, 2].map(|axis| self.range(fill, axis));
        for z in along_z {
            for y in along_y.clone() {
                for x in along_x.clone() {
                    let site = self.site([x, y, z]);
                    if fill.shape.contains(site, TOLERANCE * self.spacing) {
                        visit(site);
                    }
                }
            }
        }
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
