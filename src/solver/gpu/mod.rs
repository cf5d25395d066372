//! The GPU backend. By list: the neighbours are found on the device once and stored with their
//! weights, and a step is one pass over them. Matrix-free: a step finds them. By lattice: a step is one pass
//! with a stencil.
//!
//! State lives on the device in the order of its cells or sites; the problem's order is restored on
//! reading back.

mod backend;
mod choices;
pub mod curve_passes;
mod enthalpy;
mod fronts;
pub mod lattice;
mod list;
mod operator;
pub mod passes;
mod phases;
mod scaling;
mod seams;
mod search;
mod self_test;
mod sorted;
mod steps;
pub mod vector;
mod walls;

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::plan::Needs;
use super::{Precision, SolverError};
use crate::gpu::{Buffer, Device, GpuError};
use crate::model::lattice::{ABSENT, LatticeScene, MixedScene};
use crate::model::neighbors::CellLayout;
use crate::model::operator::{Seams, SomeRows, SourceRows};
use crate::model::{Material, Problem};

use curve_passes::{HeldIn, SeamPasses};
use enthalpy::Curves;
use fronts::DeviceFronts;
pub use fronts::TILE;
use lattice::{Beside, Lattice};
use list::List;
use operator::Operator;
pub use passes::Choices;
use passes::{Neighbors, WallTerms};
use phases::UpToDate;
use scaling::{Scaling, reference_step};
use seams::DeviceSeams;
use search::Search;
pub use self_test::SelfTest;
pub use sorted::Sorted;
use steps::{Heat, Steps};
pub use vector::GpuVector;
use vector::{Capacities, Tools, VectorScene};
use walls::{WallSlots, Walls};

/// A stencil that has at most so many times the weight of a pair at a seam may write it for a row: what it writes is
/// taken out again, and so large a part of the flow is rounded twice.
const MOST_OF_WEIGHT: f64 = 2.0;

/// What has to be in one buffer.
const STATE_OF_SEVERAL: &str =
    "the state of several materials of which one melts or conducts as its temperature";

/// How a scene is put on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GpuOptions {
    /// The precision.
    pub precision: Precision,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
    /// Bytes that a buffer of the neighbour list or of a lattice's state may take, if fewer than the
    /// device allows.
    pub chunk_bytes: Option<u64>,
    /// Whether neighbours are searched for in every sum, where they would be listed.
    pub matrix_free: bool,
}

impl GpuOptions {
    /// The usual way, in this precision.
    pub fn new(precision: Precision) -> Self {
        Self {
            precision,
            workgroup_size: passes::WORKGROUP_SIZE,
            chunk_bytes: None,
            matrix_free: false,
        }
    }

    /// Bytes that a buffer may take.
    fn most_bytes(self, device: &Device) -> u64 {
        let most = device.max_binding_bytes();
        self.chunk_bytes.map_or(most, |bytes| bytes.min(most))
    }
}

/// Values as read back from the device, in the problem's order.
#[derive(Clone, Debug, PartialEq)]
pub struct GpuField(Vec<f64>);

impl AsRef<[f64]> for GpuField {
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

/// A scene on a device.
#[derive(Debug)]
pub struct GpuBackend {
    device: Device,
    operator: Operator,
    /// Which particle is in each place of the state, or [`ABSENT`]; `None` where that is their own order.
    order: Option<Vec<u32>>,
    /// Where in the exchange each held particle's begins, in two words, and its volume.
    held: Vec<(usize, f64)>,
    steps: Steps,
    /// Reference step, s.
    reference_step: f64,
    saved: Option<Saved>,
    scene: VectorScene,
    /// Only where vectors are used.
    tools: Option<Box<Tools>>,
}

/// A copy of the state.
#[derive(Debug)]
struct Saved {
    state: Vec<Buffer>,
    enthalpy: Vec<Buffer>,
    exchange: Option<Buffer>,
    walls: Option<Buffer>,
    up_to_date: UpToDate,
    /// Where the ring of wall sources was.
    tick: u32,
}

impl GpuBackend {
    /// Puts `problem` on `device` by list; `dt` (s) is the step that the run is expected to take,
    /// though any may be taken.
    pub fn new(
        problem: &Problem,
        dt: f64,
        device: &Device,
        precision: Precision,
    ) -> Result<Self, SolverError> {
        Self::with_options(problem, dt, device, GpuOptions::new(precision))
    }

