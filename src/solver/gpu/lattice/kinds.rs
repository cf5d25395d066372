//! Sites with different factors of the stencil, or without a particle, on the device.

use std::collections::HashMap;

use crate::gpu::{Buffer, Device, GpuError};
use crate::model::lattice::MixedScene;
use crate::solver::Precision;

/// Different factors that a byte can name, beside the kind of what the stencil does not write.
const MOST: usize = 255;

/// The kind of each site and the factor of each kind.
#[derive(Debug)]
pub(super) struct Kinds {
    /// A byte a site.
    pub(super) kind: Buffer,
    pub(super) factor: Buffer,
}

impl Kinds {
    /// Those of `scene`, whose sites `stored` (each with its first element) have rows of their own; `others`, of which it tells no factor, the
    /// stencil writes too, with one of its factors. `None` where the stencil is that of every site, and every site has a
    /// particle.
    pub(super) fn new(
        device: &Device,
        scene: &MixedScene,
        stored: &[(u32, u32)],
        others: &[(u32, f64)],
        precision: Precision,
    ) -> Result<Option<Self>, GpuError> {
        let factors = factors(scene);
        if scene.absent.is_empty() && factors == [1.0] {
            return Ok(None);
        }
        let kinds = kinds(scene, stored, others, &factors);
        let of_kinds: Vec<f64> = std::iter::once(0.0).chain(factors).collect();
        Ok(Some(Self {
            kind: device.storage_with("kinds of sites", &kinds)?,
            factor: device
                .storage_with("factors of kinds", &precision.state_to_bytes(&of_kinds))?,
        }))
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.kind.bytes() + self.factor.bytes()
    }
}

/// Whether a byte can name every factor that the stencil of `scene` has.
pub fn are_few(scene: &MixedScene) -> bool {
    factors(scene).len() <= MOST
}

/// The factors that the stencil has, each once.
pub(in crate::solver::gpu) fn factors(scene: &MixedScene) -> Vec<f64> {
    let mut factors: Vec<f64> = scene.ratios.iter().map(|(_, factor)| *factor).collect();
    factors.sort_by(f64::total_cmp);
    factors.dedup();
    factors
}

/// A byte for each site, up to a whole number of elements of four: 0 where the stencil writes nothing, else one more
/// than the place of its factor.
fn kinds(
    scene: &MixedScene,
    stored: &[(u32, u32)],
    others: &[(u32, f64)],
    factors: &[f64],
) -> Vec<u8> {
    let sites: usize = scene.lattice.counts.iter().product();
    let kind_of: HashMap<u64, u8> =
        (1..).zip(factors).map(|(kind, factor)| (factor.to_bits(), kind)).collect();
    let mut kinds = vec![0; sites.next_multiple_of(4)];
    let ends = scene.ratios.iter().skip(1).map(|&(first, _)| first as usize).chain([sites]);
    for (&(first, factor), end) in scene.ratios.iter().zip(ends) {
        kinds[first as usize..end].fill(kind_of[&factor.to_bits()]);
    }
    for range in &scene.absent {
        kinds[range.start as usize..range.end as usize].fill(0);
    }
    stored.iter().for_each(|&(site, _)| kinds[site as usize] = 0);
    others.iter().for_each(|(site, factor)| kinds[*site as usize] = kind_of[&factor.to_bits()]);
    kinds
}
