//! What fronts change of the flows of a step, on the device.
//!
//! Little melts, and flows change only there and beside it. So places are in tiles of [`TILE`] that follow each
//! other, and a step goes through lists of tiles, whose lengths only the device knows: before it through those where
//! anything melts, to list these and those of their neighbours. The step lists those too where anything melts after
//! it, or ends to, and so does what is added to it where materials meet, if that comes before. Then flows are looked
//! for in all of these, and what melts is listed for the next step. Of each list there are two, for steps in turn: who goes
//! through this step's list of what melts empties the next step's list of what is near, which the step before went through,
//! and who goes through this step's list of what is near empties that of what melts, which the next step fills again.
//! The lists are in any order, but each place sums up its own flows, so that results do not depend on it. A state in
//! parts has no lists: flows are looked for everywhere.

use std::ops::Range;

use super::curve_passes::CurvePasses;
use super::passes::{SPLIT, STATE_END, WHOLE, read, value, write};
use super::phases::NEVER;
use crate::gpu::{Buffer, Constant, Device, Element, GpuError, Pass, PassSource};
use crate::model::Problem;
use crate::model::operator::Fronts;
use crate::solver::Precision;
use crate::solver::precision::two_words;

/// Places of a tile. A word of it has a bit for each, set where more than the stencil of a lattice acts, and one for
/// each list that it may be in. Of larger tiles more places would be gone through beside a front that crosses them, of
/// smaller ones there would be more to list.
pub const TILE: usize = 2;

/// Most workgroups along an axis of a dispatch that every device can do.
const MOST_WORKGROUPS: u32 = 65_535;

/// What an empty list begins with: the workgroups that go through it, along x, y and z, and its length.
const EMPTY: [u32; 4] = [1, 1, 1, 0];

/// The lists of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Listed {
    /// Those where anything melts.
    Melting,
    /// These, those of the neighbours of what melts, and those where anything melts after a step, or ends to.
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
    /// Both, in order.
    pub(super) const ALL: [Self; 2] = [Self::Near, Self::Flows];

    /// Those of a state, in order.
    pub(super) fn of(is_split: bool) -> &'static [Self] {
        if is_split { &[Self::Flows] } else { &Self::ALL }
    }

    /// The list that is gone through.
    fn listed(self) -> Listed {
        match self {
            Self::Near => Listed::Melting,
            Self::Flows => Listed::Near,
        }
    }

    /// Makes the pass `source` of a step one of this: sums find flows or neighbours where they would find the state. It goes
    /// through a list, or leaves out what is in none.
    pub(super) fn add_to(
        self,
        source: &mut PassSource,
        curves: CurvePasses,
        is_split: bool,
        is_through_list: bool,
    ) {
        let contents: &[&str] = match is_split {
            true => &["content", "content_below", "content_above"],
            false => &["content"],
        };
        source.bindings.extend(contents.iter().map(|&name| read(name, value(curves.precision))));
        source.bindings.push(read("fronts", Element::Real4));
        let mut slots = vec![
            "front/melting",
            if curves.kind.is_each() { "front/each" } else { "front/one" },
            if curves.kind.is_told() { "front/told" } else { "front/content" },
            if is_split { "front/split" } else { "front/whole" },
        ];
        if is_split {
            tiles_to(source);
            slots.extend(["front/everywhere", "front/near_all"]);
        } else {
            source.constants.push(("LISTED", self.listed().bit()));
            if is_through_list {
                let lists = [read("listed", Element::U32), write("emptied", Element::U32)];
                source.bindings.extend(lists);
                slots.push("front/listed");
            } else {
                slots.push("front/near_listed");
            }
        }
        source.slots.retain(|slot| slot != STATE_END);
        source.slots.extend(slots.into_iter().map(str::to_owned));
        let found = match self {
            Self::Near => {
                let is_each = curves.kind.is_each();
                source.bindings.extend(is_each.then_some(read("curve_of", Element::U32)));
                append_to(source, Listed::Near);
                "front/listing"
            }
            Self::Flows => {
                curves.end_correction(source, !is_split);
                "front/flowing"
            }
        };
        for slot in source.slots.iter_mut().filter(|slot| [WHOLE, SPLIT].contains(&&***slot)) {
            *slot = found.to_owned();
        }
    }
}

/// Has a pass put the tiles of what it notes on a list, or on none.
pub(super) fn note(source: &mut PassSource, list: Option<Listed>) {
    let slot = if list.is_some() { "front/noted" } else { "front/not_noted" };
    source.slots.push(slot.to_owned());
    if let Some(list) = list {
        append_to(source, list);
    }
}

