//! Enthalpy on the device, and the potentials that come of it.

use super::passes::enthalpy;
use crate::gpu::{Buffer, Device, GpuError, Pass};
use crate::model::HeatCurve;
use crate::solver::Precision;

/// The state of a scene with a curve, beside the potentials that the operator acts on.
#[derive(Debug)]
pub(super) struct Enthalpy {
    precision: Precision,
    workgroup_size: u32,
    /// In the parts of the state.
    pub(super) parts: Vec<Buffer>,
    /// The segments of the curve.
    pub(super) curve: Buffer,
}

impl Enthalpy {
    /// The parts of an enthalpy that follows `curve`, from what each holds at first.
    pub(super) fn new<'a>(
        device: &Device,
        precision: Precision,
        workgroup_size: u32,
        curve: &HeatCurve,
        parts: impl Iterator<Item = &'a [f64]>,
    ) -> Result<Self, GpuError> {
        let parts = parts.map(|part| {
            let contents = precision.state_to_bytes(part);
            device.storage_with("enthalpy", &contents)
        });
        let contents = precision.real().to_bytes(&table(curve));
        Ok(Self {
            precision,
            workgroup_size,
            parts: parts.collect::<Result<_, _>>()?,
            curve: device.storage_with("curve", &contents)?,
        })
    }

    /// The passes that follow a step of potentials from `before` to `after`.
    pub(super) fn passes(
        &self,
        device: &Device,
        step_size: &Buffer,
        before: &[Buffer],
        after: &[Buffer],
    ) -> Result<Vec<Pass>, GpuError> {
        let source = enthalpy(self.precision, self.workgroup_size);
        let of_part = |((content, before), after): ((&Buffer, &Buffer), &Buffer)| {
            let values = after.bytes() / self.precision.state_bytes();
            device.pass(&source, &[step_size, &self.curve, before, after, content], values)
        };
        self.parts.iter().zip(before).zip(after).map(of_part).collect()
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.parts.iter().map(Buffer::bytes).sum::<u64>() + self.curve.bytes()
    }
}

/// Two vectors for each segment: see `shaders/curve.wgsl`.
fn table(curve: &HeatCurve) -> Vec<f64> {
    let words = |number: f64| {
        let first = f64::from(number as f32);
        [first, number - first]
    };
    let segment = |segment: &crate::model::material::Segment| {
        let [start, rest] = words(segment.start);
        let [potential, of_potential] = words(segment.potential);
        [start, rest, potential, of_potential, segment.slope, segment.bend, 0.0, 0.0]
    };
    curve.segments().iter().flat_map(segment).collect()
}
