//! Lattices on the device: no list, no positions. A step is one dispatch over all sites, and where
//! particles are held, walls impose something or the stencil does not hold, a second one over those sites
//! alone. In a step of enthalpies the stencil holds where seams alone differ from it too, which are added to anyway.

mod kinds;
mod rows;
mod source;

use std::ops::Range;

use super::GpuOptions;
use super::enthalpy::HeatFields;
use super::fronts::{DeviceFronts, FrontMakes};
use super::operator::{Fields, Makes};
use super::passes::{NO_SLOT, WallTerms};
use crate::gpu::{Buffer, Device, GpuError, Pass, Real};
use crate::model::lattice::{Edge, End, LatticeScene, MixedScene};
use crate::model::operator::{FoldNeeds, SomeRows, SourceRows};
use crate::solver::Precision;
use crate::solver::plan::Needs;

use kinds::Kinds;
pub use kinds::are_few;
pub(super) use kinds::factors;
use rows::Rows;
use source::Sites;
pub use source::{OwnRows, PART, StencilSource};

/// The stencil of a lattice on the device.
#[derive(Debug)]
pub(super) struct Lattice {
    source: StencilSource,
    parts: Vec<Part>,
    /// What ghosts have more than their sources, in parts of these, by end and layer.
    ghost_excess: Buffer,
    /// Sites to each neighbour, and its weight; only where they are not written out.
    entry: Option<[Buffer; 2]>,
    /// Only where sites differ.
    kinds: Option<Kinds>,
    /// Only where the stencil does not hold everywhere.
    rows: Option<Rows>,
    /// Site, slot of a wall, place among the held and first element of the row of each site where more than the
    /// stencil acts; only where there is one.
    exception: Option<Buffer>,
    /// The sites of these, ascending.
    exceptions: Vec<u32>,
    /// What steps of enthalpies have in place of this where the stencil writes more sites then.
    of_heat: Option<Box<Lattice>>,
}

/// What a lattice has beside its stencil.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside<'a> {
    /// Held sites, ascending.
    pub(super) held: &'a [u32],
    /// What walls add at sites.
    pub(super) walls: &'a SourceRows,
    /// Rows where the stencil does not hold; only of a mixed scene.
    pub(super) mixed: Option<(&'a MixedScene, &'a SomeRows)>,
    /// Sites with such rows that the stencil writes in steps of enthalpies, ascending, with its factors there.
    pub(super) beside_seams: &'a [(u32, f64)],
}

/// Sites whose values are in one buffer.
#[derive(Debug)]
struct Part {
    sites: Range<usize>,
    exceptions: Range<usize>,
    /// The parts that its stencils reach: before and behind it.
    beside: [usize; 2],
    block: Buffer,
}

impl Lattice {
    /// The lattice `scene` with what it has beside its stencil; weights are relative to `reference_step` (s).
    pub(super) fn new(
        device: &Device,
        scene: &LatticeScene,
        beside: Beside<'_>,
        reference_step: f64,
        options: GpuOptions,
    ) -> Result<Self, GpuError> {
        let rows = beside
            .mixed
            .map(|(_, rows)| Rows::new(device, rows, reference_step, options.precision));
        let rows = rows.transpose()?.flatten();
        let of = |rows, beside_seams| {
            let beside = Beside { beside_seams, ..beside };
            Self::with_rows(device, scene, beside, rows, reference_step, options)
        };
        let of_heat = match beside.beside_seams {
            [] => None,
            some => {
                let is_left = |site| some.binary_search_by_key(&site, |&(site, _)| site).is_err();
                let rest = rows.as_ref().and_then(|rows| rows.only(is_left));
                Some(Box::new(of(rest, some)?))
            }
        };
        Ok(Self { of_heat, ..of(rows, &[])? })
    }