    /// As [`GpuBackend::new`], with every option.
    pub fn with_options(
        problem: &Problem,
        dt: f64,
        device: &Device,
        options: GpuOptions,
    ) -> Result<Self, SolverError> {
        let needs = Needs::of(problem);
        let scaling = Scaling::new(problem, dt, needs.coefficients);
        let mut choices = choices(problem, needs, options);
        device.require(choices.real())?;
        let particles = &problem.particles;
        let cells = CellLayout::of(problem);
        let support_radius = problem.kernel.support_radius();
        let sorted = Sorted::new(
            device,
            &choices,
            &cells,
            &particles.position,
            support_radius,
            scaling.weight,
        )?;
        let order = sorted.order().to_vec();
        let walls = Walls::new(problem, &order, scaling.step);
        choices.walls = walls.terms();
        if options.matrix_free {
            choices.neighbors = Neighbors::Searched { folded: walls.is_folded() };
        }
        let held = held_rows(problem, &order);
        let rows: Vec<u32> = held.iter().map(|&(row, _)| row).collect();
        let table = coefficient_table(device, &choices, &order, scaling.ratios.as_deref())?;
        let bytes = options.most_bytes(device);
        let capacities = order.iter().map(|&p| problem.capacity(p as usize));
        let scene = VectorScene {
            exceptions: lattice::exceptions(&rows, walls.slot_rows(), &[]),
            capacities: Capacities::of(capacities),
        };
        let initial: Vec<f64> = order.iter().map(|&p| problem.initial[p as usize]).collect();
        let exchange = match choices.held {
            true => Some(
                device.storage("exchange", 2 * order.len() as u64 * options.precision.bytes())?,
            ),
            false => None,
        };
        let operator = if options.matrix_free {
            let search = Box::new(Search::new(device, &choices, sorted, &rows, &walls, table)?);
            Operator::Search { search, choices }
        } else {
            let list = List::new(device, &choices, &sorted, &rows, &walls, table.as_ref(), bytes)?;
            Operator::List { list, choices }
        };
        let slots = WallSlots::new(device, choices.real(), walls.into_rows(), scaling.step)?;
        let curves = Curves::of(problem, Some(&order));
        let seams = match several(problem, curves.as_ref()) {
            Some(curves) => {
                let mut place = vec![0; order.len()];
                for (k, &particle) in (0..).zip(&order) {
                    place[particle as usize] = k;
                }
                let passes = seam_passes(problem, options, &rows, HeldIn::Rows);
                let seams = Seams::of(problem, &place, false, |_| None).map(|seams| {
                    DeviceSeams::new(device, problem, curves, &seams, &rows, scaling.step, passes)
                });
                seams.transpose()?
            }
            None => None,
        };
        let parts = operator.parts(order.len());
        let fronts = DeviceFronts::new(device, problem, options.precision, &parts, &[])?;
        let heat = Heat { curves: curves.as_ref(), seams, fronts };
        Ok(Self {
            steps: Steps::new(device, &operator, &initial, heat, exchange, slots)?,
            device: device.clone(),
            operator,
            order: Some(order),
            held: held.into_iter().map(|(row, capacity)| (2 * row as usize, capacity)).collect(),
            reference_step: scaling.step,
            saved: None,
            scene,
            tools: None,
        })
    }

    /// Puts `problem`, which is the lattice `scene` and whose walls add `walls` at its sites, on
    /// `device`; `dt` (s) is the step that the run is expected to take, though any may be taken.
    ///
    /// # Errors
    /// A device that fails, or that cannot hold it.
    pub fn lattice(
        problem: &Problem,
        scene: &LatticeScene,
        walls: SourceRows,
        dt: f64,
        device: &Device,
        options: GpuOptions,
    ) -> Result<Self, SolverError> {
        let material = problem.particles.material.first().map_or(0, |&m| usize::from(m));
        let step = reference_step(problem, dt, problem.materials[material].diffusivity());
        let held = scene.held_sites(&problem.held);
        let among_held = scene.rates_among_held(&held, &problem.potentials(&problem.initial));
        let walls = walls.beside_stencil(&[]);
        let beside = Beside { held: &held, walls: &walls, mixed: None, beside_seams: &[] };
        Self::on_sites(problem, scene, beside, &among_held, step, device, options)
    }

