//! The shaders of a lattice: its numbers are part of their text, so that the compiler sees them.

use std::fmt::Write;

use crate::gpu::{Binding, BlockLayout, Constant, Element, PassSource, Real};
use crate::model::lattice::{Edge, End, LatticeScene};
use crate::solver::Precision;
use crate::solver::gpu::curve_passes::{CurveKind, CurvePasses};
use crate::solver::gpu::fronts::FrontMakes;
use crate::solver::gpu::operator::Makes;
use crate::solver::gpu::passes::{
    COMBINATION, NO_SLOT, SLICE_ROWS, SOURCE_STEPS, SPLIT, STATE_END, STEP_SIZE, WHOLE, WallTerms,
    arithmetic, block, given, read, value, write,
};

/// A part of the sites, those before and behind it that its stencils reach, and its exceptions.
pub static PART: BlockLayout = BlockLayout {
    name: "Part",
    counts: &[
        "first_site",
        "end_site",
        "below_first",
        "below_end",
        "above_first",
        "first_exception",
        "end_exception",
    ],
    reals: &[],
};

/// The most neighbours whose sum is written out. A longer one is a loop, which compiles faster.
const WRITTEN_OUT: usize = 128;

/// What the shaders of a lattice follow from.
#[derive(Clone, Debug, PartialEq)]
pub struct StencilSource {
    /// Particles along each axis.
    pub counts: [usize; 3],
    /// How many sites the stencil reaches along an axis.
    pub reach: usize,
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
    /// Bit 2 axis + (1 if upper) is set for ends with ghosts.
    pub mirrors: u32,
    /// Sites to each neighbour and its weight a reference step; those of one weight together.
    pub entries: Vec<([isize; 3], f64)>,
    /// Whether the state is in parts.
    pub is_split: bool,
    /// Whether the stencil has not the same factor everywhere, or some sites have no particle.
    pub kinds: bool,
    /// Which exceptions have rows of their own.
    pub rows: OwnRows,
    /// Whether some particles keep their value.
    pub held: bool,
    /// What walls add to a step.
    pub walls: WallTerms,
    /// Whether a sum finds each neighbour for itself, wherever a site is.
    pub finds_each: bool,
    /// The precision.
    pub precision: Precision,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
}

/// Which of the sites where more than the stencil acts have rows of their own in place of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnRows {
    /// None.
    None,
    /// Some.
    Some,
    /// All.
    All,
}

impl OwnRows {
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::None, Self::Some, Self::All];

    /// The shader files of these rows.
    fn slots(self) -> &'static [&'static str] {
        match self {
            Self::None => &["lattice/no_rows"],
            Self::Some => &["lattice/own_rows", "lattice/some_rows"],
            Self::All => &["lattice/own_rows", "lattice/all_rows"],
        }
    }
}

/// Which sites a pass works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sites {
    /// All of a part.
    All,
    /// Those where more than the stencil acts.
    Exceptions,
}

impl StencilSource {
    /// Every pass.
    pub fn all(&self) -> Vec<PassSource> {
        let makes = [Makes::Step, Makes::Rate, Makes::Combination];
        let of = |sites| makes.map(|makes| self.pass(sites, makes));
        let all = [Sites::All, Sites::Exceptions].into_iter().flat_map(of);
        let diagonals =
            self.sites_of(Makes::Diagonal).iter().map(|&s| self.pass(s, Makes::Diagonal));
        let Self { precision, workgroup_size, .. } = *self;
        let of_curves = |kind| {
            let curves = CurvePasses { precision, workgroup_size, kind };
            let steps = [Sites::All, Sites::Exceptions].into_iter().flat_map(move |sites| {
                [false, true].map(|kept| {
                    let mut source = self.pass(sites, Makes::Step);
                    curves.end_step(&mut source, kept);
                    source
                })
            });
            let fronts = FrontMakes::of(self.is_split).iter().flat_map(move |&makes| {
                let front = move |&sites: &Sites| self.front(sites, curves, makes);
                Self::front_sites_of(makes).iter().map(front)
            });
            steps.chain(fronts)
        };
        // A state in parts has one curve.
        let kinds = CurveKind::all(precision).into_iter();
        let kinds = kinds.filter(|kind| !self.is_split || !kind.is_each());
        let of_curves = kinds.flat_map(of_curves);
        all.chain(diagonals).chain(of_curves).collect()
    }