    /// The same with some of the `rows` that are beside its stencil, which also writes what is `beside` seams.
    fn with_rows(
        device: &Device,
        scene: &LatticeScene,
        beside: Beside<'_>,
        rows: Option<Rows>,
        reference_step: f64,
        options: GpuOptions,
    ) -> Result<Self, GpuError> {
        let real = options.precision.real();
        let Beside { held, walls, mixed, beside_seams } = beside;
        let stored = rows.as_ref().map_or(&[][..], |rows| &rows.first);
        let kinds = mixed
            .map(|(scene, _)| Kinds::new(device, scene, stored, beside_seams, options.precision));
        let kinds = kinds.transpose()?.flatten();
        let value = options.precision.state_bytes();
        let most = options.most_bytes(device) / value;
        let parts = parts(scene, most).map_err(|needed| GpuError::TooLarge {
            what: "the layers of a lattice that a stencil reaches".to_owned(),
            needed: needed * value,
            available: most * value,
        })?;
        let (periodic, mirrors) = source::ends(scene);
        let exceptions = exceptions(held, walls.rank(), stored);
        let source = StencilSource {
            counts: scene.counts,
            reach: scene.reach,
            dimension: scene.dimension,
            periodic,
            mirrors,
            entries: source::entries(scene, reference_step),
            is_split: parts.len() > 1,
            kinds: kinds.is_some(),
            rows: match stored.len() {
                0 => OwnRows::None,
                count if count < exceptions.len() => OwnRows::Some,
                _ => OwnRows::All,
            },
            held: !held.is_empty(),
            walls: WallTerms::of(walls),
            finds_each: false,
            precision: options.precision,
            workgroup_size: options.workgroup_size,
        };
        let exception = match exceptions.is_empty() {
            true => None,
            false => Some(device.storage_with("exceptions", bytemuck::cast_slice(&exceptions))?),
        };
        let part = |k: usize| Part::new(device, real, &parts, k, &exceptions);
        Ok(Self {
            parts: (0..parts.len()).map(part).collect::<Result<_, _>>()?,
            ghost_excess: device.storage_with("ghosts", &real.to_bytes(&ghost_excess(scene)))?,
            entry: entry_buffers(device, &source)?,
            kinds,
            rows,
            exception,
            exceptions: exceptions.iter().map(|exception| exception[0]).collect(),
            of_heat: None,
            source,
        })
    }

    pub(super) fn precision(&self) -> Precision {
        self.source.precision
    }

    pub(super) fn workgroup_size(&self) -> u32 {
        self.source.workgroup_size
    }

    /// The sites of each buffer of a state.
    pub(super) fn parts(&self) -> Vec<Range<usize>> {
        self.parts.iter().map(|part| part.sites.clone()).collect()
    }

    /// The passes of all parts; those over exceptions come after all others.
    pub(super) fn passes(
        &self,
        device: &Device,
        makes: Makes,
        fields: &Fields<'_>,
    ) -> Result<Vec<Pass>, GpuError> {
        let is_of_heat = makes == Makes::Step && fields.heat.is_some();
        if let Some(of_heat) = self.of_heat.as_ref().filter(|_| is_of_heat) {
            return of_heat.passes(device, makes, fields);
        }
        let mut passes = Vec::new();
        for &sites in self.source.sites_of(makes) {
            let mut source = self.source.pass(sites, makes);
            if let Some(heat) = &fields.heat {
                heat.end_step(&mut source);
            }
            for (k, threads) in self.threads(sites) {
                let mut buffers = self.buffers(&self.source, k, sites, makes, fields);
                buffers.extend(fields.heat.iter().flat_map(|heat| heat.of_step(k)));
                passes.push(device.pass(&source, &buffers, threads)?);
            }
        }
        Ok(passes)
    }

    /// The passes of an explicit Euler step that make of `fronts` what `makes` says, in order.
    pub(super) fn front_passes(
        &self,
        device: &Device,
        makes: FrontMakes,
        fields: &Fields<'_>,
        heat: HeatFields<'_>,
        fronts: &DeviceFronts,
    ) -> Result<Vec<Pass>, GpuError> {
        if let Some(of_heat) = &self.of_heat {
            return of_heat.front_passes(device, makes, fields, heat, fronts);
        }
        let fields = Fields { walls: None, ..*fields };
        let mut passes = Vec::new();
        if !FrontMakes::of(self.source.is_split).contains(&makes) {
            return Ok(passes);
        }
        let of_fronts = self.source.of_fronts(makes);
        for &sites in StencilSource::front_sites_of(makes) {
            let source = self.source.front(sites, heat.enthalpy.sources(), makes);
            for (k, threads) in self.threads(sites) {
                let mut buffers = self.buffers(&of_fronts, k, sites, Makes::Step, &fields);
                let beside = self.source.is_split.then_some(self.parts[k].beside);
                let is_through_list = sites == Sites::All;
                buffers.extend(heat.of_front(fronts, makes, k, is_through_list, beside));
                let pass = device.pass(&source, &buffers, threads)?;
                passes.push(match sites {
                    Sites::All => fronts.through_list(pass, makes, heat.from),
                    Sites::Exceptions => pass,
                });
            }
        }
        Ok(passes)
    }

    /// The parts with such sites, and how many they have.
    fn threads(&self, sites: Sites) -> impl Iterator<Item = (usize, u64)> {
        let of_part = move |part: &Part| match sites {
            Sites::All => part.sites.len() as u64,
            Sites::Exceptions => part.exceptions.len() as u64,
        };
        self.parts.iter().map(of_part).enumerate().filter(|(_, threads)| *threads > 0)
    }

