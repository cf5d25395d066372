//! The passes of a scene: which shader files, constants and buffers make each.

use crate::gpu::{Binding, BlockLayout, Buffer, Constant, Element, Holds, PassSource};
use crate::model::operator::SourceRows;
use crate::solver::Precision;

pub use super::choices::{Choices, Neighbors};

/// The slot of a state in one buffer, as sums find it.
pub(super) const WHOLE: &str = "state/whole";

/// The slot of a state in parts.
pub(super) const SPLIT: &str = "lattice/split";

/// The end of a step whose state is what the operator acts on.
pub(super) const STATE_END: &str = "end/state";

/// Rows of a slice of the neighbour list: the invocations that most GPUs run in step.
pub const SLICE_ROWS: u32 = 32;

/// The bit of a row's mark that says that its particle is held.
pub const HELD_BIT: u32 = 1 << 31;

/// The bit of a row's mark that says that walls add more to the row than weights.
pub const WALL_BIT: u32 = 1 << 30;

/// The bits of a row's mark that count its neighbours or, where these are searched for, name what walls
/// add to it.
pub const MARKED_MASK: u32 = WALL_BIT - 1;

/// The slot of a row that has none.
pub const NO_SLOT: u32 = u32::MAX;

/// Bytes of a place with its slot of a wall and its place among the held.
pub(super) const EXCEPTION_BYTES: u64 = 16;

/// Steps whose wall sources the device holds at once, where they change.
pub const SOURCE_STEPS: u32 = 64;

/// Invocations a workgroup: within the least that WebGPU guarantees. See [`super::GpuOptions`].
pub const WORKGROUP_SIZE: u32 = 64;

/// The passes that sort particles into cells, in order.
pub const SORTING: [&str; 7] =
    ["bin", "cell_count", "scan_block", "scan_add", "scatter", "rank", "gather"];

/// The passes that build the neighbour list of sorted particles, in order.
pub const LISTING: [&str; 2] = ["neighbor_count", "list"];

/// The pass that adds the walls to the list.
pub const WALL_SETUP: &str = "wall_fold";

/// The passes that look at a state now and then. In f64 none looks whether it still changes.
pub fn looks(precision: Precision) -> &'static [&'static str] {
    match precision {
        Precision::F32 | Precision::Compensated => &["finite", "still"],
        Precision::F64 => &["finite"],
    }
}

/// The grid of cells and what the weights are scaled by.
pub static GRID: BlockLayout = BlockLayout {
    name: "Grid",
    counts: &["cells_x", "cells_y", "cells_z", "particles"],
    reals: &["cell_over_support_x", "cell_over_support_y", "cell_over_support_z", "weight_scale"],
};

/// The rows of a chunk of the neighbour list.
pub static CHUNK: BlockLayout =
    BlockLayout { name: "Chunk", counts: &["first_row", "end_row"], reals: &[] };

/// The step over the reference step, and a zero that compilers do not know.
pub static STEP_SIZE: BlockLayout =
    BlockLayout { name: "StepSize", counts: &["opaque_zero"], reals: &["over_reference"] };

/// Shares of a field and of its rate (a reference step), and how many particles are held.
pub static COMBINATION: BlockLayout =
    BlockLayout { name: "Combination", counts: &["held"], reals: &["share", "scale"] };

/// What walls add to a step beyond weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallTerms {
    /// Nothing.
    None,
    /// A diagonal and a source.
    Steady,
    /// The source changes in time.
    Changing,
}

impl WallTerms {
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::None, Self::Steady, Self::Changing];

    /// What `rows` need.
    pub fn of(rows: &SourceRows) -> Self {
        match (rows.is_empty(), rows.is_changing()) {
            (true, _) => Self::None,
            (false, false) => Self::Steady,
            (false, true) => Self::Changing,
        }
    }

    /// The shader files of these terms.
    pub(super) fn slots(self) -> &'static [&'static str] {
        match self {
            Self::None => &["walls/none"],
            Self::Steady => &["walls/some", "walls/steady"],
            Self::Changing => &["walls/some", "walls/changing"],
        }
    }

    /// The buffers of these terms.
    pub(super) fn bindings(self) -> Vec<Binding> {
        match self {
            Self::None => Vec::new(),
            _ => vec![write("wall", Element::Real4), read("wall_source", Element::Real)],
        }
    }
}

pub(super) const fn block(name: &'static str, layout: &'static BlockLayout) -> Binding {
    Binding::new(name, Holds::Block(layout))
}

pub(super) const fn read(name: &'static str, element: Element) -> Binding {
    Binding::new(name, Holds::Read(element))
}

pub(super) const fn write(name: &'static str, element: Element) -> Binding {
    Binding::new(name, Holds::Write(element))
}

/// The elements of a state.
pub(super) fn value(precision: Precision) -> Element {
    if precision.words() == 2 { Element::Real2 } else { Element::Real }
}

/// The buffers of what the outside gave, before and after a combination.
pub(super) fn given(precision: Precision) -> [Binding; 2] {
    [read("given_before", value(precision)), write("given", value(precision))]
}

impl Precision {
    /// The values that a buffer of a state or a vector holds.
    pub(super) fn values_in(self, buffer: &Buffer) -> u64 {
        buffer.bytes() / self.state_bytes()
    }
}

/// The shader files of a state and of sums that keep what rounding takes. Passes that name them bind
/// [`STEP_SIZE`].
pub(super) fn arithmetic(precision: Precision) -> [&'static str; 2] {
    let sum = match precision {
        Precision::F32 | Precision::Compensated => "sum/compensated",
        Precision::F64 => "sum/plain",
    };
    [sum, if precision.words() == 2 { "state/two_words" } else { "state/one_word" }]
}

/// Raises a flag if a value is not finite.
pub fn finite(precision: Precision, workgroup_size: u32) -> PassSource {
    let mut source = on_states("finite", precision, workgroup_size, &["state"]);
    know_finite(&mut source);
    source
}

/// Has a pass know which numbers are finite.
pub(super) fn know_finite(source: &mut PassSource) {
    source.constants.push(("LARGEST", Constant::Real(source.real.largest())));
    source.slots.push(format!("precision/{}", source.real.name()));
}

/// Raises a flag if two states differ.
pub fn still(precision: Precision, workgroup_size: u32) -> PassSource {
    on_states("still", precision, workgroup_size, &["before", "state"])
}

/// A pass that raises a flag on some states.
fn on_states(
    pass: &'static str,
    precision: Precision,
    workgroup_size: u32,
    states: &[&'static str],
) -> PassSource {
    let mut bindings = vec![block("step_size", &STEP_SIZE)];
    bindings.extend(states.iter().map(|&name| read(name, value(precision))));
    bindings.push(write("flag", Element::AtomicU32));
    PassSource {
        pass,
        real: precision.real(),
        workgroup_size,
        constants: Vec::new(),
        bindings,
        slots: arithmetic(precision).map(str::to_owned).to_vec(),
        generated: String::new(),
    }
}

/// Adds increments to values and takes differences of values, as a step does: whether a device keeps
/// what rounding takes.
pub fn self_test() -> PassSource {
    let precision = Precision::Compensated;
    PassSource {
        pass: "self_test",
        real: precision.real(),
        workgroup_size: WORKGROUP_SIZE,
        constants: Vec::new(),
        bindings: vec![
            block("step_size", &STEP_SIZE),
            read("before", value(precision)),
            read("other", value(precision)),
            read("rate", Element::Real),
            write("after", value(precision)),
            write("difference", Element::Real),
        ],
        slots: arithmetic(precision).map(str::to_owned).to_vec(),
        generated: String::new(),
    }
}