    /// Puts `problem`, which is a lattice in part as `scene` says and has `rows` elsewhere, on `device`; `dt` (s)
    /// is the step that the run is expected to take, though any may be taken.
    ///
    /// # Errors
    /// A device that fails, or that cannot hold it.
    pub fn mixed(
        problem: &Problem,
        scene: &MixedScene,
        rows: &SomeRows,
        dt: f64,
        device: &Device,
        options: GpuOptions,
    ) -> Result<Self, SolverError> {
        let diffusivity = problem.materials.iter().map(Material::diffusivity).fold(0.0, f64::max);
        let step = reference_step(problem, dt, diffusivity);
        let held = rows.held_rank();
        let walls = rows.sources().clone().beside_stencil(rows.rank());
        let beside_seams = scene.beside_seams(problem, rows, MOST_OF_WEIGHT).into_iter();
        let with_factor = |site| (site, scene.factor(problem, site as usize));
        // A stencil has the factors of the sites that it describes.
        let known = lattice::factors(scene);
        let is_known = |(_, factor): &(u32, f64)| known.contains(factor);
        let beside_seams: Vec<(u32, f64)> =
            beside_seams.map(with_factor).filter(is_known).collect();
        let mixed = Some((scene, rows));
        let beside = Beside { held, walls: &walls, mixed, beside_seams: &beside_seams };
        // The rows of held particles are without what these give each other.
        let among_held = vec![0.0; held.len()];
        Self::on_sites(problem, &scene.lattice, beside, &among_held, step, device, options)
    }

    /// Puts a lattice on `device`, whose held particles give each other `among_held` (1/s x value) and whose
    /// weights are relative to the step `reference` (s).
    fn on_sites(
        problem: &Problem,
        scene: &LatticeScene,
        beside: Beside<'_>,
        among_held: &[f64],
        reference: f64,
        device: &Device,
        options: GpuOptions,
    ) -> Result<Self, SolverError> {
        let real = options.precision.real();
        device.require(real)?;
        let Beside { held, walls, mixed, beside_seams } = beside;
        let operator =
            Operator::Lattice(Box::new(Lattice::new(device, scene, beside, reference, options)?));
        let capacity = |site: u32| problem.capacity(scene.particle(site as usize));
        let exchange = match held.is_empty() {
            true => None,
            false => {
                let contents = lattice::held_contents(among_held, reference);
                Some(device.storage_with("exchange", &real.to_bytes(&contents))?)
            }
        };
        let order = scene.order.as_deref();
        // What has a curve has an enthalpy where there is no particle as well.
        let nothing = if problem.has_curves() { problem.initial[0] } else { 0.0 };
        let initial = by_place(order, &problem.initial, nothing);
        let slots = WallSlots::new(device, real, walls.clone(), reference)?;
        let curves = Curves::of(problem, order);
        let parts = operator.parts(initial.len());
        let seams = match several(problem, curves.as_ref()) {
            Some(_) if parts.len() > 1 => {
                return Err(SolverError::Gpu(GpuError::TooLarge {
                    what: STATE_OF_SEVERAL.to_owned(),
                    needed: options.precision.state_bytes() * initial.len() as u64,
                    available: options.most_bytes(device),
                }));
            }
            Some(curves) => {
                let particles = 0..problem.particles.len() as u32;
                let place: Vec<u32> = particles.map(scene.sites()).collect();
                let passes = seam_passes(problem, options, held, HeldIn::Lattice);
                let written = |site: usize| {
                    let (scene, _) = mixed?;
                    beside_seams.binary_search_by_key(&(site as u32), |&(site, _)| site).ok()?;
                    Some(scene.stencil(problem, site))
                };
                let seams = Seams::of(problem, &place, false, written).map(|seams| {
                    DeviceSeams::new(device, problem, curves, &seams, held, reference, passes)
                });
                seams.transpose()?
            }
            None => None,
        };
        let exceptions = operator.exceptions_of_heat();
        let fronts = DeviceFronts::new(device, problem, options.precision, &parts, exceptions)?;
        let heat = Heat { curves: curves.as_ref(), seams, fronts };
        Ok(Self {
            steps: Steps::new(device, &operator, &initial, heat, exchange, slots)?,
            device: device.clone(),
            operator,
            order: scene.order.clone(),
            held: (0..).zip(held).map(|(k, &site)| (4 * k, capacity(site))).collect(),
            reference_step: reference,
            saved: None,
            scene: VectorScene {
                exceptions: lattice::exceptions(held, walls.rank(), &[]),
                capacities: Capacities::of_sites(problem, order),
            },
            tools: None,
        })
    }