    /// The sites where more than the stencil acts in steps of enthalpies, ascending.
    pub(super) fn exceptions_of_heat(&self) -> &[u32] {
        self.of_heat.as_ref().map_or(&self.exceptions, |of_heat| &of_heat.exceptions)
    }

    /// The buffers of a pass of `source`, which is that of this lattice or what fronts have of it, on part `k`, in the order
    /// of its bindings.
    fn buffers<'a>(
        &'a self,
        source: &StencilSource,
        k: usize,
        sites: Sites,
        makes: Makes,
        fields: &'a Fields<'a>,
    ) -> Vec<&'a Buffer> {
        let part = &self.parts[k];
        let mut buffers = vec![&part.block];
        if makes != Makes::Diagonal {
            buffers.push(&fields.from[k]);
            if source.is_split {
                buffers.extend(part.beside.map(|other| &fields.from[other]));
            }
        }
        buffers.extend([&fields.to[k], fields.step_size]);
        if source.has_stencil(sites) {
            buffers.push(&self.ghost_excess);
            buffers.extend(self.entry.iter().flatten());
            let kinds = self.kinds.iter().filter(|_| source.kinds);
            buffers.extend(kinds.flat_map(|kinds| [&kinds.kind, &kinds.factor]));
        }
        if sites == Sites::Exceptions {
            buffers.extend(&self.exception);
            buffers.extend(self.rows.iter().flat_map(|rows| [&rows.neighbor, &rows.weight]));
            if makes != Makes::Diagonal {
                buffers.extend(fields.exchange);
                buffers.extend(fields.sources());
            }
        }
        if let Some(combination) = fields.combination {
            buffers.push(combination.factors);
            if sites == Sites::Exceptions {
                buffers.extend([combination.given_before, combination.given]);
            }
        }
        buffers
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        // Steps of enthalpies have the same rows.
        self.bytes_but_for_rows() + self.rows.as_ref().map_or(0, Rows::bytes)
    }

    fn bytes_but_for_rows(&self) -> u64 {
        let blocks = self.parts.iter().map(|part| part.block.bytes()).sum::<u64>();
        let others = self.entry.iter().flatten().chain(&self.exception).chain([&self.ghost_excess]);
        let kinds = self.kinds.as_ref().map_or(0, Kinds::bytes);
        let of_heat = self.of_heat.as_ref().map_or(0, |of_heat| of_heat.bytes_but_for_rows());
        others.map(Buffer::bytes).sum::<u64>() + blocks + kinds + of_heat
    }
}

impl Part {
    /// Part `k` of `parts`.
    fn new(
        device: &Device,
        real: Real,
        parts: &[Range<usize>],
        k: usize,
        exceptions: &[[u32; 4]],
    ) -> Result<Self, GpuError> {
        let sites = parts[k].clone();
        let place = |site: usize| exceptions.partition_point(|e| (e[0] as usize) < site);
        let exceptions = place(sites.start)..place(sites.end);
        // Round the ends: what is there counts on periodic axes, and else is not asked for.
        let beside = [(k + parts.len() - 1) % parts.len(), (k + 1) % parts.len()];
        let [below, above] = beside.map(|other| &parts[other]);
        let counts = [
            sites.start,
            sites.end,
            below.start,
            below.end,
            above.start,
            exceptions.start,
            exceptions.end,
        ];
        let contents = PART.contents(real, counts.map(|count| count as u32), []);
        Ok(Self { sites, exceptions, beside, block: device.block("part", &contents)? })
    }
}

/// The passes of a step, in order, of a scene of which some sites have `rows` of their own or none.
pub fn step_passes(needs: Needs, rows: bool) -> Vec<&'static str> {
    let mut passes = vec!["lattice_step"];
    if rows || needs.held || needs.walls >= FoldNeeds::Steady {
        passes.push("exception_step");
    }
    passes
}

/// What the exchange of held particles is counted in: for each, what it has given to others, in two
/// words, and what it gets a reference step (s) at this rate from held ones and from walls.
pub(super) fn held_contents(among_held: &[f64], reference_step: f64) -> Vec<f64> {
    among_held.iter().flat_map(|rate| [0.0, 0.0, reference_step * rate, 0.0]).collect()
}

