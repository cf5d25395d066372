//! From a scene to a backend that holds it: survey, step, plan and operator.

use std::sync::Arc;

use super::memory::{SHARE, free_memory};
use crate::model::Problem;
use crate::model::lattice::{LatticeScene, MixedScene};
use crate::model::operator::rows::{Rows, Survey, assemble, cell_grid, survey, wall_fold};
use crate::model::operator::{FoldNeeds, SomeRows, SourceRows};
use crate::solver::cpu::CpuBackend;
use crate::solver::gpu::{GpuBackend, GpuOptions};
use crate::solver::{
    Backend, Machine, MachineKind, Path, PathChoice, Plan, SolverError, Step, choose_step,
    measure_limit,
};

/// What is done with a scene that is ready on a machine, whatever the backend.
pub trait Driver {
    /// What comes of it.
    type Output;

    /// Works with `backend`, which holds the initial state.
    fn drive<B: Backend + 'static>(self, prepared: Prepared, backend: B) -> Self::Output;
}

/// Prepares `problem`, puts it on `machine` along the path of `choice` and has `driver` work with
/// it.
///
/// # Errors
/// As [`prepare`]; a device that fails.
pub fn start<D: Driver>(
    problem: &Problem,
    machine: &Machine,
    choice: PathChoice,
    allow_unstable: bool,
    driver: D,
) -> Result<D::Output, SolverError> {
    // Only the CPU path keeps the rows; a device builds its own.
    let keep_rows = matches!(machine, Machine::Cpu);
    let (prepared, operator) = prepare(problem, machine.kind(), choice, allow_unstable, keep_rows)?;
    Ok(match (machine, operator) {
        (Machine::Gpu { device, precision }, Some(Operator::Lattice { scene: lattice, walls })) => {
            let (options, dt) = (GpuOptions::new(*precision), prepared.step.dt);
            let backend = GpuBackend::lattice(problem, &lattice, walls, dt, device, options)?;
            driver.drive(prepared, backend)
        }
        (Machine::Gpu { device, precision }, Some(Operator::Mixed { scene: mixed, rows })) => {
            let (options, dt) = (GpuOptions::new(*precision), prepared.step.dt);
            let backend = GpuBackend::mixed(problem, &mixed, &rows, dt, device, options)?;
            driver.drive(prepared, backend)
        }
        (Machine::Gpu { device, precision }, _) => {
            let prepared = prepared.within_memory(problem, machine);
            let dt = prepared.step.dt;
            let (prepared, backend) = by_neighbors(problem, prepared, |matrix_free| {
                let options = GpuOptions { matrix_free, ..GpuOptions::new(*precision) };
                GpuBackend::with_options(problem, dt, device, options)
            })?;
            driver.drive(prepared, backend)
        }
        (Machine::Cpu, Some(Operator::Rows { order, rows })) => {
            driver.drive(prepared, CpuBackend::new(problem, order, rows))
        }
        (Machine::Cpu, Some(Operator::Lattice { scene: lattice, walls })) => {
            driver.drive(prepared, CpuBackend::lattice(problem, lattice, walls))
        }
        (Machine::Cpu, Some(Operator::Mixed { scene: mixed, rows })) => {
            driver.drive(prepared, CpuBackend::mixed(problem, mixed, rows))
        }
        (Machine::Cpu, None) => unreachable!("the CPU path has asked for its operator"),
    })
}

/// The backend that `build` makes by list, or matrix-free where that is planned or where a list, which nobody
/// has asked for, finds no room.
fn by_neighbors<B>(
    problem: &Problem,
    mut prepared: Prepared,
    build: impl Fn(bool) -> Result<B, SolverError>,
) -> Result<(Prepared, B), SolverError> {
    let backend =
        match (build(prepared.plan.path == Path::MatrixFree), prepared.matrix_free(problem)) {
            (Err(error), Some(plan)) if error.is_lack_of_room() => {
                prepared.plan = plan;
                build(true)?
            }
            (built, _) => built?,
        };
    Ok((prepared, backend))
}

/// What is known of a run before its first step.
#[derive(Debug)]
pub struct Prepared {
    /// What a walk over all pairs told.
    pub survey: Survey,
    /// The step, and what it was judged by.
    pub step: Step,
    /// What will run.
    pub plan: Plan,
}

impl Prepared {
    /// The same with a plan for the memory that is free, where `machine` shares that: matrix-free where a
    /// list would take too much. Other devices say by themselves when they have no more.
    #[must_use]
    pub fn within_memory(mut self, problem: &Problem, machine: &Machine) -> Self {
        let Some(plan) = self.matrix_free(problem).filter(|_| machine.shares_memory()) else {
            return self;
        };
        let needed = self.plan.memory_bytes(problem, self.survey.entries);
        if needed as f64 > SHARE * free_memory() as f64 {
            self.plan = plan;
        }
        self
    }