    /// What of the shaders of the list this scene uses; `None` for a lattice.
    pub fn choices(&self) -> Option<&Choices> {
        match &self.operator {
            Operator::List { choices, .. } | Operator::Search { choices, .. } => Some(choices),
            Operator::Lattice(_) => None,
        }
    }

    /// How many chunks the neighbour list or the state of a lattice has: a diagnostic.
    pub fn chunk_count(&self) -> usize {
        match &self.operator {
            Operator::List { list, .. } => list.chunks.len(),
            Operator::Search { .. } => 1,
            Operator::Lattice(lattice) => lattice.parts().len(),
        }
    }

    /// The neighbours of each particle in stored order, with the weight a reference step, which is
    /// the step given to [`GpuBackend::new`]: a diagnostic. Only a list stores any.
    pub fn neighbors(&self) -> Result<Vec<Vec<(u32, f64)>>, SolverError> {
        let (Operator::List { list, choices }, Some(order)) = (&self.operator, &self.order) else {
            return Ok(Vec::new());
        };
        let rows = list.read(&self.device, choices)?;
        let mut neighbors = vec![Vec::new(); rows.len()];
        for (&particle, row) in order.iter().zip(rows) {
            let of_particle = row.into_iter().map(|(b, w)| (order[b as usize], w));
            neighbors[particle as usize] = of_particle.collect();
        }
        Ok(neighbors)
    }

    /// Puts values by place into the problem's order.
    fn by_particle(&self, values: Vec<f64>) -> GpuField {
        let Some(order) = &self.order else {
            return GpuField(values);
        };
        let present = || order.iter().zip(&values).filter(|(particle, _)| **particle != ABSENT);
        let mut by_particle = vec![0.0; present().count()];
        present().for_each(|(&particle, &value)| by_particle[particle as usize] = value);
        GpuField(by_particle)
    }
}

/// What each particle has, by place; `nothing` where there is none.
fn by_place<'a, T: Copy>(order: Option<&[u32]>, of: &'a [T], nothing: T) -> Cow<'a, [T]> {
    let Some(order) = order else {
        return Cow::Borrowed(of);
    };
    let at = |&particle: &u32| match particle {
        ABSENT => nothing,
        particle => of[particle as usize],
    };
    order.iter().map(at).collect()
}

/// What of the shaders a scene uses.
fn choices(problem: &Problem, needs: Needs, options: GpuOptions) -> Choices {
    let mut periodic = problem.domain.periodic;
    // Axes past the dimension have no extent, whatever the case says of them.
    periodic[problem.dimension..].fill(false);
    Choices {
        kernel: problem.kernel.kind(),
        pair_mean: problem.pair_mean,
        dimension: problem.dimension,
        periodic,
        held: needs.held,
        walls: WallTerms::None,
        uniform: !needs.coefficients,
        neighbors: Neighbors::Listed,
        precision: options.precision,
        workgroup_size: options.workgroup_size,
    }
}

/// The curves, where they differ.
fn several<'a>(problem: &Problem, curves: Option<&'a Curves>) -> Option<&'a Curves> {
    curves.filter(|_| !problem.has_one_curve())
}

/// What the shaders where materials meet follow from, where what the `held` particles give is counted in `held_in`.
fn seam_passes(
    problem: &Problem,
    options: GpuOptions,
    held: &[u32],
    held_in: HeldIn,
) -> SeamPasses {
    let GpuOptions { precision, workgroup_size, .. } = options;
    let held = if held.is_empty() { HeldIn::None } else { held_in };
    SeamPasses { precision, workgroup_size, pair_mean: problem.pair_mean, held }
}

/// Row and capacity of each held particle.
fn held_rows(problem: &Problem, order: &[u32]) -> Vec<(u32, f64)> {
    let held: BTreeSet<u32> = problem.held.iter().copied().collect();
    let rows = (0..).zip(order).filter(|(_, particle)| held.contains(particle));
    rows.map(|(row, &p)| (row, problem.capacity(p as usize))).collect()
}

/// The table of ratios in sorted order, where the scene needs one.
fn coefficient_table(
    device: &Device,
    choices: &Choices,
    order: &[u32],
    ratios: Option<&[[f64; 4]]>,
) -> Result<Option<Buffer>, GpuError> {
    let Some(ratios) = ratios else {
        return Ok(None);
    };
    let sorted: Vec<f64> = order.iter().flat_map(|&p| ratios[p as usize]).collect();
    let bytes = choices.real().to_bytes(&sorted);
    Ok(Some(device.storage_with("volumes and properties", &bytes)?))
}
