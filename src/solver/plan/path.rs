//! How neighbours are known: which path a scene takes.

use std::sync::Arc;

use crate::model::Problem;
use crate::model::lattice::{LatticeScene, MixedScene};
use crate::solver::{MachineKind, SolverError, gpu};

/// How neighbours are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// From stored lists with stored weights.
    List,
    /// By their place on a lattice that the particles fill: the sum is a stencil.
    Lattice,
    /// By their place on a lattice where the sum is a stencil, from stored rows elsewhere.
    Mixed,
    /// By a search among the sorted particles in every sum; on a GPU only.
    MatrixFree,
}

/// Sizes of the mixed path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MixedSizes {
    /// Sites of the lattice, with a particle or without.
    pub sites: u64,
    /// Particles with rows of their own.
    pub rows: u64,
}

/// Which path a user wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PathWish {
    /// The fastest: the lattice where the scene is one, mixed where that pays, else the list, or
    /// matrix-free where a GPU has no room for that.
    #[default]
    Auto,
    /// The list, whatever the scene.
    List,
    /// The stencil wherever it holds, be it lattice or mixed, or nothing.
    Lattice,
    /// A search for neighbours in every sum, on a GPU, whatever the scene.
    MatrixFree,
}

impl PathWish {
    /// The name in flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::List => Path::List.name(),
            Self::Lattice => Path::Lattice.name(),
            Self::MatrixFree => Path::MatrixFree.name(),
        }
    }
}

/// A path with what is known of the scene.
#[derive(Clone, Debug)]
pub enum PathChoice {
    /// The list, and why not the lattice, where that was looked for.
    List(Option<&'static str>),
    /// The lattice.
    Lattice(Arc<LatticeScene>),
    /// A stencil and rows, and why not the lattice alone.
    Mixed(Arc<MixedScene>, &'static str),
    /// A search in every sum, and why not the lattice, where that was looked for.
    MatrixFree(Option<&'static str>),
}

impl PathChoice {
    /// The path of `problem` on this kind of machine: the fastest that `wish` allows.
    ///
    /// # Errors
    /// [`SolverError::NoLattice`] where the lattice is wanted and cannot be had,
    /// [`SolverError::MatrixFreeOnCpu`].
    pub fn new(
        problem: &Problem,
        machine: MachineKind,
        wish: PathWish,
    ) -> Result<Self, SolverError> {
        let found = match (wish, machine) {
            (PathWish::List, _) => return Ok(Self::List(None)),
            (PathWish::MatrixFree, MachineKind::Gpu(_)) => return Ok(Self::MatrixFree(None)),
            (PathWish::MatrixFree, MachineKind::Cpu) => return Err(SolverError::MatrixFreeOnCpu),
            (_, machine) => match LatticeScene::of(problem) {
                Ok(scene) => Ok(Self::Lattice(Arc::new(scene))),
                Err(why) => Self::mixed(problem, machine, wish, why),
            },
        };
        match (found, wish) {
            (Ok(choice), _) => Ok(choice),
            (Err(why), PathWish::Lattice) => Err(SolverError::NoLattice { why }),
            (Err(why), _) => Ok(Self::List(Some(why))),
        }
    }

    /// Its kind.
    pub fn path(&self) -> Path {
        match self {
            Self::List(_) => Path::List,
            Self::Lattice(_) => Path::Lattice,
            Self::Mixed(..) => Path::Mixed,
            Self::MatrixFree(_) => Path::MatrixFree,
        }
    }

    /// The mixed path, if it can be had, and pays or is wished for; `why` not the lattice alone.
    fn mixed(
        problem: &Problem,
        machine: MachineKind,
        wish: PathWish,
        why: &'static str,
    ) -> Result<Self, &'static str> {
        let scene = MixedScene::of(problem)?;
        if machine != MachineKind::Cpu && !gpu::lattice::are_few(&scene) {
            return Err("particles have more diffusivities than a device tells apart");
        }
        if wish == PathWish::Lattice || pays(&scene, problem.particles.len()) {
            return Ok(Self::Mixed(Arc::new(scene), why));
        }
        Err("too few particles have the lattice's stencil")
    }
}

/// Whether a step of the mixed path is expected to be faster than one of the list: the stencil goes
/// over all sites, and a row of its own costs what it costs in the list, or on a CPU less, where others share it.
///
/// Measured in 3-D with 25 neighbours, 720 000 to 1 000 000 particles: boxes with holes and slabs of
/// two materials, of which 5.4, 31.5 and 57.8 % (holes) and 18.0, 38.0 and 66.0 % (slabs) have rows,
/// ran 4.6, 2.3, 1.07 and 2.6, 1.8, 1.09 times as fast as the list; this expects 3.8, 1.8, 1.17 and
/// 2.6, 1.7, 1.16. The round shipped cases, 17 to 31 % rows in 52 to 64 % of their box: 2.1, 1.8, 1.5
/// against 2.1, 1.4, 1.5. That was before rows shared lines on the CPU, where it errs towards the list now.
fn pays(scene: &MixedScene, particles: usize) -> bool {
    let rows = scene.rows() as f64 / particles as f64;
    STENCIL_COST / scene.filled() + rows < WORTH_IT
}

/// What a site costs by the stencil, over a row of the list.
const STENCIL_COST: f64 = 0.2;

/// Above this part of the list's cost the mixed path is not taken.
const WORTH_IT: f64 = 0.9;

impl Path {
    /// The name in flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::List => "list",
            Self::Lattice => "lattice",
            Self::Mixed => "mixed",
            Self::MatrixFree => "matrix-free",
        }
    }
}
