//! What runs for a scene, and what is left out because the scene does not need it.

mod left_out;
mod path;

use super::{MachineKind, gpu};
use crate::model::Problem;
use crate::model::operator::{FoldNeeds, Fronts};

pub use left_out::LeftOut;
pub use path::{MixedSizes, Path, PathChoice, PathWish};

/// What runs for a scene: a pure function of the problem and the kind of machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Where it runs.
    pub machine: MachineKind,
    /// How neighbours are known.
    pub path: Path,
    /// Why it is not the lattice path, where that was looked for.
    pub why_no_lattice: Option<&'static str>,
    /// Sites and stored rows of the mixed path.
    pub mixed: Option<MixedSizes>,
    /// Whether the particles of a lattice are in another order than its sites.
    pub reorders: bool,
    /// What of the shaders and buffers the scene needs.
    pub needs: Needs,
    /// What it does not need.
    pub left_out: Vec<LeftOut>,
}

/// What a scene needs beyond the plain sum over neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Some particles keep their value.
    pub held: bool,
    /// Some axis is periodic.
    pub periodic: bool,
    /// Particles differ in volume, conductivity or capacity.
    pub coefficients: bool,
    /// What walls, surfaces and sources ask for.
    pub walls: FoldNeeds,
}

impl Needs {
    /// The needs of `problem`.
    pub fn of(problem: &Problem) -> Self {
        let volume = &problem.particles.volume;
        let same_volume = volume.iter().all(|v| v == &volume[0]);
        let material = &problem.particles.material;
        let flows = |m: &u16| {
            let material = &problem.materials[usize::from(*m)];
            (material.conductivity, material.capacity)
        };
        let same_flows =
            material.iter().all(|m| m == &material[0] || flows(m) == flows(&material[0]));
        Self {
            held: !problem.held.is_empty(),
            periodic: problem.domain.periodic[..problem.dimension].contains(&true),
            coefficients: !(same_volume && same_flows),
            walls: FoldNeeds::of(problem),
        }
    }
}

impl Plan {
    /// The plan of `problem` on this kind of machine; `entries` is the number of neighbours over
    /// all particles.
    pub fn new(problem: &Problem, machine: MachineKind, choice: &PathChoice, entries: u64) -> Self {
        let needs = Needs::of(problem);
        let (path, why_no_lattice, reorders) = match choice {
            PathChoice::List(why) => (Path::List, *why, false),
            PathChoice::MatrixFree(why) => (Path::MatrixFree, *why, false),
            PathChoice::Lattice(scene) => (Path::Lattice, None, scene.order.is_some()),
            PathChoice::Mixed(scene, why) => {
                (Path::Mixed, Some(*why), scene.lattice.order.is_some())
            }
        };
        let mixed = match choice {
            PathChoice::Mixed(scene, _) => {
                let sites = scene.lattice.counts.iter().product::<usize>() as u64;
                Some(MixedSizes { sites, rows: scene.rows() as u64 })
            }
            _ => None,
        };
        let left_out = Vec::new();
        let plan = Self { machine, path, why_no_lattice, mixed, reorders, needs, left_out };
        Self { left_out: plan.left_out(problem, entries), ..plan }
    }

    /// Bytes of the rows of the mixed path, about: with the mean number of neighbours, and as if none shared lines.
    fn bytes_of_rows(&self, problem: &Problem, entries: u64) -> u64 {
        let rows = self.mixed.map_or(0, |mixed| mixed.rows);
        let real = self.machine.precision().bytes();
        // Start, rank, row of walls and visit of each row.
        rows * entries / (problem.particles.len() as u64).max(1) * (4 + real) + rows * 20
    }

    /// Bytes of the rows of sources: rank, diagonal, its part by sources, flow, capacity and source of each
    /// on the CPU; two vectors, an exception and the sources on a device.
    fn bytes_of_sources(&self, problem: &Problem) -> u64 {
        if problem.sources.is_empty() {
            return 0;
        }
        let fed = (0..problem.particles.len()).filter(|&p| problem.is_fed(p)).count() as u64;
        let MachineKind::Gpu(precision) = self.machine else {
            return fed * 52;
        };
        let is_changing = self.needs.walls == FoldNeeds::Changing;
        let steps = if is_changing { u64::from(gpu::passes::SOURCE_STEPS) } else { 1 };
        fed * ((8 + steps) * precision.bytes() + 16)
    }

    /// Bytes of the enthalpy of a particle: its own, on a GPU one more that a step writes, and the copy that a run
    /// falls back to.
    fn bytes_of_enthalpy(&self) -> u64 {
        let states = if self.machine == MachineKind::Cpu { 2 } else { 3 };
        states * self.machine.precision().state_bytes()
    }

    /// Bytes of volume and properties by particle, which a list is built from and a search needs throughout.
    fn bytes_of_table(&self, problem: &Problem) -> u64 {
        let per_particle =
            if self.needs.coefficients { 4 * self.machine.precision().bytes() } else { 0 };
        problem.particles.len() as u64 * per_particle
    }

