//! Aggregates of particles on the device.

use std::ops::Range;

use super::passes::{RESTRICTING, prolong, restrict};
use super::queue::Operation;
use super::{GpuVector, Operations, by_place};
use crate::gpu::{Buffer, Device, GpuError};

/// Which particles belong together, by part of a vector.
#[derive(Debug)]
pub(super) struct Aggregates {
    count: usize,
    /// A number for each aggregate, as the device reads it.
    values: Buffer,
    parts: Vec<OfPart>,
}

/// The members of all aggregates in a part.
#[derive(Debug)]
struct OfPart {
    /// The aggregate of each place; of a place in none, a larger number than there are.
    of: Buffer,
    /// The places, aggregate by aggregate.
    place: Buffer,
    /// Where those of each begin in `place`, and where the last ones end.
    start: Buffer,
    /// What a sum over each has given.
    sums: Buffer,
}

impl OfPart {
    fn new(device: &Device, of: &[u32], count: usize, real: u64) -> Result<Self, GpuError> {
        let mut members: Vec<(u32, u32)> =
            of.iter().copied().zip(0..).filter(|&(k, _)| (k as usize) < count).collect();
        members.sort_unstable();
        let first = |k: u32| members.partition_point(|member| member.0 < k) as u32;
        let start: Vec<u32> = (0..=count as u32).map(first).collect();
        let mut place: Vec<u32> = members.iter().map(|&(_, place)| place).collect();
        // A buffer is not empty.
        place.resize(place.len().max(1), 0);
        Ok(Self {
            of: device.storage_with("aggregates", bytemuck::cast_slice(of))?,
            place: device.storage_with("members", bytemuck::cast_slice(&place))?,
            start: device.storage_with("first members", bytemuck::cast_slice(&start))?,
            sums: device.storage("sums over aggregates", count as u64 * real)?,
        })
    }
}

impl Aggregates {
    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let buffers = |part: &OfPart| {
            [&part.of, &part.place, &part.start, &part.sums].map(Buffer::bytes).iter().sum::<u64>()
        };
        self.values.bytes() + self.parts.iter().map(buffers).sum::<u64>()
    }
}

impl Operations<'_> {
    /// Takes note of the aggregate of each particle, in the problem's order, of `count`.
    pub(in crate::solver::gpu) fn aggregate(
        &mut self,
        of: &[u32],
        count: usize,
    ) -> Result<(), GpuError> {
        let by_place = by_place(self.order, of, u32::MAX);
        let real = self.precision().real().size() as u64;
        let of_part =
            |places: Range<usize>| OfPart::new(self.device, &by_place[places], count, real);
        let parts = self.operator.parts(by_place.len()).into_iter().map(of_part);
        let parts = parts.collect::<Result<_, _>>()?;
        let values = self.device.storage("values of aggregates", count as u64 * real)?;
        self.tools.aggregates = Some(Aggregates { count, values, parts });
        Ok(())
    }

    /// `out` = the sum of V x over each aggregate; nothing where there are none.
    pub(in crate::solver::gpu) fn restrict(
        &mut self,
        x: &GpuVector,
        out: &mut [f64],
    ) -> Result<(), GpuError> {
        self.write_capacities()?;
        let reference = self.scene.capacities.reference();
        let precision = self.precision();
        let (tools, steps) = (&mut *self.tools, &*self.steps);
        let Some(aggregates) = &tools.aggregates else {
            return Ok(());
        };
        tools.queue.run(self.device, (Operation::Restrict, vec![x.number]), || {
            let source = restrict(precision, tools.capacity.is_some());
            let pass = |(x, part): (&Buffer, &OfPart)| {
                let mut buffers = vec![steps.step_size(), x, &part.place, &part.start, &part.sums];
                buffers.extend(&tools.capacity);
                let threads = aggregates.count as u64 * u64::from(RESTRICTING);
                self.device.pass(&source, &buffers, threads)
            };
            x.parts.iter().zip(&aggregates.parts).map(pass).collect()
        })?;
        out.fill(0.0);
        for part in &aggregates.parts {
            let sums = precision.real().from_bytes(&self.device.read(&part.sums)?);
            out.iter_mut().zip(sums).for_each(|(out, sum)| *out += reference * sum);
        }
        Ok(())
    }

    /// Adds to `out` at each particle the value of its aggregate.
    pub(in crate::solver::gpu) fn prolong(
        &mut self,
        values: &[f64],
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        let precision = self.precision();
        let (tools, steps) = (&mut *self.tools, &*self.steps);
        let Some(aggregates) = &tools.aggregates else {
            return Ok(());
        };
        self.device.write(&aggregates.values, &precision.real().to_bytes(values))?;
        tools.queue.run(self.device, (Operation::Prolong, vec![out.number]), || {
            let pass = |(out, part): (&Buffer, &OfPart)| {
                let buffers = [steps.step_size(), &part.of, &aggregates.values, out];
                self.device.pass(&prolong(precision), &buffers, precision.values_in(out))
            };
            out.parts.iter().zip(&aggregates.parts).map(pass).collect()
        })
    }
}
