//! What runs for a scene, and what is left out because the scene does not need it.

use std::sync::Arc;

use glam::DVec3;

use super::{MachineKind, SolverError, gpu};
use crate::model::Problem;
use crate::model::lattice::{LatticeScene, MixedScene};
use crate::model::operator::FoldNeeds;
use crate::model::wall::WalledFace;

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
            (_, MachineKind::Gpu(_)) if !problem.has_one_curve() => {
                Err("several materials, of which one melts or conducts as its temperature")
            }
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
/// over all sites, and a stored row costs what it costs in the list.
///
/// Measured in 3-D with 25 neighbours, 720 000 to 1 000 000 particles: boxes with holes and slabs of
/// two materials, of which 5.4, 31.5 and 57.8 % (holes) and 18.0, 38.0 and 66.0 % (slabs) have rows,
/// ran 4.6, 2.3, 1.07 and 2.6, 1.8, 1.09 times as fast as the list; this expects 3.8, 1.8, 1.17 and
/// 2.6, 1.7, 1.16. The round shipped cases, 17 to 31 % rows in 52 to 64 % of their box: 2.1, 1.8, 1.5
/// against 2.1, 1.4, 1.5.
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

    /// Bytes of the rows of the mixed path, about: with the mean number of neighbours.
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
            if problem.has_curves() {
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
        let of_operator = match self.path {
            // Two states and the saved one; order and start, or length, of each row.
            Path::List => entries * (4 + real) + particles * (3 * state + 8),
            // Two states and the saved one; what is sorted, and a cell's start a particle.
            Path::MatrixFree => {
                particles * (3 * state + 8 + problem.dimension as u64 * real)
                    + self.bytes_of_table(problem)
            }
            Path::Lattice | Path::Mixed => {
                let sites = self.mixed.map_or(particles, |mixed| mixed.sites);
                // A device has a byte for the kind of each site.
                let kind = u64::from(self.path == Path::Mixed && self.machine != MachineKind::Cpu);
                let by_site = 3 * state + kind + if self.reorders { 4 } else { 0 };
                sites * by_site + self.bytes_of_rows(problem, entries)
            }
        };
        // An enthalpy, and the copy of it that a run falls back to; which curve each follows, where they differ.
        let of_enthalpy = if problem.has_curves() { 2 * state } else { 0 };
        let of_curves = if problem.has_one_curve() { 0 } else { 4 };
        let enthalpy = particles * (of_enthalpy + of_curves);
        of_operator + enthalpy + self.bytes_of_sources(problem)
    }

    /// What a run does without.
    fn left_out(&self, problem: &Problem, entries: u64) -> Vec<LeftOut> {
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
            leave("enthalpy", why, particles * 2 * machine.precision().state_bytes());
        }
        if problem.time.end == 0.0 {
            leave("time steps", "the simulated time is 0", 0);
        }
        list
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
const PARTICLE_BYTES: u64 = 42;

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

#[cfg(test)]
mod tests {
    use super::super::Precision;
    use super::*;
    use crate::model::scenes::lattice;
    use crate::model::{Condition, Conductivity, Face, KernelKind, Material, ScalarField, Wall};

    fn what(problem: &Problem, machine: MachineKind) -> Vec<(&'static str, u64)> {
        let plan = Plan::new(problem, machine, &PathChoice::List(None), 0);
        plan.left_out.iter().map(|left| (left.what, left.bytes_saved)).collect()
    }

    #[test]
    fn a_plain_scene_leaves_everything_out() {
        let problem = lattice(KernelKind::CubicSpline, 3, [4, 4, 4], 0.5, 2.0);
        let expected = [
            ("volume and properties by particle", 1024),
            ("nearest images", 0),
            ("wall fold", 0),
            ("exchange of held particles", 512),
            ("enthalpy", 512),
        ];
        assert_eq!(what(&problem, MachineKind::Gpu(Precision::F32)), expected);
    }

