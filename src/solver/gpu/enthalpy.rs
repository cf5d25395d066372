//! Enthalpy on the device, and the potentials that come of it.

use super::curve_passes::{CurveKind, CurvePasses};
use super::fronts::{DeviceFronts, FrontMakes, Listed};
use super::phases::Told;
use crate::gpu::{Buffer, Device, GpuError, Pass, PassSource};
use crate::model::material::Segment;
use crate::model::{Conductivity, HeatCurve, Material, Problem};
use crate::solver::Precision;

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
        // Where there is no particle, there is what the first is of: its enthalpy is there too.
        let of = super::by_place(order, &material, material[0]).into_owned();
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
    fn potentials(&self, enthalpies: &[f64]) -> Vec<f64> {
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
    /// A step reads one and writes the other, in the parts of the state: of what melts alone where there are phases.
    parts: [Vec<Buffer>; 2],
    /// The segments of the curves; where places have different ones, which each has and where these begin.
    curve: Vec<Buffer>,
    /// Where potentials tell enthalpies.
    told: Option<Told>,
    /// What they tell of each material, where there are several.
    phase_table: Option<Buffer>,
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
        let filled = parts
            .map(|part| device.storage_with("enthalpy", &precision.state_to_bytes(part)))
            .collect::<Result<Vec<_>, _>>()?;
        let empty = filled.iter().map(|part| device.storage("enthalpy", part.bytes()));
        let empty = empty.collect::<Result<_, _>>()?;
        let contents = precision.real().to_bytes(&table(curves, precision));
        let mut curve = vec![device.storage_with("curve", &contents)?];
        if let Curves::Each { of, curves } = curves {
            let mut start = vec![0];
            for curve in curves {
                start.push(start[start.len() - 1] + curve.segments().len() as u32);
            }
            curve.push(device.storage_with("curves of places", bytemuck::cast_slice(of))?);
            curve.push(device.storage_with("starts of curves", bytemuck::cast_slice(&start))?);
        }
        let told = Told::of(curves, precision);
        let kind = match (&told, curves) {
            (Some(told), _) => told.kind(),
            (None, Curves::One(_)) => CurveKind::One,
            (None, Curves::Each { .. }) => CurveKind::Each,
        };
        let phase_table = told.as_ref().and_then(Told::table).map(|table| {
            device.storage_with("phases of materials", &precision.real().to_bytes(&table))
        });
        let passes = CurvePasses { precision, workgroup_size, kind };
        let phase_table = phase_table.transpose()?;
        Ok(Self { passes, parts: [filled, empty], curve, told, phase_table })
    }

    /// The potentials of `enthalpies`, which follow `curves`, by place, K.
    pub(super) fn potentials(&self, curves: &Curves, enthalpies: &[f64]) -> Vec<f64> {
        match &self.told {
            Some(told) => told.potentials(&self.passes.precision.on_device(enthalpies)),
            None => curves.potentials(enthalpies),
        }
    }

    /// What potentials tell.
    pub(super) fn told(&self) -> Option<&Told> {
        self.told.as_ref()
    }

    /// What they tell of each material, where there are several.
    pub(super) fn phase_table(&self) -> Option<&Buffer> {
        self.phase_table.as_ref()
    }

    /// The passes that there are on its curves.
    pub(super) fn sources(&self) -> CurvePasses {
        self.passes
    }

    /// The buffers of its curves, in the order of their bindings.
    pub(super) fn curve(&self) -> &[Buffer] {
        &self.curve
    }

    /// The parts in place `at` of the two.
    pub(super) fn parts(&self, at: usize) -> &[Buffer] {
        &self.parts[at]
    }

    /// The passes that add the parts of `change` to the enthalpies in place `from`: these go to the other place,
    /// and the potentials that come of them to `after`.
    pub(super) fn add(
        &self,
        device: &Device,
        step_size: &Buffer,
        from: usize,
        change: &[Buffer],
        after: &[Buffer],
    ) -> Result<Vec<Pass>, GpuError> {
        let source = self.passes.enthalpy_add();
        let of_part = |k: usize| {
            let mut buffers = vec![step_size];
            buffers.extend(&self.curve);
            buffers.extend([&self.parts[from][k], &change[k]]);
            buffers.extend([&self.parts[1 - from][k], &after[k]]);
            device.pass(&source, &buffers, self.passes.precision.values_in(&after[k]))
        };
        (0..after.len()).map(of_part).collect()
    }

    /// The pass that lists what melts of the enthalpies in place `from`, where there are lists.
    pub(super) fn find_fronts(
        &self,
        device: &Device,
        step_size: &Buffer,
        from: usize,
        fronts: &DeviceFronts,
    ) -> Result<Option<Pass>, GpuError> {
        let noted = fronts.noted_in(Listed::Melting, from);
        let (Some(noted), [content]) = (noted, self.parts(from)) else {
            return Ok(None);
        };
        let mut buffers = vec![step_size];
        buffers.extend(&self.curve);
        buffers.push(content);
        buffers.extend(noted);
        device
            .pass(&self.passes.find_fronts(), &buffers, self.passes.precision.values_in(content))
            .map(Some)
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.parts
            .iter()
            .flatten()
            .chain(&self.curve)
            .chain(&self.phase_table)
            .map(Buffer::bytes)
            .sum()
    }
}

