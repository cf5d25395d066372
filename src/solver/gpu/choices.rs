//! The passes of scenes whose neighbours are listed or searched for.

use super::curve_passes::{CurveKind, CurvePasses};
use super::fronts::FrontMakes;
use super::passes::{
    CHUNK, COMBINATION, GRID, HELD_BIT, MARKED_MASK, NO_SLOT, SLICE_ROWS, SOURCE_STEPS, STATE_END,
    STEP_SIZE, WALL_BIT, WALL_SETUP, WHOLE, WallTerms, arithmetic, block, given, read, value,
    write,
};
use crate::gpu::{Binding, Constant, Element, PassSource, Real};
use crate::model::kernel::SUPPORT_MARGIN;
use crate::model::{KernelKind, PairMean};
use crate::solver::Precision;

/// The sum over neighbours that are searched for.
const SEARCHED: &str = "rows/searched";

/// Where the sums over neighbours find them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neighbors {
    /// In the list, with their weights.
    Listed,
    /// In the cells around, in every sum anew.
    Searched {
        /// Whether walls add to the weights of some pairs, or anything else to some rows.
        folded: bool,
    },
}

/// What a scene needs of the shaders: nothing else is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choices {
    /// The kernel.
    pub kernel: KernelKind,
    /// How the diffusivities of a pair are joined.
    pub pair_mean: PairMean,
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
    /// Whether some particles keep their value.
    pub held: bool,
    /// What walls add to a step.
    pub walls: WallTerms,
    /// Whether all particles share one volume, conductivity and capacity.
    pub uniform: bool,
    /// Where the sums over neighbours find them.
    pub neighbors: Neighbors,
    /// The precision.
    pub precision: Precision,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
}

impl Choices {
    /// What `real` means in the shaders.
    pub fn real(&self) -> Real {
        self.precision.real()
    }

    /// Puts every particle into the cell where its offset points.
    pub fn bin(&self) -> PassSource {
        self.on_grid(
            "bin",
            &["grid", self.domain()],
            vec![write("offset", Element::Real), write("cell", Element::U32)],
        )
    }

    /// Counts the particles of each cell.
    pub fn cell_count(&self) -> PassSource {
        self.on_grid(
            "cell_count",
            &[],
            vec![read("cell", Element::U32), write("count", Element::AtomicU32)],
        )
    }

    /// Puts the particles of each cell side by side.
    pub fn scatter(&self) -> PassSource {
        self.on_grid(
            "scatter",
            &[],
            vec![
                read("cell", Element::U32),
                read("cell_start", Element::U32),
                write("taken", Element::AtomicU32),
                write("scattered", Element::U32),
            ],
        )
    }

    /// Sorts the particles of each cell by index.
    pub fn rank(&self) -> PassSource {
        self.on_grid(
            "rank",
            &[],
            vec![
                read("cell", Element::U32),
                read("cell_start", Element::U32),
                read("scattered", Element::U32),
                write("order", Element::U32),
            ],
        )
    }

    /// Copies offsets and cells into sorted order.
    pub fn gather(&self) -> PassSource {
        self.on_grid(
            "gather",
            &[],
            vec![
                read("order", Element::U32),
                read("offset", Element::Real),
                read("cell", Element::U32),
                write("sorted_offset", Element::Real),
                write("sorted_cell", Element::U32),
            ],
        )
    }

    /// Counts the neighbours of each row.
    pub fn neighbor_count(&self) -> PassSource {
        self.on_grid(
            "neighbor_count",
            &["grid", self.domain(), "search"],
            vec![
                read("offset", Element::Real),
                read("cell", Element::U32),
                read("cell_start", Element::U32),
                write("row_length", Element::U32),
            ],
        )
    }

    /// Writes the neighbours of each row of a chunk with their weights.
    pub fn list(&self) -> PassSource {
        let bindings = vec![
            block("chunk", &CHUNK),
            read("offset", Element::Real),
            read("cell", Element::U32),
            read("cell_start", Element::U32),
            read("slice_start", Element::U32),
            write("neighbor", Element::U32),
            write("weight", Element::Real),
        ];
        let mut source = self.on_grid("list", &["grid", self.domain(), "search"], bindings);
        self.add_pair_weight(&mut source);
        source
    }