    #[test]
    fn a_list_that_nobody_asked_for_gives_way_to_a_search() {
        let problem = lattice(KernelKind::CubicSpline, 3, [4, 4, 4], 0.5, 2.0);
        let gpu = MachineKind::Gpu(Precision::F32);
        let plan = |machine, choice| Plan::new(&problem, machine, &choice, 1000);
        let listed = plan(gpu, PathChoice::List(Some("moved")));
        let searched = listed.matrix_free(&problem, 1000).expect("a plan");
        assert_eq!((searched.path, searched.why_no_lattice), (Path::MatrixFree, Some("moved")));
        assert_eq!(listed.memory_bytes(&problem, 1000), 8 * 1000 + 64 * 20);
        assert_eq!(searched.memory_bytes(&problem, 1000), 64 * (12 + 8 + 12));
        let passes = searched.passes(&problem);
        assert!(passes.contains(&"gather") && !passes.contains(&"list"), "{passes:?}");
        for kept in [
            plan(gpu, PathChoice::List(None)),
            plan(MachineKind::Cpu, PathChoice::List(Some("moved"))),
        ] {
            assert_eq!(kept.matrix_free(&problem, 1000), None);
        }
    }

    #[test]
    fn a_scene_that_needs_everything_leaves_nothing_out() {
        let mut problem = lattice(KernelKind::CubicSpline, 3, [4, 4, 4], 0.5, 2.0);
        problem.held = vec![0];
        problem.domain.periodic = [true, false, false];
        problem.particles.volume[5] *= 2.0;
        let value = Condition::value(ScalarField::new("t", |_, t| t));
        problem.walls = vec![wall(value)];
        let conductivity = Conductivity::of_points(vec![[0.0, 1.0], [100.0, 2.0]]);
        problem.materials = vec![Material::thermal("m", &conductivity, 1.0, None, 1.0)];
        // But for the ghosts of the 32 particles near the wall.
        let ghosts = ("ghost particles", 32 * PARTICLE_BYTES);
        assert_eq!(what(&problem, MachineKind::Gpu(Precision::F64)), [ghosts]);
    }

    fn wall(condition: Condition) -> Wall {
        let face = Face { axis: 1, upper: true };
        Wall { name: "wall".into(), face, covers: None, condition }
    }

    #[test]
    fn walls_are_folded_and_evaluated_no_more_than_they_need() {
        let mut problem = lattice(KernelKind::CubicSpline, 2, [4, 4, 1], 0.5, 2.0);
        let mut found = |condition: Condition| {
            problem.walls = vec![wall(condition)];
            let plan = Plan::new(&problem, MachineKind::Cpu, &PathChoice::List(None), 0);
            let has = |what: &str| plan.left_out.iter().any(|left| left.what == what);
            let passes = plan.passes(&problem);
            let runs = |pass: &str| passes.contains(&pass);
            let left = [has("wall fold"), has("wall sources"), has("sources at every step")];
            (left, [runs("wall_fold"), runs("exchange"), runs("sources")])
        };
        let changing = ScalarField::new("t", |_, t| t);
        let steady = ScalarField::constant(3.0);
        assert_eq!(found(Condition::free()), ([true, false, false], [false, false, false]));
        assert_eq!(found(Condition::insulated()), ([false, true, false], [true, false, false]));
        assert_eq!(found(Condition::flux(steady)), ([false, false, true], [true, true, false]));
        assert_eq!(found(Condition::value(changing)), ([false, false, false], [true, true, true]));
    }

    #[test]
    fn materials_of_one_diffusivity_count_as_one() {
        let mut problem = lattice(KernelKind::CubicSpline, 2, [4, 4, 1], 0.5, 2.0);
        problem.materials.push(problem.materials[0].clone());
        assert!(!Needs::of(&problem).coefficients);
        problem.materials[1].conductivity *= 2.0;
        assert!(!Needs::of(&problem).coefficients, "no particle is made of it");
        problem.particles.material[3] = 1;
        assert!(Needs::of(&problem).coefficients);
    }
}