fn append_to(source: &mut PassSource, list: Listed) {
    // Those who go through lists have as many invocations a workgroup as those who write them.
    debug_assert!(source.workgroup_size >= TILE as u32, "a tile is gone through by one workgroup");
    tiles_to(source);
    source.bindings.push(write("appended", Element::AtomicU32));
    source.constants.extend([
        ("APPENDED", list.bit()),
        ("LIST_LENGTH", Constant::Count(EMPTY.len() as u32 - 1)),
        ("TILES_OF_WORKGROUP", Constant::Count(source.workgroup_size / TILE as u32)),
        ("MOST_WORKGROUPS", Constant::Count(MOST_WORKGROUPS)),
    ]);
    source.slots.push("front/append".to_owned());
}

fn tiles_to(source: &mut PassSource) {
    source.bindings.push(write("tiles", Element::AtomicU32));
    source.constants.push(("TILE", Constant::Count(TILE as u32)));
}

/// Where what melts is, on the device.
#[derive(Debug)]
pub(super) struct DeviceFronts {
    /// A word of each tile, in the parts of the state.
    tiles: Vec<Buffer>,
    /// Two vectors for each material: see `shaders/front/melting.wgsl`.
    table: Buffer,
    /// Only of a state in one part.
    lists: Option<Lists>,
}

/// The lists of tiles, which begin as [`EMPTY`] does; two each: the one that a step goes through is that of the place of the
/// state that it reads.
#[derive(Debug)]
struct Lists {
    melting: [Buffer; 2],
    near: [Buffer; 2],
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
                return [1.0, 0.0, NEVER, 0.0, fronts.distance(), 0.0, 0.0, 0.0];
            };
            let [potential, rest] = two_words(front.potential);
            let per_width = 1.0 / (front.ends - front.begins);
            [front.begins, front.ends, potential, rest, fronts.distance(), per_width, 0.0, 0.0]
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
        }))
    }

    /// Has all lists be empty again.
    pub(super) fn clear(&self, device: &Device) -> Result<(), GpuError> {
        let Some(lists) = &self.lists else {
            return Ok(());
        };
        let tiles = device.read(&self.tiles[0])?;
        let unlisted = |tile: &u32| tile & ((1 << TILE) - 1);
        let tiles: Vec<u32> = bytemuck::cast_slice(&tiles).iter().map(unlisted).collect();
        device.write(&self.tiles[0], bytemuck::cast_slice(&tiles))?;
        lists.empty(device)
    }

    /// Has a pass of a step `from` a place of the state go through its list, if there are lists.
    pub(super) fn through_list(&self, pass: Pass, makes: FrontMakes, from: usize) -> Pass {
        match &self.lists {
            Some(lists) => pass.with_workgroups(lists.of_step(makes.listed(), from)),
            None => pass,
        }
    }

    /// The buffers of a pass that puts what it notes on a list that the step `from` a place of the state goes through, after
    /// its own; `None` without lists.
    pub(super) fn noted_in(&self, list: Listed, from: usize) -> Option<[&Buffer; 2]> {
        let lists = self.lists.as_ref()?;
        Some([&self.tiles[0], lists.of_step(list, from)])
    }

    /// The buffers of a pass of a step `from` a place of the state on part `k` of it, after those of enthalpies;
    /// `curve_of` says which curve each place has, where they have different ones.
    pub(super) fn buffers<'a>(
        &'a self,
        makes: FrontMakes,
        k: usize,
        from: usize,
        is_through_list: bool,
        curve_of: Option<&'a Buffer>,
    ) -> Vec<&'a Buffer> {
        let Some(Lists { melting, near }) = &self.lists else {
            return vec![&self.table, &self.tiles[k]];
        };
        match makes {
            FrontMakes::Near => {
                let listed = [&self.table, &melting[from], &near[1 - from]].into_iter();
                listed.chain(curve_of).chain([&self.tiles[k], &near[from]]).collect()
            }
            FrontMakes::Flows if is_through_list => vec![&self.table, &near[from], &melting[from]],
            FrontMakes::Flows => vec![&self.table],
        }
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let lists = self.lists.iter().flat_map(Lists::all);
        self.tiles.iter().chain([&self.table]).chain(lists).map(Buffer::bytes).sum()
    }
}

impl Lists {
    fn new(device: &Device, tiles: usize) -> Result<Self, GpuError> {
        let bytes = 4 * (EMPTY.len() + tiles) as u64;
        let list = |name| device.storage_with_workgroups(name, bytes);
        let both = |name| Ok::<_, GpuError>([list(name)?, list(name)?]);
        let lists =
            Self { melting: both("tiles that melt")?, near: both("tiles near what melts")? };
        lists.empty(device)?;
        Ok(lists)
    }

    fn all(&self) -> impl Iterator<Item = &Buffer> {
        self.melting.iter().chain(&self.near)
    }

    /// The one that the step `from` a place of the state goes through.
    fn of_step(&self, list: Listed, from: usize) -> &Buffer {
        match list {
            Listed::Melting => &self.melting[from],
            Listed::Near => &self.near[from],
        }
    }

    fn empty(&self, device: &Device) -> Result<(), GpuError> {
        self.all().try_for_each(|list| device.write(list, bytemuck::bytes_of(&EMPTY)))
    }
}
