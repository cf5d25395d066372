//! The passes of scenes whose state is an enthalpy.

use super::fronts::{Listed, note};
use super::passes::{
    COMBINATION, NO_SLOT, STATE_END, STEP_SIZE, arithmetic, block, know_finite, read, value, write,
};
use super::phases::{Phases, roundings};
use crate::gpu::{Binding, Constant, Element, PassSource};
use crate::model::PairMean;
use crate::solver::Precision;

/// Which curves enthalpies follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CurveKind {
    /// One, of constant conductivities in each phase, that melts at one temperature: potentials tell enthalpies but of
    /// what melts, and explicit Euler steps take potentials on.
    Phases(Phases),
    /// One.
    One,
    /// Each place that of its material, all of which are like [`Self::Phases`] or do not melt.
    EachPhases,
    /// Each place that of its material.
    Each,
}

impl CurveKind {
    /// Every kind, as it is in a `precision`, with some phases.
    pub fn all(precision: Precision) -> [Self; 4] {
        [Self::Phases(Phases::some(precision)), Self::One, Self::EachPhases, Self::Each]
    }

    /// Whether potentials tell enthalpies but of what melts.
    pub(super) fn is_told(self) -> bool {
        matches!(self, Self::Phases(_) | Self::EachPhases)
    }

    /// Whether each place has the curve of its own material.
    pub(super) fn is_each(self) -> bool {
        matches!(self, Self::EachPhases | Self::Each)
    }
}

/// What the shaders of enthalpies follow from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePasses {
    /// The precision.
    pub precision: Precision,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
    /// Which curves there are.
    pub kind: CurveKind,
}

/// What the shaders follow from where materials meet, each with its curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeamPasses {
    /// The precision.
    pub precision: Precision,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
    /// How conductivities are joined.
    pub pair_mean: PairMean,
    /// Where what held particles give is counted.
    pub held: HeldIn,
}

/// Where what held particles give is counted, if there are any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldIn {
    /// There are none.
    None,
    /// The exchange of the rows of a list.
    Rows,
    /// The held particles of a lattice.
    Lattice,
}

impl HeldIn {
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::None, Self::Rows, Self::Lattice];
}

impl CurvePasses {
    /// Makes a pass over all places of a step of potentials one of enthalpies, which writes both, but for an enthalpy
    /// that its potential tells; where lists are `kept`, what flows are to be looked for of is put on theirs.
    pub(super) fn end_step(self, source: &mut PassSource, kept: bool) {
        source.bindings.push(read("content", value(self.precision)));
        self.end(source, ["end/phases_step", "end/enthalpy"], kept.then_some(Listed::Near));
    }

    /// The same of a pass that adds to what those have written, and has the enthalpies before: where lists are `kept`,
    /// what melts is put on its own.
    pub(super) fn end_correction(self, source: &mut PassSource, kept: bool) {
        if self.kind.is_told() {
            know_finite(source);
        }
        let ends = ["end/phases_correction", "end/correction"];
        self.end(source, ends, kept.then_some(Listed::Melting));
    }

    /// Its buffers are those of `HeatFields::of_end`; of two ends the first is that of phases.
    fn end(
        self,
        source: &mut PassSource,
        [of_phases, of_curves]: [&str; 2],
        noted_in: Option<Listed>,
    ) {
        source.bindings.push(write("content_after", value(self.precision)));
        source.slots.retain(|slot| slot != STATE_END);
        let slots: &[&str] = match self.kind {
            CurveKind::Phases(phases) => {
                source.constants.extend(phases.constants());
                &["end/phases_of_one", "end/phases", of_phases]
            }
            CurveKind::EachPhases => {
                know_phases(source, self.precision);
                source.bindings.push(read("curve_of", Element::U32));
                &["end/phases_of_each", "end/phases", of_phases]
            }
            CurveKind::One | CurveKind::Each => {
                source.bindings.extend(curve_bindings(self.kind.is_each()));
                &[self.bounds(), "curve/segments", "end/written", of_curves]
            }
        };
        source.slots.extend(slots.iter().map(|&slot| slot.to_owned()));
        note(source, noted_in);
    }

    /// Adds a vector to enthalpies, and writes the potentials that come of them.
    pub fn enthalpy_add(self) -> PassSource {
        let value = value(self.precision);
        let states = [
            read("content", value),
            read("change", value),
            write("content_after", value),
            write("after", value),
        ];
        let mut source = self.on_curve("enthalpy_add", &states);
        source.slots.push("end/written".to_owned());
        note(&mut source, None);
        source
    }

    /// Lists what melts.
    pub fn find_fronts(self) -> PassSource {
        let mut source = self.on_curve("front_find", &[read("content", value(self.precision))]);
        note(&mut source, Some(Listed::Melting));
        source
    }

    /// By how much potentials change with a change of the state.
    pub fn potential_change(self) -> PassSource {
        self.changed("potential_change")
    }

    /// The square roots of the slopes of potentials after a change of the state.
    pub fn slope_root(self) -> PassSource {
        self.changed("slope_root")
    }

    /// Every pass.
    pub fn all(self) -> Vec<PassSource> {
        vec![self.enthalpy_add(), self.find_fronts(), self.potential_change(), self.slope_root()]
    }

    fn changed(self, pass: &'static str) -> PassSource {
        let value = value(self.precision);
        let states = [read("content", value), read("change", value), write("after", value)];
        self.on_curve(pass, &states)
    }

