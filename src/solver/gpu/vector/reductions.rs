//! Numbers from vectors. The device reduces each to one value a workgroup, and the rest is done here in
//! f64.

use super::passes::{REDUCED, dot, largest};
use super::queue::{Key, Operation};
use super::{Capacities, GpuVector, Operations};
use crate::gpu::{Buffer, GpuError, PassSource};

impl Operations<'_> {
    /// The sum of V x y.
    pub(in crate::solver::gpu) fn dot(
        &mut self,
        x: &GpuVector,
        y: &GpuVector,
    ) -> Result<f64, GpuError> {
        let precision = self.precision();
        let reference = self.scene.capacities.reference();
        self.write_capacities()?;
        let source = dot(precision, self.tools.capacity.is_some());
        let key = (Operation::Dot, vec![x.number, y.number]);
        let parts: Vec<[&Buffer; 2]> = x.parts.iter().zip(&y.parts).map(Into::into).collect();
        let partial = self.reduce::<2>(key, &source, &parts)?;
        Ok(reference * partial.chunks_exact(4).map(|p| p[0] * p[1] * p[2]).sum::<f64>())
    }

    /// Has the capacities on the device where they differ.
    pub(super) fn write_capacities(&mut self) -> Result<(), GpuError> {
        if let (Capacities::Each(capacities), None) = (&self.scene.capacities, &self.tools.capacity)
        {
            let reference = self.scene.capacities.reference();
            let ratios: Vec<f64> = capacities.iter().map(|c| c / reference).collect();
            let ratios = self.precision().real().to_bytes(&ratios);
            self.tools.capacity = Some(self.device.storage_with("capacities", &ratios)?);
        }
        Ok(())
    }

    /// The largest magnitude of a value of `x`; infinite if one is not finite.
    pub(in crate::solver::gpu) fn largest(&mut self, x: &GpuVector) -> Result<f64, GpuError> {
        self.largest_of((Operation::Largest, vec![x.number]), &x.parts)
    }

    /// The same of the state.
    pub(in crate::solver::gpu) fn largest_value(&mut self) -> Result<f64, GpuError> {
        let key = (Operation::LargestValue(self.steps.current()), Vec::new());
        let state = self.steps.content().to_vec();
        self.largest_of(key, &state)
    }

    fn largest_of(&mut self, key: Key, parts: &[Buffer]) -> Result<f64, GpuError> {
        let source = largest(self.precision());
        let parts: Vec<[&Buffer; 1]> = parts.iter().map(|part| [part]).collect();
        let found = self.reduce(key, &source, &parts)?;
        let is_finite = found.chunks_exact(4).all(|found| found[1] == 0.0);
        let largest = found.chunks_exact(4).map(|found| found[0]).fold(0.0, f64::max);
        Ok(if is_finite { largest } else { f64::INFINITY })
    }

    /// The four numbers that each workgroup makes of the parts of `N` vectors.
    fn reduce<const N: usize>(
        &mut self,
        key: Key,
        source: &PassSource,
        parts: &[[&Buffer; N]],
    ) -> Result<Vec<f64>, GpuError> {
        let precision = self.precision();
        let (tools, steps) = (&mut *self.tools, &*self.steps);
        tools.queue.run(self.device, key, || {
            let pass = |(part, sums): (&[&Buffer; N], &Buffer)| {
                let mut buffers = vec![steps.step_size()];
                buffers.extend(part);
                buffers.push(sums);
                // Only products have a weight.
                buffers.extend(tools.capacity.as_ref().filter(|_| N == 2));
                let groups = precision.values_in(part[0]).div_ceil(REDUCED);
                self.device.pass(source, &buffers, groups * u64::from(source.workgroup_size))
            };
            parts.iter().zip(&tools.sums).map(pass).collect()
        })?;
        let mut numbers = Vec::new();
        for sums in &self.tools.sums {
            numbers.extend(precision.real().from_bytes(&self.device.read(sums)?));
        }
        Ok(numbers)
    }
}