    /// Adds the walls to the rows of a chunk.
    pub fn wall_fold(&self) -> PassSource {
        let bindings = vec![
            block("chunk", &CHUNK),
            read("row_mark", Element::U32),
            read("slice_start", Element::U32),
            write("neighbor", Element::U32),
            write("weight", Element::Real),
            read("fold", Element::U32x4),
            read("fold_neighbor", Element::U32),
            read("fold_weight", Element::Real),
        ];
        self.source(WALL_SETUP, &[], bindings)
    }

    /// One explicit Euler step of the rows of a chunk.
    pub fn step(&self) -> PassSource {
        let mut source = self.on_rows("step");
        source.slots.push(STATE_END.to_owned());
        source
    }

    /// The same of enthalpies that follow `curves`; where lists are `kept`, what flows are to be looked for of is put
    /// on theirs.
    pub fn enthalpy_step(&self, curves: CurvePasses, kept: bool) -> PassSource {
        let mut source = self.step();
        curves.end_step(&mut source, kept);
        source
    }

    /// The rate of change of the rows of a chunk.
    pub fn rate(&self) -> PassSource {
        self.on_rows("rate")
    }

    /// Shares of a field and of its rate, for the rows of a chunk.
    pub fn combine(&self) -> PassSource {
        let mut source = self.on_rows("combine");
        source.bindings.push(block("factors", &COMBINATION));
        source.slots.push("vector/combined".to_owned());
        source
    }

    /// What held particles and walls give to the rows of a chunk, of the same combination.
    pub fn list_given(&self) -> PassSource {
        let mut source = PassSource { pass: "list_given", ..self.combine() };
        source.bindings.extend(given(self.precision));
        source.bindings.push(read("exception", Element::U32x4));
        source.slots.push("vector/given".to_owned());
        source
    }

    /// The factor of each row's own value in its rate.
    pub fn diagonal(&self) -> PassSource {
        let mut source = self.on_rows("diagonal");
        for slot in source.slots.iter_mut().filter(|slot| *slot == SEARCHED) {
            *slot = "rows/searched_diagonal".to_owned();
        }
        source
    }

    /// What fronts change of a step of the rows of a chunk, or the tiles where they may.
    pub fn front(&self, curves: CurvePasses, makes: FrontMakes) -> PassSource {
        let mut source = Self { walls: WallTerms::None, ..*self }.on_rows("front");
        makes.add_to(&mut source, curves, false, true);
        source
    }

    /// Evaluates the pair functions at given arguments: a diagnostic.
    pub fn probe(&self) -> PassSource {
        let bindings = vec![
            read("arguments", Element::Real2),
            write("shape", Element::Real2),
            write("mean", Element::Real),
        ];
        let [kernel, mean] = self.pair_functions();
        self.source("probe", &[&kernel, &mean], bindings)
    }

    /// Every pass that these choices may name.
    pub fn all(&self) -> Vec<PassSource> {
        let mut all = vec![
            self.bin(),
            self.cell_count(),
            self.scatter(),
            self.rank(),
            self.gather(),
            self.neighbor_count(),
            self.list(),
            self.wall_fold(),
            self.step(),
            self.rate(),
            self.combine(),
            self.list_given(),
            self.diagonal(),
            self.probe(),
        ];
        let Self { precision, workgroup_size, .. } = *self;
        for kind in CurveKind::all(precision) {
            let curves = CurvePasses { precision, workgroup_size, kind };
            all.extend([false, true].map(|kept| self.enthalpy_step(curves, kept)));
            all.extend(FrontMakes::ALL.map(|makes| self.front(curves, makes)));
        }
        all
    }

