//! The operator on the device, behind the passes of a step.

use std::ops::Range;

use super::enthalpy::HeatFields;
use super::fronts::FrontMakes;
use super::lattice::Lattice;
use super::list::{Chunk, List};
use super::passes::{Choices, EXCEPTION_BYTES};
use super::search::Search;
use crate::gpu::{Buffer, Device, GpuError, Pass};
use crate::solver::Precision;

/// What rates come from.
#[derive(Debug)]
pub(super) enum Operator {
    /// A stored list of neighbours.
    List { list: List, choices: Choices },
    /// Neighbours that are searched for in every sum.
    Search { search: Box<Search>, choices: Choices },
    /// The stencil of a lattice.
    Lattice(Box<Lattice>),
}

/// What the passes over all particles make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Makes {
    /// The state after an explicit Euler step.
    Step,
    /// Rates.
    Rate,
    /// Shares of a field and of its rate, and what the outside gave.
    Combination,
    /// The factor of each value in its own rate.
    Diagonal,
}

/// What these passes read and write.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a> {
    /// The parts of the state.
    pub(super) from: &'a [Buffer],
    /// Where the result goes, in the same parts.
    pub(super) to: &'a [Buffer],
    /// What held particles have given; only where there is one.
    pub(super) exchange: Option<&'a Buffer>,
    /// The rows to which walls add more than weights, and their sources; only where there is one.
    pub(super) walls: Option<[&'a Buffer; 2]>,
    /// The step over the reference step.
    pub(super) step_size: &'a Buffer,
    /// Only of a combination.
    pub(super) combination: Option<Combination<'a>>,
    /// Only of a step of enthalpies.
    pub(super) heat: Option<HeatFields<'a>>,
}

/// What a combination reads and writes besides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Combination<'a> {
    /// The shares.
    pub(super) factors: &'a Buffer,
    /// What the outside gave so far, of which the same share is taken.
    pub(super) given_before: &'a Buffer,
    /// Where the result of that goes.
    pub(super) given: &'a Buffer,
    /// Place, slot of a wall and place among the held of the particles that it concerns.
    pub(super) exception: &'a Buffer,
}

impl Fields<'_> {
    /// The buffers of walls, in the order of their bindings.
    pub(super) fn sources(&self) -> impl Iterator<Item = &Buffer> {
        self.walls.into_iter().flatten()
    }
}

impl Operator {
    /// The precision.
    pub(super) fn precision(&self) -> Precision {
        match self {
            Self::List { choices, .. } | Self::Search { choices, .. } => choices.precision,
            Self::Lattice(lattice) => lattice.precision(),
        }
    }

    /// Invocations a workgroup.
    pub(super) fn workgroup_size(&self) -> u32 {
        match self {
            Self::List { choices, .. } | Self::Search { choices, .. } => choices.workgroup_size,
            Self::Lattice(lattice) => lattice.workgroup_size(),
        }
    }

    /// The values of each buffer that a state is split into, of `count` in all.
    pub(super) fn parts(&self, count: usize) -> Vec<Range<usize>> {
        match self {
            Self::List { .. } | Self::Search { .. } => std::iter::once(0..count).collect(),
            Self::Lattice(lattice) => lattice.parts(),
        }
    }

    /// The passes over all particles, in order.
    pub(super) fn passes(
        &self,
        device: &Device,
        makes: Makes,
        fields: &Fields<'_>,
    ) -> Result<Vec<Pass>, GpuError> {
        match self {
            Self::List { list, choices } => {
                let passes = |chunk: &Chunk| {
                    let (rows, buffers) = (chunk.row_count(), chunk.of_sums(list));
                    row_passes(device, choices, buffers, rows, makes, fields)
                };
                let all: Vec<Vec<Pass>> =
                    list.chunks.iter().map(passes).collect::<Result<_, _>>()?;
                Ok(all.into_iter().flatten().collect())
            }
            Self::Search { search, choices } => {
                let (rows, buffers) = (search.row_count(), search.of_sums());
                row_passes(device, choices, buffers, rows, makes, fields)
            }
            Self::Lattice(lattice) => lattice.passes(device, makes, fields),
        }
    }

    /// The passes of an explicit Euler step that find where fronts may change it, before the step, or that change
    /// it, after it. There are none where nothing melts at one temperature.
    pub(super) fn front_passes(
        &self,
        device: &Device,
        makes: FrontMakes,
        fields: &Fields<'_>,
    ) -> Result<Vec<Pass>, GpuError> {
        let Some((heat, fronts)) = fields.heat.and_then(|heat| Some((heat, heat.fronts?))) else {
            return Ok(Vec::new());
        };
        let (choices, rows): (_, Vec<(u64, Vec<&Buffer>)>) = match self {
            Self::List { list, choices } => {
                let chunks = list.chunks.iter();
                (choices, chunks.map(|chunk| (chunk.row_count(), chunk.of_sums(list))).collect())
            }
            Self::Search { search, choices } => {
                (choices, vec![(search.row_count(), search.of_sums())])
            }
            Self::Lattice(lattice) => {
                return lattice.front_passes(device, makes, fields, heat, fronts);
            }
        };
        let source = choices.front(heat.enthalpy.sources(), makes);
        let pass = |(count, mut buffers): (u64, Vec<_>)| {
            buffers.extend([&fields.from[0], &fields.to[0], fields.step_size]);
            buffers.extend(fields.exchange);
            buffers.extend(heat.of_front(fronts, makes, 0, true, None));
            let pass = device.pass(&source, &buffers, count)?;
            Ok(fronts.through_list(pass, makes, heat.from))
        };
        rows.into_iter().map(pass).collect()
    }

    /// The places where more than a stencil acts in steps of enthalpies, ascending.
    pub(super) fn exceptions_of_heat(&self) -> &[u32] {
        match self {
            Self::List { .. } | Self::Search { .. } => &[],
            Self::Lattice(lattice) => lattice.exceptions_of_heat(),
        }
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::List { list, .. } => list.bytes(),
            Self::Search { search, .. } => search.bytes(),
            Self::Lattice(lattice) => lattice.bytes(),
        }
    }
}

/// The passes over `rows` rows, whose sums over neighbours have `buffers`.
fn row_passes<'a>(
    device: &Device,
    choices: &Choices,
    mut buffers: Vec<&'a Buffer>,
    rows: u64,
    makes: Makes,
    fields: &'a Fields<'_>,
) -> Result<Vec<Pass>, GpuError> {
    buffers.extend([&fields.from[0], &fields.to[0], fields.step_size]);
    buffers.extend(fields.exchange);
    buffers.extend(fields.sources());
    let mut source = match makes {
        Makes::Rate => choices.rate(),
        Makes::Step => choices.step(),
        Makes::Combination => choices.combine(),
        Makes::Diagonal => choices.diagonal(),
    };
    if let Some(heat) = &fields.heat {
        heat.end_step(&mut source);
        buffers.extend(heat.of_step(0));
    }
    let Some(Combination { factors, given_before, given, exception }) = fields.combination else {
        return Ok(vec![device.pass(&source, &buffers, rows)?]);
    };
    buffers.push(factors);
    let mut passes = vec![device.pass(&source, &buffers, rows)?];
    if exception.bytes() > 0 {
        buffers.extend([given_before, given, exception]);
        let exceptions = exception.bytes() / EXCEPTION_BYTES;
        passes.push(device.pass(&choices.list_given(), &buffers, exceptions)?);
    }
    Ok(passes)
}
