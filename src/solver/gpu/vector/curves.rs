//! Potentials and their slopes as vectors, where the state is an enthalpy.

use super::passes::multiply;
use super::queue::Operation;
use super::{GpuVector, Operations};
use crate::gpu::{Buffer, GpuError, PassSource};
use crate::solver::gpu::curve_passes::CurvePasses;

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
        let of_potential = CurvePasses::potential_change;
        self.on_curve(Operation::PotentialChange, of_potential, x, &mut potential)?;
        self.apply(&potential, 0.0, 1.0, out)?;
        self.tools.potential = Some(potential);
        self.add_change_of_seams(x, out)
    }

    /// Adds by how much what the matrix is short of changes, in the shares of the last combination.
    fn add_change_of_seams(&mut self, x: &GpuVector, out: &mut GpuVector) -> Result<(), GpuError> {
        let (tools, steps) = (&mut *self.tools, &*self.steps);
        let Some((seams, fields)) = steps.seams(&out.parts[0]) else {
            return Ok(());
        };
        let key = (Operation::SeamChange(steps.current()), vec![out.number, x.number]);
        tools.queue.run(self.device, key, || {
            let more = [&tools.combination, &out.given, &x.parts[0]];
            Ok(vec![seams.change(self.device, fields, more)?])
        })
    }

    /// The square roots of the slopes of potentials after a change `x` of the state.
    pub(in crate::solver::gpu) fn slope_root(
        &mut self,
        x: &GpuVector,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        self.on_curve(Operation::SlopeRoot, CurvePasses::slope_root, x, out)
    }

    fn on_curve(
        &mut self,
        operation: fn(usize) -> Operation,
        source: fn(CurvePasses) -> PassSource,
        x: &GpuVector,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        let (tools, steps, precision) = (&mut *self.tools, &*self.steps, self.operator.precision());
        let key = (operation(steps.current()), vec![out.number, x.number]);
        let Some(enthalpy) = steps.enthalpy() else {
            return Ok(());
        };
        tools.queue.run(self.device, key, || {
            let source = source(enthalpy.sources());
            let pass = |((content, x), out): ((&Buffer, &Buffer), &Buffer)| {
                let mut buffers = vec![steps.step_size()];
                buffers.extend(enthalpy.curve());
                buffers.extend([content, x, out]);
                self.device.pass(&source, &buffers, precision.values_in(out))
            };
            steps.content().iter().zip(&x.parts).zip(&out.parts).map(pass).collect()
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
