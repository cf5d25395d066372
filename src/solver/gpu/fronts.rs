//! What fronts change of the flows of a step, on the device.
//!
//! Little melts, and flows change only there and beside it. So places are in tiles of [`TILE`] that follow each
//! other, and a step goes through lists of tiles, whose lengths only the device knows: after a step those where
//! anything melts are listed, in the next those of these and of their neighbours, and there flows are looked for.
//! The lists are in any order, but each place sums up its own flows, so that results do not depend on it. A state in
//! parts has no lists: flows are looked for everywhere.

use std::ops::Range;

use super::curve_passes::CurvePasses;
use super::enthalpy::Enthalpy;
use super::passes::{NO_SLOT, SPLIT, STEP_SIZE, WHOLE, arithmetic, block, read, value, write};
use crate::gpu::{Binding, Buffer, Constant, Device, Element, GpuError, Pass, PassSource};
use crate::model::Problem;
use crate::model::operator::Fronts;
use crate::solver::Precision;
use crate::solver::precision::two_words;

/// Places of a tile. A word of it has a bit for each, set where more than the stencil of a lattice acts, and one for
/// each list that it may be in.
pub const TILE: usize = 4;

/// Most workgroups along an axis of a dispatch that every device can do.
const MOST_WORKGROUPS: u32 = 65_535;

/// The lists of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Listed {
    /// Those where anything melts.
    Melting,
    /// These, and those of the neighbours of what melts.
    Near,
}

impl Listed {
    /// The bit of the tiles that are in it.
    fn bit(self) -> Constant {
        let number = match self {
            Self::Melting => TILE,
            Self::Near => TILE + 1,
        };
        Constant::Count(1 << number)
    }
}

/// What a pass of fronts makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrontMakes {
    /// The list of the tiles where flows may change.
    Near,
    /// The flows of what melts and of what is near.
    Flows,
}

impl FrontMakes {
    /// The passes of a step, in order.
    pub(super) fn of(is_split: bool) -> &'static [Self] {
        if is_split { &[Self::Flows] } else { &[Self::Near, Self::Flows] }
    }

    /// Makes the pass `source` of a step one of this: sums find flows or neighbours where they would find the state.
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
        source.bindings.extend(of_fronts(each));
        let mut slots = vec![
            "front/melting",
            if each { "front/each" } else { "front/one" },
            if is_split { "front/split" } else { "front/whole" },
        ];
        source.constants.push(("TILE", Constant::Count(TILE as u32)));
        if is_split {
            slots.extend(["front/everywhere", "front/near_all"]);
        } else {
            source.bindings.push(read("listed", Element::U32));
            let listed = match self {
                Self::Near => Listed::Melting,
                Self::Flows => Listed::Near,
            };
            source.constants.push(("LISTED", listed.bit()));
            slots.extend(["front/listed", "front/near_listed"]);
        }
        if self == Self::Near {
            source.bindings.push(write("appended", Element::AtomicU32));
            source.constants.push(("APPENDED", Listed::Near.bit()));
            slots.push("front/append");
        }
        source.slots.extend(slots.into_iter().map(str::to_owned));
        let found = match self {
            Self::Near => "front/marking",
            Self::Flows => "front/flowing",
        };
        for slot in source.slots.iter_mut().filter(|slot| [WHOLE, SPLIT].contains(&&***slot)) {
            *slot = found.to_owned();
        }
    }
}

/// The tiles, and where each material melts.
fn of_fronts(each: bool) -> impl Iterator<Item = Binding> {
    let all = [write("tiles", Element::AtomicU32), read("fronts", Element::Real4)];
    all.into_iter().chain(each.then_some(read("curve_of", Element::U32)))
}

impl CurvePasses {
    /// The pass of enthalpies, which lists what melts after it.
    pub fn noted_enthalpy(self) -> PassSource {
        let mut source = self.enthalpy();
        source.slots.retain(|slot| slot != NOT_NOTED);
        self.note(&mut source, false);
        source
    }

    /// Lists what melts.
    pub fn find_fronts(self) -> PassSource {
        let mut source = PassSource {
            pass: "front_find",
            real: self.precision.real(),
            workgroup_size: self.workgroup_size,
            constants: vec![],
            bindings: vec![block("step_size", &STEP_SIZE), read("content", value(self.precision))],
            slots: arithmetic(self.precision).map(str::to_owned).into(),
            generated: String::new(),
        };
        self.note(&mut source, self.each);
        source
    }

    fn note(self, source: &mut PassSource, each: bool) {
        source.bindings.extend(of_fronts(each));
        source.bindings.push(write("appended", Element::AtomicU32));
        source.constants.push(("TILE", Constant::Count(TILE as u32)));
        source.constants.push(("APPENDED", Listed::Melting.bit()));
        let of_place = if self.each { "front/each" } else { "front/one" };
        let slots = ["front/melting", of_place, "front/append", "front/noted"];
        source.slots.extend(slots.map(str::to_owned));
    }