/// Parts of at most `most` sites: whole layers across the last axis, as even as can be, and each as
/// thick as the stencil reaches, so that it reaches no further than the next part.
///
/// # Errors
/// The sites of the thickest part in the finest cut that there is, where these are more.
fn parts(scene: &LatticeScene, most: u64) -> Result<Vec<Range<usize>>, u64> {
    let last = scene.dimension - 1;
    let layers = scene.counts[last];
    let layer: usize = scene.counts[..last].iter().product();
    let least = scene.reach.max(1);
    let thickest = usize::try_from(most / layer as u64).unwrap_or(usize::MAX);
    let count = layers.div_ceil(thickest.max(1));
    if count > 1 && (thickest < least || layers / count < least) {
        return Err((layers.div_ceil((layers / least).max(1)) * layer) as u64);
    }
    let start = |k: usize| k * layers / count * layer;
    Ok((0..count).map(|k| start(k)..start(k + 1)).collect())
}

/// Site (or row), slot, place among the held and first element of its stored row of each that has one of
/// these, ascending.
pub(super) fn exceptions(held: &[u32], walls: &[u32], stored: &[(u32, u32)]) -> Vec<[u32; 4]> {
    const NO: u32 = NO_SLOT;
    let mut list: Vec<[u32; 4]> = Vec::with_capacity(held.len() + walls.len() + stored.len());
    let held = (0..).zip(held).map(|(place, &site)| [site, NO, place, NO]);
    let walls = (0..).zip(walls).map(|(slot, &site)| [site, slot, NO, NO]);
    let stored = stored.iter().map(|&(site, first)| [site, NO, NO, first]);
    let mut all: Vec<[u32; 4]> = held.chain(walls).chain(stored).collect();
    all.sort_unstable_by_key(|exception| exception[0]);
    for next in all {
        match list.last_mut().filter(|last| last[0] == next[0]) {
            // Absent ones are the largest number.
            Some(last) => {
                last.iter_mut().zip(next).for_each(|(last, next)| *last = next.min(*last))
            }
            None => list.push(next),
        }
    }
    list
}

/// What every layer of ghosts has more than its source, in parts of that, by end; 0 where there are none.
fn ghost_excess(scene: &LatticeScene) -> Vec<f64> {
    let none = || vec![0.0; scene.reach];
    let of_end = |end: &End| match end {
        End::Free => none(),
        End::Mirror(factors) => factors.iter().map(|factor| factor - 1.0).collect(),
    };
    let of_edge = |edge: &Edge| match edge {
        Edge::Periodic => [none(), none()],
        Edge::Open(ends) => ends.each_ref().map(of_end),
    };
    scene.edges.iter().flat_map(of_edge).flatten().collect()
}

/// Sites along x, y and z to each neighbour on one side, and their weights, where the shaders read them.
fn entry_buffers(device: &Device, source: &StencilSource) -> Result<Option<[Buffer; 2]>, GpuError> {
    if !source.is_loop() {
        return Ok(None);
    }
    let entries = || source::one_sided(&source.entries);
    let steps = |([x, y, z], _): &([isize; 3], f64)| [*x, *y, *z, 0].map(|step| step as i32);
    let steps: Vec<i32> = entries().flat_map(steps).collect();
    let weights: Vec<f64> = entries().map(|(_, weight)| *weight).collect();
    let weights = source.precision.state_to_bytes(&weights);
    Ok(Some([
        device.storage_with("stencil", bytemuck::cast_slice(&steps))?,
        device.storage_with("weights of the stencil", &weights)?,
    ]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(counts: [usize; 3], dimension: usize, reach: usize) -> LatticeScene {
        LatticeScene {
            counts,
            dimension,
            order: None,
            edges: [const { Edge::Periodic }; 3],
            reach,
            classes: Vec::new(),
        }
    }

    #[test]
    fn parts_are_whole_layers_as_thick_as_the_stencil() {
        let box_of = scene([4, 5, 7], 3, 2);
        assert_eq!(parts(&box_of, 140), Ok(std::iter::once(0..140).collect()));
        assert_eq!(parts(&box_of, 139), Ok(vec![0..60, 60..140]));
        assert_eq!(parts(&box_of, 60), Ok(vec![0..40, 40..80, 80..140]));
        // Seven layers are two, two and three.
        assert_eq!(parts(&box_of, 59), Err(60));
        assert_eq!(parts(&box_of, 19), Err(60));
        assert_eq!(parts(&scene([10, 1, 1], 1, 1), 4), Ok(vec![0..3, 3..6, 6..10]));
        assert_eq!(parts(&scene([3, 4, 1], 2, 1), 6), Ok(vec![0..6, 6..12]));
    }

    #[test]
    fn a_site_that_is_held_and_walled_is_one_exception() {
        let found = exceptions(&[3, 7], &[2, 7, 9], &[(4, 32), (7, 33)]);
        let no = NO_SLOT;
        let expected =
            [[2, 0, no, no], [3, no, 0, no], [4, no, no, 32], [7, 1, 1, 33], [9, 2, no, no]];
        assert_eq!(found, expected);
    }
}
