//! What fronts change of the flows of a step, on the device.

use std::ops::Range;

use super::enthalpy::Enthalpy;
use super::passes::{SPLIT, WHOLE, read, value, write};
use crate::gpu::{Buffer, Constant, Device, Element, GpuError, PassSource};
use crate::model::Problem;
use crate::model::operator::Fronts;
use crate::solver::Precision;
use crate::solver::precision::two_words;

/// The bit of a place that has a neighbour that melts.
const MARKED: u32 = 1;

/// The bit of a site of a lattice where more than the stencil acts.
const EXCEPTION: u32 = 2;

/// What a pass of fronts makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrontMakes {
    /// Marks at the neighbours of what melts.
    Marks,
    /// The flows of what melts and of what is marked.
    Flows,
}

impl FrontMakes {
    /// The passes of a step, in order. In a state in parts nothing is marked: flows are looked for everywhere.
    pub(super) fn of(is_split: bool) -> &'static [Self] {
        if is_split { &[Self::Flows] } else { &[Self::Marks, Self::Flows] }
    }

    /// Makes the pass `source` of a step one of this: sums find flows or marks where they would find the state.
    pub(super) fn add_to(
        self,
        source: &mut PassSource,
        precision: Precision,
        each: bool,
        is_split: bool,
    ) {
        let contents: &[&str] = match is_split {
            true => &["content", "content_below", "content_above"],
            false => &["content"],
        };
        source.bindings.extend(contents.iter().map(|&name| read(name, value(precision))));
        source.bindings.push(write("near", Element::AtomicU32));
        source.bindings.push(read("fronts", Element::Real4));
        if each {
            source.bindings.push(read("curve_of", Element::U32));
        }
        source.constants.push(("MARKED", Constant::Count(MARKED)));
        source.constants.push(("EXCEPTION", Constant::Count(EXCEPTION)));
        let slots = [
            "front/melting",
            if each { "front/each" } else { "front/one" },
            if is_split { "front/split" } else { "front/whole" },
        ];
        source.slots.extend(slots.map(str::to_owned));
        let found = match self {
            Self::Marks => "front/marking",
            Self::Flows => "front/flowing",
        };
        for slot in source.slots.iter_mut().filter(|slot| [WHOLE, SPLIT].contains(&&***slot)) {
            *slot = found.to_owned();
        }
    }
}

/// Where what melts is, on the device.
#[derive(Debug)]
pub(super) struct DeviceFronts {
    /// Bits of each place, in the parts of the state.
    near: Vec<Buffer>,
    /// Two vectors for each material: see `shaders/front/melting.wgsl`.
    table: Buffer,
    /// Whether places melt as their material does, or all alike.
    pub(super) each: bool,
}

/// What passes of fronts read and write beside those of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrontFields<'a> {
    pub(super) fronts: &'a DeviceFronts,
    /// The state.
    pub(super) enthalpy: &'a Enthalpy,
}

impl DeviceFronts {
    /// Those of `problem`, whose state is in `parts` and has more than a stencil at the places `exceptions`; `None`
    /// where nothing melts at one temperature.
    pub(super) fn new(
        device: &Device,
        problem: &Problem,
        precision: Precision,
        parts: &[Range<usize>],
        exceptions: &[u32],
    ) -> Result<Option<Self>, GpuError> {
        let Some(fronts) = Fronts::of(problem) else {
            return Ok(None);
        };
        let each = !problem.has_one_curve();
        let materials = problem.materials.len() as u16;
        let materials = match each {
            true => 0..materials,
            false => problem.particles.material[0]..problem.particles.material[0] + 1,
        };
        let of_material = |material: u16| {
            let Some(front) = fronts.of_material(material) else {
                return [1.0, 0.0, 0.0, 0.0, fronts.distance(), 0.0, 0.0, 0.0];
            };
            let [potential, rest] = two_words(front.potential);
            [front.begins, front.ends, potential, rest, fronts.distance(), 0.0, 0.0, 0.0]
        };
        let table: Vec<f64> = materials.flat_map(of_material).collect();
        let of_part = |part: &Range<usize>| {
            let mut bits = vec![0; part.len()];
            for &place in exceptions.iter().filter(|&&place| part.contains(&(place as usize))) {
                bits[place as usize - part.start] = EXCEPTION;
            }
            device.storage_with("marks of fronts", bytemuck::cast_slice(&bits))
        };
        Ok(Some(Self {
            near: parts.iter().map(of_part).collect::<Result<_, _>>()?,
            table: device.storage_with("fronts", &precision.real().to_bytes(&table))?,
            each,
        }))
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.near.iter().chain([&self.table]).map(Buffer::bytes).sum()
    }
}

impl<'a> FrontFields<'a> {
    /// The buffers of a pass on part `k` of the state, after those of a step; `beside` are the parts that its
    /// stencils reach, where the state is in parts.
    pub(super) fn buffers(
        &self,
        k: usize,
        beside: Option<[usize; 2]>,
    ) -> impl Iterator<Item = &'a Buffer> {
        let contents = [k].into_iter().chain(beside.into_iter().flatten());
        let enthalpy = self.enthalpy;
        let contents = contents.map(|part| &enthalpy.parts[part]);
        let curve_of = enthalpy.curve().get(1).filter(|_| self.fronts.each);
        contents.chain([&self.fronts.near[k], &self.fronts.table]).chain(curve_of)
    }
}