    fn domain(&self) -> &'static str {
        if self.periodic.contains(&true) { "domain/periodic" } else { "domain/open" }
    }

    fn pair_functions(&self) -> [String; 2] {
        [format!("kernel/{}", self.kernel.name()), format!("operator/{}", self.pair_mean.name())]
    }

    fn on_grid(&self, pass: &'static str, slots: &[&str], bindings: Vec<Binding>) -> PassSource {
        let mut source = self.source(pass, slots, vec![block("grid", &GRID)]);
        source.bindings.extend(bindings);
        source
    }

    /// The passes that sum over neighbours share their buffers.
    fn on_rows(&self, pass: &'static str) -> PassSource {
        let mut source = self.source(pass, &[], vec![block("chunk", &CHUNK)]);
        match self.neighbors {
            Neighbors::Listed => self.add_list(&mut source),
            Neighbors::Searched { folded } => self.add_search(&mut source, folded),
        }
        source.bindings.extend([
            read("before", value(self.precision)),
            write("after", value(self.precision)),
            block("step_size", &STEP_SIZE),
        ]);
        let held = if self.held {
            source.bindings.push(write("exchange", Element::Real2));
            "domain/some_held"
        } else {
            "domain/all_free"
        };
        source.bindings.extend(self.walls.bindings());
        let arithmetic = arithmetic(self.precision);
        let slots = arithmetic.iter().chain([&WHOLE, &held]).chain(self.walls.slots());
        source.slots.extend(slots.map(|&slot| slot.to_owned()));
        source
    }

    fn add_list(&self, source: &mut PassSource) {
        source.bindings.extend([
            read("row_mark", Element::U32),
            read("slice_start", Element::U32),
            read("neighbor", Element::U32),
            read("weight", Element::Real),
        ]);
        source.slots.push("rows/listed".to_owned());
    }

    fn add_search(&self, source: &mut PassSource, folded: bool) {
        source.bindings.extend([
            block("grid", &GRID),
            read("offset", Element::Real),
            read("cell", Element::U32),
            read("cell_start", Element::U32),
        ]);
        self.add_pair_weight(source);
        if self.held || folded {
            source.bindings.push(read("row_mark", Element::U32));
        }
        let walls = if folded {
            source.bindings.extend([
                read("fold", Element::U32x4),
                read("fold_neighbor", Element::U32),
                read("fold_weight", Element::Real),
            ]);
            "rows/folded"
        } else {
            "rows/not_folded"
        };
        let slots = ["grid", self.domain(), "search", SEARCHED, walls];
        source.slots.extend(slots.map(str::to_owned));
    }

    /// Adds what weights of pairs are computed from.
    fn add_pair_weight(&self, source: &mut PassSource) {
        let material = if self.uniform {
            "material/uniform"
        } else {
            source.bindings.push(read("coefficient", Element::Real4));
            "material/table"
        };
        source.slots.extend([material, "pair_weight"].map(str::to_owned));
        source.slots.extend(self.pair_functions());
    }

    fn source(&self, pass: &'static str, slots: &[&str], bindings: Vec<Binding>) -> PassSource {
        let [periodic_x, periodic_y, periodic_z] = self.periodic;
        PassSource {
            pass,
            real: self.real(),
            workgroup_size: self.workgroup_size,
            constants: vec![
                ("DIMENSION", Constant::Count(self.dimension as u32)),
                ("PERIODIC_X", Constant::Flag(periodic_x)),
                ("PERIODIC_Y", Constant::Flag(periodic_y)),
                ("PERIODIC_Z", Constant::Flag(periodic_z)),
                ("SLICE_ROWS", Constant::Count(SLICE_ROWS)),
                ("HELD_BIT", Constant::Count(HELD_BIT)),
                ("WALL_BIT", Constant::Count(WALL_BIT)),
                ("MARKED_MASK", Constant::Count(MARKED_MASK)),
                ("NO_SLOT", Constant::Count(NO_SLOT)),
                ("SOURCE_STEPS", Constant::Count(SOURCE_STEPS)),
                ("CUTOFF_SQUARED", Constant::Real(SUPPORT_MARGIN * SUPPORT_MARGIN)),
            ],
            bindings,
            slots: slots.iter().map(|&slot| slot.to_owned()).collect(),
            generated: String::new(),
        }
    }
}
