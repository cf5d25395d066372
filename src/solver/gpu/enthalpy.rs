//! Enthalpy on the device, and the potentials that come of it.

use super::curve_passes::CurvePasses;
use super::fronts::DeviceFronts;
use crate::gpu::{Buffer, Device, GpuError, Pass};
use crate::model::material::Segment;
use crate::model::{Conductivity, HeatCurve, Material, Problem};
use crate::solver::Precision;
use crate::solver::precision::two_words;

/// The curves that enthalpies follow.
#[derive(Debug)]
pub(super) enum Curves {
    /// All follow this one.
    One(HeatCurve),
    /// By place: which of the curves of materials.
    Each { of: Vec<u32>, curves: Vec<HeatCurve> },
}

impl Curves {
    /// Those of `problem`, with a particle `order[k]` in place k; `None` where states are no enthalpies.
    pub(super) fn of(problem: &Problem, order: Option<&[u32]>) -> Option<Self> {
        if !problem.has_curves() {
            return None;
        }
        if problem.has_one_curve() {
            return problem.curve(0).cloned().map(Self::One);
        }
        // What neither melts nor changes has a straight curve.
        let curve = |material: &Material| match &material.curve {
            Some(curve) => HeatCurve::clone(curve),
            None => {
                let conductivity = Conductivity::constant(material.conductivity);
                HeatCurve::new(&conductivity, material.capacity, None)
            }
        };
        let material: Vec<u32> = problem.particles.material.iter().map(|&m| m.into()).collect();
        let of = super::by_place(order, &material, 0).into_owned();
        Some(Self::Each { of, curves: problem.materials.iter().map(curve).collect() })
    }

    /// The potential of an enthalpy (K) in a place, K.
    fn potential(&self, place: usize, enthalpy: f64) -> f64 {
        match self {
            Self::One(curve) => curve.potential(enthalpy),
            Self::Each { of, curves } => curves[of[place] as usize].potential(enthalpy),
        }
    }

    /// Potentials of enthalpies by place, K.
    pub(super) fn potentials(&self, enthalpies: &[f64]) -> Vec<f64> {
        let of = |(place, &enthalpy): (usize, &f64)| self.potential(place, enthalpy);
        enthalpies.iter().enumerate().map(of).collect()
    }

    /// The curves, one after the other.
    pub(super) fn list(&self) -> &[HeatCurve] {
        match self {
            Self::One(curve) => std::slice::from_ref(curve),
            Self::Each { curves, .. } => curves,
        }
    }

    /// The conductivity that those on the device are relative to, W/(m K).
    pub(super) fn largest_reference(&self) -> f64 {
        self.list().iter().map(HeatCurve::reference).fold(0.0, f64::max)
    }
}

/// The state of a scene with curves, beside the potentials that the operator acts on.
#[derive(Debug)]
pub(super) struct Enthalpy {
    passes: CurvePasses,
    /// In the parts of the state.
    pub(super) parts: Vec<Buffer>,
    /// The segments of the curves; where places have different ones, which each has and where these begin.
    curve: Vec<Buffer>,
}

impl Enthalpy {
    /// The parts of an enthalpy that follows `curves`, from what each holds at first. Only a state in one part
    /// may have several curves.
    pub(super) fn new<'a>(
        device: &Device,
        precision: Precision,
        workgroup_size: u32,
        curves: &Curves,
        parts: impl Iterator<Item = &'a [f64]>,
    ) -> Result<Self, GpuError> {
        let parts = parts.map(|part| {
            let contents = precision.state_to_bytes(part);
            device.storage_with("enthalpy", &contents)
        });
        let contents = precision.real().to_bytes(&table(curves));
        let mut curve = vec![device.storage_with("curve", &contents)?];
        if let Curves::Each { of, curves } = curves {
            let mut start = vec![0];
            for curve in curves {
                start.push(start[start.len() - 1] + curve.segments().len() as u32);
            }
            curve.push(device.storage_with("curves of places", bytemuck::cast_slice(of))?);
            curve.push(device.storage_with("starts of curves", bytemuck::cast_slice(&start))?);
        }
        let each = matches!(curves, Curves::Each { .. });
        Ok(Self {
            passes: CurvePasses { precision, workgroup_size, each },
            parts: parts.collect::<Result<_, _>>()?,
            curve,
        })
    }

    /// The passes that there are on its curves.
    pub(super) fn sources(&self) -> CurvePasses {
        self.passes
    }

    /// The buffers of its curves, in the order of their bindings.
    pub(super) fn curve(&self) -> &[Buffer] {
        &self.curve
    }

    /// The passes that follow a step of potentials from `before` to `after`; they list what melts for `fronts`.
    pub(super) fn passes(
        &self,
        device: &Device,
        step_size: &Buffer,
        before: &[Buffer],
        after: &[Buffer],
        fronts: Option<&DeviceFronts>,
    ) -> Result<Vec<Pass>, GpuError> {
        let noted = fronts.and_then(DeviceFronts::noted);
        let source = match noted {
            Some(_) => self.passes.noted_enthalpy(),
            None => self.passes.enthalpy(),
        };
        let of_part = |((content, before), after): ((&Buffer, &Buffer), &Buffer)| {
            let mut buffers = vec![step_size];
            buffers.extend(&self.curve);
            buffers.extend([before, after, content]);
            buffers.extend(noted.into_iter().flatten());
            device.pass(&source, &buffers, after.bytes() / self.passes.precision.state_bytes())
        };
        self.parts.iter().zip(before).zip(after).map(of_part).collect()
    }

    /// The pass that lists what melts, where there are lists.
    pub(super) fn find_fronts(
        &self,
        device: &Device,
        step_size: &Buffer,
        fronts: &DeviceFronts,
    ) -> Result<Option<Pass>, GpuError> {
        let (Some([tiles, table, melting]), [content]) = (fronts.noted(), &self.parts[..]) else {
            return Ok(None);
        };
        let mut buffers = vec![step_size, content, tiles, table];
        buffers.extend(self.curve.get(1).filter(|_| fronts.each));
        buffers.push(melting);
        let count = content.bytes() / self.passes.precision.state_bytes();
        device.pass(&self.passes.find_fronts(), &buffers, count).map(Some)
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.parts.iter().chain(&self.curve).map(Buffer::bytes).sum()
    }
}

/// Two vectors for each segment: see `shaders/curve/segments.wgsl`.
fn table(curves: &Curves) -> Vec<f64> {
    let scale = 1.0 / curves.largest_reference();
    let segments = |curve: &HeatCurve| {
        let of = |segment: &Segment| {
            let [start, rest] = two_words(segment.start);
            let [potential, of_potential] = two_words(segment.potential);
            let [conductivity, rise] = curve.conductivity_of(segment).map(|k| scale * k);
            let Segment { slope, bend, .. } = *segment;
            [start, rest, potential, of_potential, slope, bend, conductivity, rise]
        };
        curve.segments().iter().flat_map(of).collect::<Vec<f64>>()
    };
    curves.list().iter().flat_map(segments).collect()
}