    /// The same, matrix-free, where that takes the place of a list that nobody has asked for.
    pub fn matrix_free(&self, problem: &Problem, entries: u64) -> Option<Self> {
        let is_list_on_gpu = self.path == Path::List && self.machine != MachineKind::Cpu;
        let choice = PathChoice::MatrixFree(Some(self.why_no_lattice.filter(|_| is_list_on_gpu)?));
        Some(Self::new(problem, self.machine, &choice, entries))
    }

    /// The passes of a run, in order.
    pub fn passes(&self, problem: &Problem) -> Vec<&'static str> {
        let mut passes = match (self.path, self.machine) {
            (Path::Lattice, _) => vec!["stencil"],
            // Rows come from the host, whatever the machine.
            (Path::Mixed, _) => vec!["stencil", "rows"],
            (Path::List, MachineKind::Cpu) => vec!["sort", "survey", "rows"],
            (Path::List, MachineKind::Gpu(_)) => {
                [&gpu::passes::SORTING[..], &gpu::passes::LISTING].concat()
            }
            (Path::MatrixFree, _) => gpu::passes::SORTING.to_vec(),
        };
        // Insulation is part of a stencil.
        let least =
            if self.path == Path::Lattice { FoldNeeds::Steady } else { FoldNeeds::Insulated };
        if self.needs.walls >= least {
            if self.path == Path::Lattice {
                passes.push("sort");
            }
            if self.path != Path::MatrixFree {
                passes.push(gpu::passes::WALL_SETUP);
            }
        }
        if problem.time.end > 0.0 {
            passes.extend(self.step_passes());
            if !problem.has_one_curve() {
                passes.push("seams");
            }
            if Fronts::of(problem).is_some() {
                passes.push("fronts");
            }
            // On a GPU the others do it.
            if problem.has_curves() && self.machine == MachineKind::Cpu {
                passes.push("enthalpy");
            }
        }
        passes
    }

    /// The passes of a step, in order.
    fn step_passes(&self) -> Vec<&'static str> {
        if let MachineKind::Gpu(precision) = self.machine {
            let mut passes = match self.path {
                Path::List | Path::MatrixFree => vec!["step"],
                Path::Lattice => gpu::lattice::step_passes(self.needs, false),
                Path::Mixed => gpu::lattice::step_passes(self.needs, true),
            };
            passes.extend(gpu::passes::looks(precision));
            return passes;
        }
        let mut passes = Vec::new();
        if self.needs.walls == FoldNeeds::Changing {
            passes.push("sources");
        }
        if self.needs.held || self.needs.walls >= FoldNeeds::Steady {
            passes.push("exchange");
        }
        passes.push("step");
        passes
    }

    /// About how many bytes the state and the operator take, but for what fills up the slices of a
    /// list on the GPU: `entries` is the number of neighbours over all particles.
    pub fn memory_bytes(&self, problem: &Problem, entries: u64) -> u64 {
        let particles = problem.particles.len() as u64;
        let precision = self.machine.precision();
        let (real, state) = (precision.bytes(), precision.state_bytes());
        let sites = self.mixed.map_or(particles, |mixed| mixed.sites);
        let of_operator = match self.path {
            // Two states and the saved one; order and start, or length, of each row.
            Path::List => entries * (4 + real) + particles * (3 * state + 8),
            // Two states and the saved one; what is sorted, and a cell's start a particle.
            Path::MatrixFree => {
                particles * (3 * state + 8 + problem.dimension as u64 * real)
                    + self.bytes_of_table(problem)
            }
            Path::Lattice | Path::Mixed => {
                // A device has a byte for the kind of each site, and one more for the steps of several curves.
                let kinds = match (self.path, self.machine) {
                    (Path::Mixed, MachineKind::Gpu(_)) => 1 + u64::from(!problem.has_one_curve()),
                    _ => 0,
                };
                let by_site = 3 * state + kinds + if self.reorders { 4 } else { 0 };
                sites * by_site + self.bytes_of_rows(problem, entries)
            }
        };
        // Which curve each follows, where they differ.
        let of_enthalpy = if problem.has_curves() { self.bytes_of_enthalpy() } else { 0 };
        let of_curves = if problem.has_one_curve() { 0 } else { 4 };
        // On a GPU a word of every tile, and four lists of tiles, where fronts may come by.
        let has_tiles = self.machine != MachineKind::Cpu && Fronts::of(problem).is_some();
        let of_fronts = if has_tiles { 5 * 4 * sites.div_ceil(gpu::TILE as u64) } else { 0 };
        let enthalpy = sites * (of_enthalpy + of_curves) + of_fronts;
        of_operator + enthalpy + self.bytes_of_sources(problem)
    }

    /// The share of the particles that have rows of their own on the mixed path.
    fn rows_share(&self, problem: &Problem) -> f64 {
        self.mixed.map_or(0.0, |mixed| mixed.rows as f64 / problem.particles.len() as f64)
    }

    /// The path in words, with why it is not the lattice.
    pub fn path_in_words(&self, problem: &Problem) -> String {
        let name = match self.path {
            Path::Mixed => {
                let share = percent(self.rows_share(problem));
                format!("{}, rows for {share} of the particles", self.path.name())
            }
            path => path.name().to_owned(),
        };
        self.why_no_lattice.map_or(name.clone(), |why| format!("{name}: {why}"))
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

#[cfg(test)]
mod tests;
