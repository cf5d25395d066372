//! Stored rows of sites that the stencil does not describe, on the device.

use crate::gpu::{Buffer, Device, GpuError};
use crate::model::operator::SomeRows;
use crate::solver::Precision;
use crate::solver::gpu::passes::SLICE_ROWS;

/// Neighbours and weights in slices of [`SLICE_ROWS`] rows: element k of a row sits as many elements after
/// element k - 1. The first of a row is the number of its neighbours, which follow.
#[derive(Debug)]
pub(super) struct Rows {
    pub(super) neighbor: Buffer,
    pub(super) weight: Buffer,
    /// Site and first element of each row, by site.
    pub(super) first: Vec<(u32, u32)>,
}

impl Rows {
    /// The rows of `rows`, with weights relative to `reference_step` (s); `None` where there are none.
    pub(super) fn new(
        device: &Device,
        rows: &SomeRows,
        reference_step: f64,
        precision: Precision,
    ) -> Result<Option<Self>, GpuError> {
        let entries: Vec<(&[u32], &[f64])> = rows.entries().collect();
        if entries.is_empty() {
            return Ok(None);
        }
        let lanes = SLICE_ROWS as usize;
        let (mut neighbor, mut weight): (Vec<u32>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut first = Vec::with_capacity(entries.len());
        for slice in entries.chunks(lanes) {
            let start = neighbor.len();
            let longest = slice.iter().map(|(neighbors, _)| neighbors.len()).max().unwrap_or(0);
            let end = start + (1 + longest) * lanes;
            if u32::try_from(end).is_err() {
                let needed = end as u64 * (4 + precision.state_bytes());
                let available = u64::from(u32::MAX) * (4 + precision.state_bytes());
                let what = "stored rows of a lattice".to_owned();
                return Err(GpuError::TooLarge { what, needed, available });
            }
            neighbor.resize(end, 0);
            weight.resize(end, 0.0);
            for (lane, (neighbors, weights)) in slice.iter().enumerate() {
                first.push((start + lane) as u32);
                neighbor[start + lane] = neighbors.len() as u32;
                for (k, (&b, &w)) in neighbors.iter().zip(*weights).enumerate() {
                    let at = start + (1 + k) * lanes + lane;
                    (neighbor[at], weight[at]) = (b, reference_step * w);
                }
            }
        }
        Ok(Some(Self {
            neighbor: device.storage_with("neighbours of rows", bytemuck::cast_slice(&neighbor))?,
            weight: device.storage_with("weights of rows", &precision.state_to_bytes(&weight))?,
            first: rows.rank().iter().copied().zip(first).collect(),
        }))
    }

    /// Some of them, by site, in the same buffers; `None` if there are none.
    pub(super) fn only(&self, is_one: impl Fn(u32) -> bool) -> Option<Self> {
        let first = self.first.iter().copied().filter(|&(site, _)| is_one(site));
        let first: Vec<(u32, u32)> = first.collect();
        let (neighbor, weight) = (self.neighbor.clone(), self.weight.clone());
        (!first.is_empty()).then_some(Self { neighbor, weight, first })
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.neighbor.bytes() + self.weight.bytes()
    }
}