    /// How many workgroups of other passes go through a list.
    pub fn front_size(self) -> PassSource {
        PassSource {
            pass: "front_size",
            real: self.precision.real(),
            workgroup_size: self.workgroup_size,
            constants: vec![
                ("TILE", Constant::Count(TILE as u32)),
                ("MOST_WORKGROUPS", Constant::Count(MOST_WORKGROUPS)),
                ("NO_SLOT", Constant::Count(NO_SLOT)),
            ],
            bindings: vec![
                read("listed", Element::U32),
                write("emptied", Element::U32),
                write("size", Element::U32),
            ],
            slots: vec![],
            generated: String::new(),
        }
    }
}

/// The slot of passes on enthalpies that list nothing.
pub(super) const NOT_NOTED: &str = "front/not_noted";

/// Where what melts is, on the device.
#[derive(Debug)]
pub(super) struct DeviceFronts {
    /// A word of each tile, in the parts of the state.
    tiles: Vec<Buffer>,
    /// Two vectors for each material: see `shaders/front/melting.wgsl`.
    table: Buffer,
    /// Only of a state in one part.
    lists: Option<Lists>,
    /// Whether places melt as their material does, or all alike.
    pub(super) each: bool,
}

/// The lists of tiles, which begin with how many are in it, and the workgroups that go through each.
#[derive(Debug)]
struct Lists {
    melting: Buffer,
    near: Buffer,
    of_melting: Buffer,
    of_near: Buffer,
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
            let mut tiles = vec![0_u32; part.len().div_ceil(TILE)];
            for &place in exceptions.iter().filter(|&&place| part.contains(&(place as usize))) {
                let local = place as usize - part.start;
                tiles[local / TILE] |= 1 << (local % TILE);
            }
            device.storage_with("tiles of fronts", bytemuck::cast_slice(&tiles))
        };
        let lists = match parts {
            [part] => Some(Lists::new(device, part.len().div_ceil(TILE))?),
            _ => None,
        };
        Ok(Some(Self {
            tiles: parts.iter().map(of_part).collect::<Result<_, _>>()?,
            table: device.storage_with("fronts", &precision.real().to_bytes(&table))?,
            lists,
            each,
        }))
    }

    /// The pass that comes before those that make something: it counts their workgroups; `None` without lists.
    pub(super) fn size(
        &self,
        device: &Device,
        passes: CurvePasses,
        makes: FrontMakes,
    ) -> Result<Option<Pass>, GpuError> {
        let Some(lists) = &self.lists else {
            return Ok(None);
        };
        let Lists { melting, near, of_melting, of_near } = lists;
        // A list that was gone through is empty after it.
        let buffers = match makes {
            FrontMakes::Near => [melting, near, of_melting],
            FrontMakes::Flows => [near, melting, of_near],
        };
        device.pass(&passes.front_size(), &buffers, 1).map(Some)
    }

    /// The workgroups of a pass that goes through a list; `None` without lists.
    pub(super) fn workgroups(&self, makes: FrontMakes) -> Option<&Buffer> {
        self.lists.as_ref().map(|lists| match makes {
            FrontMakes::Near => &lists.of_melting,
            FrontMakes::Flows => &lists.of_near,
        })
    }

    /// The buffers of a pass that lists what melts, after its own; `None` without lists.
    pub(super) fn noted(&self) -> Option<[&Buffer; 3]> {
        let lists = self.lists.as_ref()?;
        Some([&self.tiles[0], &self.table, &lists.melting])
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let lists = self
            .lists
            .iter()
            .flat_map(|lists| [&lists.melting, &lists.near, &lists.of_melting, &lists.of_near]);
        self.tiles.iter().chain([&self.table]).chain(lists).map(Buffer::bytes).sum()
    }
}

impl Lists {
    fn new(device: &Device, tiles: usize) -> Result<Self, GpuError> {
        let list = |name| device.storage(name, 4 * (1 + tiles as u64));
        let workgroups = || device.workgroups("workgroups of fronts");
        Ok(Self {
            melting: list("tiles that melt")?,
            near: list("tiles near what melts")?,
            of_melting: workgroups()?,
            of_near: workgroups()?,
        })
    }
}

impl<'a> FrontFields<'a> {
    /// The buffers of a pass on part `k` of the state, after those of a step; `beside` are the parts that its
    /// stencils reach, where the state is in parts.
    pub(super) fn buffers(
        &self,
        makes: FrontMakes,
        k: usize,
        beside: Option<[usize; 2]>,
    ) -> impl Iterator<Item = &'a Buffer> {
        let Self { fronts, enthalpy } = *self;
        let contents = [k].into_iter().chain(beside.into_iter().flatten());
        let contents = contents.map(|part| &enthalpy.parts[part]);
        let curve_of = enthalpy.curve().get(1).filter(|_| fronts.each);
        let lists = fronts.lists.iter().flat_map(move |lists| match makes {
            FrontMakes::Near => vec![&lists.melting, &lists.near],
            FrontMakes::Flows => vec![&lists.near],
        });
        contents.chain([&fronts.tiles[k], &fronts.table]).chain(curve_of).chain(lists)
    }
}