    fn on_curve(self, pass: &'static str, states: &[Binding]) -> PassSource {
        let mut bindings = vec![block("step_size", &STEP_SIZE)];
        bindings.extend(curve_bindings(self.kind.is_each()));
        bindings.extend(states);
        let slots = [self.bounds(), "curve/segments"];
        source(self.precision, self.workgroup_size, pass, bindings, &slots)
    }

    fn bounds(self) -> &'static str {
        if self.kind.is_each() { "curve/each" } else { "curve/one" }
    }
}

impl SeamPasses {
    /// Adds what a step is short of to it; what melts is put on its list where lists are `kept`.
    pub fn step(self, kept: bool) -> PassSource {
        let to = ["seams/to_step", "end/written", "end/correction"];
        let (held, exchange) = self.held_of_step();
        let mut source = self.on_curves("seams/of_state", &to, held);
        source.bindings.push(write("content_after", value(self.precision)));
        note(&mut source, kept.then_some(Listed::Melting));
        source.bindings.extend(exchange);
        source
    }

    /// The same before it is looked at what melts, where potentials tell enthalpies: where lists are `kept`, what flows are
    /// to be looked for of is put on its own.
    pub fn step_of_told(self, kept: bool) -> PassSource {
        let to = ["seams/to_step", "end/phases_of_each", "end/phases", "end/phases_addition"];
        let (held, exchange) = self.held_of_step();
        let curves = [read("curve_of", Element::U32)];
        let mut source = self.on_rows(&["seams/of_told"], curves, &to, held);
        source.bindings.push(read("state", value(self.precision)));
        know_phases(&mut source, self.precision);
        note(&mut source, kept.then_some(Listed::Near));
        source.bindings.extend(exchange);
        source
    }

    fn held_of_step(self) -> (&'static str, Option<Binding>) {
        match self.held {
            HeldIn::None => ("seams/no_held", None),
            HeldIn::Rows => ("seams/exchange", Some(write("exchange", Element::Real2))),
            HeldIn::Lattice => ("seams/held", Some(write("held", Element::Real4))),
        }
    }

    /// The same for rates.
    pub fn rate(self) -> PassSource {
        self.on_curves("seams/of_state", &["seams/to_rate", "end/sum"], "seams/no_held")
    }

    /// The same for a vector of rates.
    pub fn combine(self) -> PassSource {
        self.combined("seams/of_state")
    }

    /// The same for how rates change with the state.
    pub fn change(self) -> PassSource {
        let mut source = self.combined("seams/of_change");
        source.bindings.push(read("change", value(self.precision)));
        source
    }

    /// Every pass.
    pub fn all(self) -> Vec<PassSource> {
        let steps = [false, true].map(|kept| [self.step(kept), self.step_of_told(kept)]);
        let others = [self.rate(), self.combine(), self.change()];
        steps.into_iter().flatten().chain(others).collect()
    }

    /// Whether some particles keep their value.
    pub(super) fn has_held(self) -> bool {
        self.held != HeldIn::None
    }

    fn combined(self, of: &'static str) -> PassSource {
        let held = if self.has_held() { "seams/given" } else { "seams/no_held" };
        let mut source = self.on_curves(of, &["seams/to_vector", "end/sum"], held);
        source.bindings.push(block("factors", &COMBINATION));
        if self.has_held() {
            source.bindings.push(write("given", value(self.precision)));
        }
        source
    }

    fn on_curves(self, of: &str, to: &[&str], held: &str) -> PassSource {
        let of = ["curve/each", "curve/segments", "seams/of_enthalpy", of];
        self.on_rows(&of, curve_bindings(true), to, held)
    }

    fn on_rows(
        self,
        of: &[&str],
        curves: impl IntoIterator<Item = Binding>,
        to: &[&str],
        held: &str,
    ) -> PassSource {
        let value = value(self.precision);
        let mut bindings = vec![block("step_size", &STEP_SIZE)];
        bindings.extend(curves);
        bindings.extend([
            read("thermal", Element::Real4),
            read("seam_row", Element::U32x4),
            read("seam_pair", Element::U32),
            read("seam_weight", Element::Real2),
            read("content", value),
            write("after", value),
        ]);
        let mean = format!("operator/{}", self.pair_mean.name());
        let rows = [&mean, "seams/rows", held];
        let slots: Vec<&str> = rows.iter().chain(of).chain(to).copied().collect();
        source(self.precision, self.workgroup_size, "seam", bindings, &slots)
    }
}

/// The curves: segments and, where each place has that of its material, which and where these begin.
fn curve_bindings(each: bool) -> impl Iterator<Item = Binding> {
    let of_each = [read("curve_of", Element::U32), read("curve_start", Element::U32)];
    [read("curve", Element::Real4)].into_iter().chain(of_each.into_iter().filter(move |_| each))
}

/// Gives a pass the phases of each material.
fn know_phases(source: &mut PassSource, precision: Precision) {
    source.constants.push(("ROUNDINGS", Constant::Real(roundings(precision))));
    source.bindings.push(read("material_phases", Element::Real4));
}

fn source(
    precision: Precision,
    workgroup_size: u32,
    pass: &'static str,
    bindings: Vec<Binding>,
    slots: &[&str],
) -> PassSource {
    let slots = arithmetic(precision).into_iter().chain(slots.iter().copied());
    PassSource {
        pass,
        real: precision.real(),
        workgroup_size,
        constants: vec![("NO_SLOT", Constant::Count(NO_SLOT))],
        bindings,
        slots: slots.map(str::to_owned).collect(),
        generated: String::new(),
    }
}