    /// The plan without a list, where it may take the place of one.
    fn matrix_free(&self, problem: &Problem) -> Option<Plan> {
        self.plan.matrix_free(problem, self.survey.entries)
    }
}

/// The operator of a scene on the CPU.
#[derive(Debug)]
pub enum Operator {
    /// Assembled rows.
    Rows {
        /// The particle at each rank.
        order: Vec<u32>,
        /// The rows, by rank.
        rows: Rows,
    },
    /// A stencil.
    Lattice {
        /// The lattice.
        scene: Arc<LatticeScene>,
        /// What walls add to it, by site.
        walls: SourceRows,
    },
    /// A stencil and rows.
    Mixed {
        /// The lattice.
        scene: Arc<MixedScene>,
        /// The rows, by site.
        rows: SomeRows,
    },
}

/// Surveys the pairs of `problem`, chooses its step and plans its run on the path of `choice`; with
/// `keep`, its rows as well. A stencil takes no room, and always comes with it.
///
/// # Errors
/// A step above the stability limit; coincident particles where the kernel has no weight for them;
/// walls and surfaces that make no sense.
pub fn prepare(
    problem: &Problem,
    machine: MachineKind,
    choice: PathChoice,
    allow_unstable: bool,
    keep: bool,
) -> Result<(Prepared, Option<Operator>), SolverError> {
    let (survey, operator) = match &choice {
        PathChoice::List(_) | PathChoice::MatrixFree(_) => {
            return prepare_list(problem, machine, &choice, allow_unstable, keep);
        }
        PathChoice::Lattice(scene) => {
            let (walls, is_skew) = lattice_walls(problem, scene)?;
            let survey = Survey { symmetric: !is_skew, ..scene.survey(problem) };
            (survey, Operator::Lattice { scene: Arc::clone(scene), walls })
        }
        PathChoice::Mixed(scene, _) => {
            let (survey, rows) = scene.assemble(problem);
            SolverError::check_walls(problem, &survey)?;
            (survey, Operator::Mixed { scene: Arc::clone(scene), rows })
        }
    };
    // A measurement of the limit, for a given step above the safe bound, takes the rows.
    let step = choose_step(problem, choice.path(), &survey, allow_unstable, || {
        let grid = cell_grid(problem);
        measure_limit(problem, grid.order(), &assemble(problem, &grid).1)
    })?;
    let plan = Plan::new(problem, machine, &choice, survey.entries);
    Ok((Prepared { survey, step, plan }, Some(operator)))
}

/// What walls add to a lattice beyond its stencil, by site, and whether they leave the matrix
/// unsymmetric.
///
/// # Errors
/// Walls that make no sense.
pub fn lattice_walls(
    problem: &Problem,
    scene: &LatticeScene,
) -> Result<(SourceRows, bool), SolverError> {
    if FoldNeeds::of(problem) < FoldNeeds::Steady {
        return Ok((SourceRows::default(), false));
    }
    let grid = cell_grid(problem);
    let fold = wall_fold(problem, &grid);
    if let Some(fault) = fold.fault {
        return Err(SolverError::of_fault(problem, fault));
    }
    let sites = scene.sites();
    let rows = fold.rows.renumbered(|rank| sites(grid.order()[rank as usize]));
    Ok((rows, fold.is_skew))
}

fn prepare_list(
    problem: &Problem,
    machine: MachineKind,
    choice: &PathChoice,
    allow_unstable: bool,
    keep: bool,
) -> Result<(Prepared, Option<Operator>), SolverError> {
    let grid = cell_grid(problem);
    let (survey, mut rows) = if keep {
        let (survey, rows) = assemble(problem, &grid);
        (survey, Some(rows))
    } else {
        (survey(problem, &grid), None)
    };
    SolverError::check_coincident(problem, &survey)?;
    SolverError::check_walls(problem, &survey)?;
    let step = choose_step(problem, choice.path(), &survey, allow_unstable, || {
        let rows = rows.get_or_insert_with(|| assemble(problem, &grid).1);
        measure_limit(problem, grid.order(), rows)
    })?;
    let plan = Plan::new(problem, machine, choice, survey.entries);
    let rows = rows.filter(|_| keep);
    let operator = rows.map(|rows| Operator::Rows { order: grid.into_order(), rows });
    Ok((Prepared { survey, step, plan }, operator))
}

#[cfg(test)]
#[path = "prepare_tests.rs"]
mod tests;
