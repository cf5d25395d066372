//! What a run does without, why, and how many bytes that saves.

use glam::DVec3;

use super::{Needs, Path, Plan, percent};
use crate::model::Problem;
use crate::model::operator::FoldNeeds;
use crate::model::wall::WalledFace;
use crate::solver::MachineKind;

/// Something that a run does without.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// What.
    pub what: &'static str,
    /// Why the scene does not need it.
    pub why: String,
    /// Bytes that are not allocated.
    pub bytes_saved: u64,
}

impl Plan {
    /// What a run does without.
    pub(super) fn left_out(&self, problem: &Problem, entries: u64) -> Vec<LeftOut> {
        let Self { machine, path, needs, .. } = *self;
        let particles = problem.particles.len() as u64;
        let real = machine.precision().bytes();
        let mut list = Vec::new();
        let mut leave = |what, why: &str, bytes_saved| {
            list.push(LeftOut { what, why: why.to_owned(), bytes_saved });
        };
        let of_list = entries * (4 + real) + particles * 8;
        match path {
            Path::Lattice => {
                let why = "the particles fill a lattice: the sum over neighbours is one stencil";
                leave("neighbour list and weights", why, of_list);
                // Walls that act are folded by a walk over cells.
                if needs.walls < FoldNeeds::Steady {
                    leave("sorting into cells", why, particles * 4);
                }
            }
            Path::Mixed => {
                let share = percent(self.rows_share(problem));
                let why = format!("a stencil holds but for {share} of the particles");
                let saved = of_list.saturating_sub(self.bytes_of_rows(problem, entries));
                leave("neighbour list and weights", &why, saved);
                let why = "the particles are on a lattice: neighbours are known by their place";
                leave("sorting into cells", why, particles * 4);
            }
            Path::List => leave_of_list(problem, machine, needs, &mut leave),
            Path::MatrixFree => {
                let why = match self.why_no_lattice {
                    Some(_) => {
                        "the list finds no room: neighbours are searched for in every step, slowly"
                    }
                    None => "neighbours are searched for in every step",
                };
                let places = particles * (8 + problem.dimension as u64 * real);
                leave("neighbour list and weights", why, of_list.saturating_sub(places));
                leave_of_list(problem, machine, needs, &mut leave);
            }
        }
        leave_walls(problem, needs.walls, &mut leave);
        if !needs.held {
            // The rows of the CPU path would keep the starts of a second set, the GPU an accumulator.
            let bytes = match (path, machine) {
                (Path::Lattice | Path::Mixed, _) => 0,
                (_, MachineKind::Cpu) => particles * 8,
                (Path::List | Path::MatrixFree, MachineKind::Gpu(_)) => particles * 2 * real,
            };
            leave("exchange of held particles", "no particle is held", bytes);
        }
        if !problem.has_curves() {
            let why = "nothing melts, and no conductivity depends on temperature";
            leave("enthalpy", why, particles * self.bytes_of_enthalpy());
        }
        if problem.time.end == 0.0 {
            leave("time steps", "the simulated time is 0", 0);
        }
        list
    }
}

fn leave_of_list(
    problem: &Problem,
    machine: MachineKind,
    needs: Needs,
    leave: &mut impl FnMut(&'static str, &str, u64),
) {
    if machine != MachineKind::Cpu && !needs.coefficients {
        let why = "all particles share one volume and one material's properties";
        let bytes = problem.particles.len() as u64 * 4 * machine.precision().bytes();
        leave("volume and properties by particle", why, bytes);
    }
    if !needs.periodic {
        leave("nearest images", "no axis is periodic", 0);
    }
    if problem.dimension < 3 {
        let why = "the scene has fewer than three dimensions";
        leave("neighbour cells along the axes past the dimension", why, 0);
    }
}

/// Bytes of a particle: position, volume, value and material.
pub(super) const PARTICLE_BYTES: u64 = 42;

fn leave_walls(
    problem: &Problem,
    walls: FoldNeeds,
    leave: &mut impl FnMut(&'static str, &str, u64),
) {
    match walls {
        FoldNeeds::None => return leave("wall fold", "no face has a wall with ghosts", 0),
        FoldNeeds::Insulated => leave("wall sources", "every wall with ghosts is insulated", 0),
        FoldNeeds::Steady => {
            leave(
                "sources at every step",
                "what walls and sources impose does not change in time",
                0,
            );
        }
        FoldNeeds::Changing => {}
    }
    let faces = WalledFace::all(&problem.walls, problem.dimension);
    let reach = problem.kernel.cutoff();
    let ghosts = |walled: &WalledFace<'_>| {
        let near = |x: &&DVec3| walled.face().distance(&problem.domain, **x) < reach;
        problem.particles.position.iter().filter(near).count() as u64
    };
    let count: u64 = faces.iter().map(ghosts).sum();
    if count > 0 {
        let why = "the particles are at rest: their ghosts are folded into the matrix";
        leave("ghost particles", why, count * PARTICLE_BYTES);
    }
}
