//! Potentials and their slopes as vectors, where the state is an enthalpy.

use super::passes::multiply;
use super::queue::Operation;
use super::{GpuVector, Operations};
use crate::gpu::{Buffer, GpuError, PassSource};
use crate::solver::Precision;
use crate::solver::gpu::passes::{potential_change, slope_root};

impl Operations<'_> {
    /// The change of the rate with a change `x` of the state.
    pub(in crate::solver::gpu) fn rate_change(
        &mut self,
        x: &GpuVector,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        if self.steps.enthalpy().is_none() {
            return self.apply(x, 0.0, 1.0, out);
        }
        let mut potential = match self.tools.potential.take() {
            Some(potential) => potential,
            None => self.vector()?,
        };
        self.on_curve(Operation::PotentialChange, potential_change, x, &mut potential)?;
        self.apply(&potential, 0.0, 1.0, out)?;
        self.tools.potential = Some(potential);
        Ok(())
    }

    /// The square roots of the slopes of potentials after a change `x` of the state.
    pub(in crate::solver::gpu) fn slope_root(
        &mut self,
        x: &GpuVector,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        self.on_curve(Operation::SlopeRoot, slope_root, x, out)
    }

    fn on_curve(
        &mut self,
        operation: Operation,
        source: fn(Precision, u32) -> PassSource,
        x: &GpuVector,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        let (tools, steps, precision) = (&mut *self.tools, &*self.steps, self.operator.precision());
        let source = source(precision, self.operator.workgroup_size());
        let key = (operation, vec![out.number, x.number]);
        let Some(enthalpy) = steps.enthalpy() else {
            return Ok(());
        };
        tools.queue.run(self.device, key, || {
            let pass = |((content, x), out): ((&Buffer, &Buffer), &Buffer)| {
                let buffers = [steps.step_size(), &enthalpy.curve, content, x, out];
                self.device.pass(&source, &buffers, precision.values_in(out))
            };
            enthalpy.parts.iter().zip(&x.parts).zip(&out.parts).map(pass).collect()
        })
    }

    /// Multiplies each value of `out` by that of `by`; the outside gave nothing to that.
    pub(in crate::solver::gpu) fn multiply(
        &mut self,
        out: &mut GpuVector,
        by: &GpuVector,
    ) -> Result<(), GpuError> {
        self.update_given(out, 0.0, &[])?;
        let (tools, steps, precision) = (&mut *self.tools, &*self.steps, self.operator.precision());
        let key = (Operation::Multiply, vec![out.number, by.number]);
        tools.queue.run(self.device, key, || {
            let source = multiply(precision);
            let pass = |(out, by): (&Buffer, &Buffer)| {
                let buffers = [steps.step_size(), by, out];
                self.device.pass(&source, &buffers, precision.values_in(out))
            };
            out.parts.iter().zip(&by.parts).map(pass).collect()
        })
    }
}