/// What the passes of a step read and write beside potentials, where these come of enthalpies.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeatFields<'a> {
    pub(super) enthalpy: &'a Enthalpy,
    /// In which of its two places the step finds it.
    pub(super) from: usize,
    /// Where something melts at one temperature.
    pub(super) fronts: Option<&'a DeviceFronts>,
}

impl<'a> HeatFields<'a> {
    /// Makes a pass over all places of a step one of enthalpies.
    pub(super) fn end_step(&self, source: &mut PassSource) {
        self.enthalpy.passes.end_step(source, self.noted_in(Listed::Near).is_some());
    }

    /// The buffers of such a pass on part `k` of the state, after those of a step of potentials.
    pub(super) fn of_step(&self, k: usize) -> Vec<&'a Buffer> {
        let mut buffers = vec![&self.enthalpy.parts[self.from][k]];
        buffers.extend(self.of_end(k, Listed::Near));
        buffers
    }

    /// The buffers of a pass of `fronts` on part `k` of the state, likewise; `beside` are the parts that its stencils
    /// reach, where the state is in parts.
    pub(super) fn of_front(
        &self,
        fronts: &'a DeviceFronts,
        makes: FrontMakes,
        k: usize,
        is_through_list: bool,
        beside: Option<[usize; 2]>,
    ) -> Vec<&'a Buffer> {
        let contents = [k].into_iter().chain(beside.into_iter().flatten());
        let mut buffers: Vec<&Buffer> =
            contents.map(|part| &self.enthalpy.parts[self.from][part]).collect();
        let curve_of = self.enthalpy.curve.get(1);
        buffers.extend(fronts.buffers(makes, k, self.from, is_through_list, curve_of));
        if makes == FrontMakes::Flows {
            buffers.extend(self.of_end(k, Listed::Melting));
        }
        buffers
    }

    /// The buffers that the end of a pass of a step has, in the order of its bindings: see `CurvePasses::end`.
    fn of_end(&self, k: usize, list: Listed) -> Vec<&'a Buffer> {
        let Enthalpy { parts, curve, told, phase_table, .. } = self.enthalpy;
        let mut buffers = vec![&parts[1 - self.from][k]];
        match (told, phase_table) {
            (None, _) => buffers.extend(curve),
            (Some(_), None) => {}
            (Some(_), Some(phases)) => buffers.extend([phases, &curve[1]]),
        }
        buffers.extend(self.noted_in(list).into_iter().flatten());
        buffers
    }

    /// The buffers of what puts tiles on a list, where there are lists.
    pub(super) fn noted_in(&self, list: Listed) -> Option<[&'a Buffer; 2]> {
        let of_step = match list {
            Listed::Near => self.from,
            // The next one lists the neighbours of what melts after this.
            Listed::Melting => 1 - self.from,
        };
        self.fronts.and_then(|fronts| fronts.noted_in(list, of_step))
    }
}

/// Two vectors for each segment: see `shaders/curve/segments.wgsl`.
fn table(curves: &Curves, precision: Precision) -> Vec<f64> {
    let scale = 1.0 / curves.largest_reference();
    let segments = |curve: &HeatCurve| {
        let of = |segment: &Segment| {
            let [start, rest] = precision.in_words(segment.start);
            let [potential, of_potential] = precision.in_words(segment.potential);
            let [conductivity, rise] = curve.conductivity_of(segment).map(|k| scale * k);
            let Segment { slope, bend, .. } = *segment;
            [start, rest, potential, of_potential, slope, bend, conductivity, rise]
        };
        curve.segments().iter().flat_map(of).collect::<Vec<f64>>()
    };
    curves.list().iter().flat_map(segments).collect()
}