    /// The sites that have passes of their own, in order. Of what acts beside the stencil only stored rows change
    /// the diagonal here.
    pub(super) fn sites_of(&self, makes: Makes) -> &'static [Sites] {
        match makes {
            Makes::Diagonal if self.rows == OwnRows::None => &[Sites::All],
            _ => &[Sites::All, Sites::Exceptions],
        }
    }

    /// The sites that have passes of fronts of their own, in order.
    pub(super) fn front_sites_of(makes: FrontMakes) -> &'static [Sites] {
        match makes {
            // The neighbours of exceptions are among those that the stencil goes over.
            FrontMakes::Near => &[Sites::All],
            // Exceptions come first, since the others take tiles off their list.
            FrontMakes::Flows => &[Sites::Exceptions, Sites::All],
        }
    }

    /// What `real` means in the shaders.
    pub(super) fn real(&self) -> Real {
        self.precision.real()
    }

    /// The pass over some sites of a part.
    pub(super) fn pass(&self, sites: Sites, makes: Makes) -> PassSource {
        let mut bindings = vec![block("part", &PART)];
        let (state, read_from): (_, &[&str]) = match (makes, self.is_split) {
            (Makes::Diagonal, _) => ("lattice/unit", &[]),
            (_, true) => (SPLIT, &["before", "below", "above"]),
            (_, false) => (WHOLE, &["before"]),
        };
        bindings.extend(read_from.iter().map(|&name| read(name, value(self.precision))));
        bindings.extend([write("after", value(self.precision)), block("step_size", &STEP_SIZE)]);
        let mut slots = arithmetic(self.precision).to_vec();
        slots.push(state);
        if self.has_stencil(sites) {
            slots.extend(self.stencil(&mut bindings));
        }
        if sites == Sites::Exceptions {
            slots.extend(self.exceptions(makes, &mut bindings));
        }
        if makes == Makes::Combination {
            bindings.push(block("factors", &COMBINATION));
            slots.push("vector/combined");
            if sites == Sites::Exceptions {
                bindings.extend(given(self.precision));
                slots.push("vector/given");
            }
        }
        if makes == Makes::Step {
            slots.push(STATE_END);
        }
        let pass = match (sites, makes) {
            (Sites::All, Makes::Step) => "lattice_step",
            (Sites::All, Makes::Rate | Makes::Diagonal) => "lattice_rate",
            (Sites::All, Makes::Combination) => "lattice_combine",
            (Sites::Exceptions, Makes::Step) => "exception_step",
            (Sites::Exceptions, Makes::Rate) => "exception_rate",
            (Sites::Exceptions, Makes::Diagonal) => "exception_diagonal",
            (Sites::Exceptions, Makes::Combination) => "exception_combine",
        };
        PassSource {
            pass,
            real: self.real(),
            workgroup_size: self.workgroup_size,
            constants: self.constants(),
            bindings,
            slots: slots.into_iter().map(str::to_owned).collect(),
            generated: match self.is_loop() || !self.has_stencil(sites) {
                true => String::new(),
                false => self.sums(),
            },
        }
    }

    /// Whether the stencil acts at any of some sites.
    pub(super) fn has_stencil(&self, sites: Sites) -> bool {
        sites == Sites::All || self.rows != OwnRows::All
    }

    /// The slots of the stencil; their buffers go to `bindings`.
    fn stencil(&self, bindings: &mut Vec<Binding>) -> Vec<&'static str> {
        bindings.push(read("ghost_excess", Element::Real));
        let finding = if self.finds_each { "lattice/anywhere" } else { "lattice/inside" };
        let mut slots = vec!["lattice/site", finding];
        if self.is_loop() {
            let weight = read("entry_weight", value(self.precision));
            bindings.extend([read("entry", Element::U32x4), weight]);
            slots.push("lattice/loops");
        }
        slots.push(if self.kinds { "lattice/kinds" } else { "lattice/alike" });
        if self.kinds {
            bindings
                .extend([read("kind", Element::U32), read("kind_factor", value(self.precision))]);
        }
        slots
    }

    /// What passes of fronts have of it.
    pub(super) fn of_fronts(&self, makes: FrontMakes) -> Self {
        // Kinds would leave out sites with rows of their own, beside which tiles are listed too; weights do not count.
        let kinds = self.kinds && makes == FrontMakes::Flows;
        Self { walls: WallTerms::None, kinds, finds_each: true, ..self.clone() }
    }

    /// What fronts change of a step of some sites of a part, or the tiles where they may.
    pub(super) fn front(&self, sites: Sites, curves: CurvePasses, makes: FrontMakes) -> PassSource {
        let mut source = self.of_fronts(makes).pass(sites, Makes::Step);
        source.pass = match sites {
            Sites::All => "lattice_front",
            Sites::Exceptions => "exception_front",
        };
        makes.add_to(&mut source, curves, self.is_split, sites == Sites::All);
        source
    }

    /// The slots of exceptions; their buffers go to `bindings`.
    fn exceptions(&self, makes: Makes, bindings: &mut Vec<Binding>) -> Vec<&'static str> {
        bindings.push(read("exception", Element::U32x4));
        let mut slots = vec!["lattice/exceptions"];
        if self.rows != OwnRows::None {
            bindings.extend([
                read("row_neighbor", Element::U32),
                read("row_weight", value(self.precision)),
            ]);
        }
        slots.extend(self.rows.slots());
        if makes == Makes::Diagonal {
            return slots;
        }
        if self.held {
            bindings.push(write("held", Element::Real4));
            slots.push("lattice/some_held");
        } else {
            slots.push("lattice/all_free");
        }
        bindings.extend(self.walls.bindings());
        slots.extend(self.walls.slots());
        slots
    }

    fn constants(&self) -> Vec<(&'static str, Constant)> {
        let count = |n: usize| Constant::Count(n as u32);
        let reach_along = |axis| count(if axis < self.dimension { self.reach } else { 0 });
        vec![
            ("NX", count(self.counts[0])),
            ("NY", count(self.counts[1])),
            ("NZ", count(self.counts[2])),
            ("REACH", count(self.reach)),
            ("REACH_Y", reach_along(1)),
            ("REACH_Z", reach_along(2)),
            ("PERIODIC_X", Constant::Flag(self.periodic[0])),
            ("PERIODIC_Y", Constant::Flag(self.periodic[1])),
            ("PERIODIC_Z", Constant::Flag(self.periodic[2])),
            ("MIRRORS", Constant::Count(self.mirrors)),
            ("NO_SLOT", Constant::Count(NO_SLOT)),
            ("SLICE_ROWS", Constant::Count(SLICE_ROWS)),
            ("SOURCE_STEPS", Constant::Count(SOURCE_STEPS)),
        ]
    }

    /// Whether the neighbours are too many to be written out.
    pub(super) fn is_loop(&self) -> bool {
        self.entries.len() > WRITTEN_OUT
    }

    /// The sums with every neighbour written out.
    fn sums(&self) -> String {
        let mut text = String::new();
        if !self.finds_each {
            self.write_interior_sum(&mut text);
        }
        self.write_edge_sum(&mut text);
        text
    }

    /// The sum of what has all neighbours.
    fn write_interior_sum(&self, text: &mut String) {
        text.push_str("fn interior_sum(site: u32, own: Value) -> real {\n");
        text.push_str("    var sum = real(0.0);\n");
        for group in self.entries.chunk_by(|a, b| a.1 == b.1) {
            self.write_group(group, text);
        }
        text.push_str("    return sum;\n}\n\n");
    }

    /// The terms of one weight, with distances between sites as numbers.
    fn write_group(&self, group: &[([isize; 3], f64)], text: &mut String) {
        let pairs = one_sided(group).map(|&(steps, _)| {
            let distance = self.distance(steps);
            format!("((value_at(site - {distance}u) - own) + (value_at(site + {distance}u) - own))")
        });
        self.write_terms(group, &pairs.collect::<Vec<_>>(), text);
    }

    /// Sites between one and that so many steps along each axis, to whichever side: in a body thinner
    /// than the stencil no site has an interior sum, and the number means nothing.
    fn distance(&self, [x, y, z]: [isize; 3]) -> usize {
        let [nx, ny, _] = self.counts.map(|count| count as isize);
        ((z * ny + y) * nx + x).unsigned_abs()
    }

    /// Adds the weight of a group times its differences, those to neighbours on opposite sides in
    /// pairs: what a slope makes of them cancels before anything is rounded.
    fn write_terms(&self, group: &[([isize; 3], f64)], pairs: &[String], text: &mut String) {
        if let Some((_, weight)) = group.first().filter(|_| !pairs.is_empty()) {
            let words = self.precision.state_words(*weight);
            let words: Vec<String> = words.map(|word| self.real().literal(word)).collect();
            let weight = match &words[..] {
                [word] => word.clone(),
                words => format!("Value({})", words.join(", ")),
            };
            // Writing to a String cannot fail.
            let _ = writeln!(text, "    sum += times({weight}, collapsed({}));", pairs.join(" + "));
        }
    }

    /// The sum beside ends: what is found along each axis comes first, so that a place is one sum
    /// of indexes, and no neighbour a branch.
    fn write_edge_sum(&self, text: &mut String) {
        text.push_str("fn edge_sum(at: vec3<u32>, own: Value) -> real {\n");
        for (axis, name) in AXES.into_iter().enumerate() {
            let upper = name.to_uppercase();
            let used = |step: &isize| self.entries.iter().any(|(steps, _)| steps[axis] == *step);
            let reach = self.reach as isize;
            for step in (-reach..=reach).filter(used) {
                let place = place(axis, step);
                let _ = writeln!(
                    text,
                    "    let {place} = along(at.{name}, {step}, N{upper}, {axis}u, \
                     PERIODIC_{upper});"
                );
            }
        }
        text.push_str("    var sum = real(0.0);\n");
        let difference = |steps: [isize; 3]| {
            let [x, y, z] = [0, 1, 2].map(|axis| place(axis, steps[axis]));
            format!(
                "difference(({z}.index * NY + {y}.index) * NX + {x}.index, \
                 joined(joined({x}.excess, {y}.excess), {z}.excess), \
                 {x}.exists && {y}.exists && {z}.exists, own)"
            )
        };
        for group in self.entries.chunk_by(|a, b| a.1 == b.1) {
            let pairs = one_sided(group).map(|&(steps, _)| {
                format!("({} + {})", difference(steps.map(|step| -step)), difference(steps))
            });
            self.write_terms(group, &pairs.collect::<Vec<_>>(), text);
        }
        text.push_str("    return sum;\n}\n\n");
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Of every two neighbours on opposite sides the one that comes later in the order of the sites.
pub(super) fn one_sided(entries: &[([isize; 3], f64)]) -> impl Iterator<Item = &([isize; 3], f64)> {
    entries.iter().filter(|([x, y, z], _)| [*z, *y, *x] > [0; 3])
}

/// What the shader calls the place `step` sites along an axis.
fn place(axis: usize, step: isize) -> String {
    let side = if step < 0 { "minus" } else { "plus" };
    format!("{}_{side}_{}", AXES[axis], step.unsigned_abs())
}

/// Whether each axis is periodic, and the ends with ghosts as bits.
pub(super) fn ends(scene: &LatticeScene) -> ([bool; 3], u32) {
    let mut mirrors = 0;
    for (axis, edge) in scene.edges.iter().enumerate() {
        let Edge::Open(ends) = edge else { continue };
        for (upper, end) in ends.iter().enumerate() {
            if matches!(end, End::Mirror(_)) {
                mirrors |= 1 << (2 * axis + upper);
            }
        }
    }
    ([0, 1, 2].map(|axis| scene.edges[axis] == Edge::Periodic), mirrors)
}

/// Sites to each neighbour and its weight times `scale`, by distance.
pub(super) fn entries(scene: &LatticeScene, scale: f64) -> Vec<([isize; 3], f64)> {
    let scaled = |(steps, weight): ([isize; 3], f64)| (steps, scale * weight);
    let mut entries: Vec<([isize; 3], f64)> = scene.steps().map(scaled).collect();
    let squared = |[x, y, z]: [isize; 3]| x * x + y * y + z * z;
    entries.sort_by_key(|&(steps, _)| squared(steps));
    // One weight a distance: those of equal ones may differ in their last bit.
    for k in 1..entries.len() {
        if squared(entries[k].0) == squared(entries[k - 1].0) {
            entries[k].1 = entries[k - 1].1;
        }
    }
    entries
}
