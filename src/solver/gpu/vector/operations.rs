//! Vectors from the state, the operator and the walls.

use super::passes::{PLACES, scatter};
use super::queue::Operation;
use super::{GpuVector, Tools, VectorScene};
use crate::gpu::{Device, GpuError};
use crate::solver::Precision;
use crate::solver::gpu::by_place;
use crate::solver::gpu::operator::{Combination, Fields, Makes, Operator};
use crate::solver::gpu::passes::{COMBINATION, NO_SLOT};
use crate::solver::gpu::steps::Steps;
use crate::solver::gpu::walls::WallSlots;

/// The parts of a backend that take part.
pub(in crate::solver::gpu) struct Operations<'a> {
    pub(super) device: &'a Device,
    pub(super) operator: &'a Operator,
    pub(super) steps: &'a mut Steps,
    pub(super) scene: &'a VectorScene,
    /// Where in the exchange each held particle's begins, and its volume.
    pub(super) held: &'a [(usize, f64)],
    pub(super) order: Option<&'a [u32]>,
    pub(super) reference_step: f64,
    pub(super) tools: &'a mut Tools,
}

impl Operations<'_> {
    /// A vector of zeros.
    pub(in crate::solver::gpu) fn vector(&mut self) -> Result<GpuVector, GpuError> {
        self.tools.vector(self.device, self.steps)
    }

    /// Writes values in the problem's order, but 0 for held particles.
    pub(in crate::solver::gpu) fn load(
        &mut self,
        values: &[f64],
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        let mut by_place = by_place(self.order, values, 0.0).into_owned();
        let held = self.scene.exceptions.iter().filter(|exception| exception[2] != NO_SLOT);
        held.for_each(|exception| by_place[exception[0] as usize] = 0.0);
        let parts = self.operator.parts(by_place.len());
        for (part, places) in out.parts.iter().zip(parts) {
            self.device.write(part, &self.precision().state_to_bytes(&by_place[places]))?;
        }
        self.device.write(&out.given, &vec![0; out.given.bytes() as usize])
    }

    /// The rate of the state at `time` (s).
    pub(in crate::solver::gpu) fn rate(
        &mut self,
        time: f64,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        if let Some(walls) = self.steps.walls() {
            walls.prepare(self.device, time, 0.0, 1)?;
        }
        self.write_factors(0.0, 1.0 / self.reference_step)?;
        let (tools, steps) = (&mut *self.tools, &*self.steps);
        let key = (Operation::Rate(steps.current()), vec![out.number]);
        tools.queue.run(self.device, key, || {
            let fields = Fields {
                from: steps.state(),
                to: &out.parts,
                exchange: steps.exchange(),
                walls: steps.walls().map(WallSlots::buffers),
                step_size: steps.step_size(),
                combination: Some(Combination {
                    factors: &tools.combination,
                    given_before: &tools.nothing_given,
                    given: &out.given,
                    exception: &tools.exception,
                }),
                heat: None,
            };
            let mut passes = self.operator.passes(self.device, Makes::Combination, &fields)?;
            if let Some((seams, fields)) = steps.seams(&out.parts[0]) {
                let more = [&tools.combination, &out.given];
                passes.push(seams.combine(self.device, fields, more)?);
            }
            Ok(passes)
        })
    }

    /// `share` x + `scale` A x.
    pub(in crate::solver::gpu) fn apply(
        &mut self,
        x: &GpuVector,
        share: f64,
        scale: f64,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        self.write_factors(share, scale / self.reference_step)?;
        let (tools, steps) = (&mut *self.tools, &*self.steps);
        let key = (Operation::Apply, vec![out.number, x.number]);
        tools.queue.run(self.device, key, || {
            let walls = steps.walls().zip(tools.no_source.as_ref());
            let fields = Fields {
                from: &x.parts,
                to: &out.parts,
                exchange: tools.nothing_held.as_ref().or(steps.exchange()),
                walls: walls.map(|(walls, none)| [&walls.wall, none]),
                step_size: steps.step_size(),
                combination: Some(Combination {
                    factors: &tools.combination,
                    given_before: &x.given,
                    given: &out.given,
                    exception: &tools.exception,
                }),
                heat: None,
            };
            self.operator.passes(self.device, Makes::Combination, &fields)
        })
    }

    /// What the source gains between two times (s).
    pub(in crate::solver::gpu) fn source_change(
        &mut self,
        from: f64,
        to: f64,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        self.update(out, 0.0, &[])?;
        let Some(walls) = self.steps.walls() else {
            return Ok(());
        };
        let precision = self.precision();
        let change = walls.source_change(from, to);
        let mut given = vec![0.0; self.held.len()];
        given.extend(&change);
        self.device.write(&out.given, &precision.state_to_bytes(&given))?;
        self.device.write(&self.tools.source, &precision.real().to_bytes(&change))?;
        let (tools, steps) = (&mut *self.tools, &*self.steps);
        let key = (Operation::Scatter, vec![out.number]);
        tools.queue.run(self.device, key, || {
            let mut passes = Vec::new();
            let (mut first_place, mut first) = (0, 0);
            for part in &out.parts {
                let end_place = first_place + precision.values_in(part) as u32;
                let end = self.scene.exceptions.partition_point(|e| e[0] < end_place);
                let places = [first_place, first as u32, end as u32];
                let places = PLACES.contents(precision.real(), places, []);
                let places = self.device.block("places", &places)?;
                let buffers = [steps.step_size(), &places, &tools.exception, &tools.source, part];
                let threads = (end - first) as u64;
                passes.push(self.device.pass(&scatter(precision), &buffers, threads)?);
                (first_place, first) = (end_place, end);
            }
            Ok(passes)
        })
    }

    pub(super) fn precision(&self) -> Precision {
        self.operator.precision()
    }

    /// Writes the shares of the next combination.
    pub(super) fn write_factors(&self, share: f64, scale: f64) -> Result<(), GpuError> {
        let held = [self.held.len() as u32];
        let contents = COMBINATION.contents(self.precision().real(), held, [share, scale]);
        self.device.write(&self.tools.combination, &contents)
    }
}
