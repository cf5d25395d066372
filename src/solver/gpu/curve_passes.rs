//! The passes of scenes whose state is an enthalpy.

use super::fronts::NOT_NOTED;
use super::passes::{COMBINATION, NO_SLOT, STEP_SIZE, arithmetic, block, read, value, write};
use crate::gpu::{Binding, Constant, Element, PassSource};
use crate::model::PairMean;
use crate::solver::Precision;

/// What the shaders of enthalpies follow from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurvePasses {
    /// The precision.
    pub precision: Precision,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
    /// Whether each place has the curve of its own material, or all have one.
    pub each: bool,
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
    /// Whether some particles keep their value.
    pub held: bool,
}

impl CurvePasses {
    /// Adds to enthalpies what a step has added to potentials, and writes the potentials that come of it.
    pub fn enthalpy(self) -> PassSource {
        let value = value(self.precision);
        let states = [read("before", value), write("after", value), write("content", value)];
        let mut source = self.on_curve("enthalpy", &states);
        source.slots.push(NOT_NOTED.to_owned());
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
        vec![
            self.enthalpy(),
            self.noted_enthalpy(),
            self.find_fronts(),
            self.front_size(),
            self.potential_change(),
            self.slope_root(),
        ]
    }

    fn changed(self, pass: &'static str) -> PassSource {
        let value = value(self.precision);
        let states = [read("content", value), read("change", value), write("after", value)];
        self.on_curve(pass, &states)
    }

    fn on_curve(self, pass: &'static str, states: &[Binding]) -> PassSource {
        let mut bindings = vec![block("step_size", &STEP_SIZE)];
        bindings.extend(of_curves(self.each));
        bindings.extend(states);
        let bounds = if self.each { "curve/each" } else { "curve/one" };
        source(self.precision, self.workgroup_size, pass, bindings, &[bounds, "curve/segments"])
    }
}

impl SeamPasses {
    /// Adds what the matrix is short of to a step of potentials.
    pub fn step(self) -> PassSource {
        let mut source = self.on_rows("seams/of_state", "seams/to_step", "seams/exchange");
        if self.held {
            source.bindings.push(write("exchange", Element::Real2));
        }
        source
    }

    /// The same for rates.
    pub fn rate(self) -> PassSource {
        self.on_rows("seams/of_state", "seams/to_rate", "seams/no_held")
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
        vec![self.step(), self.rate(), self.combine(), self.change()]
    }

    fn combined(self, of: &'static str) -> PassSource {
        let mut source = self.on_rows(of, "seams/to_vector", "seams/given");
        source.bindings.push(block("factors", &COMBINATION));
        if self.held {
            source.bindings.push(write("given", value(self.precision)));
        }
        source
    }

    fn on_rows(self, of: &str, to: &str, held: &str) -> PassSource {
        let value = value(self.precision);
        let mut bindings = vec![block("step_size", &STEP_SIZE)];
        bindings.extend(of_curves(true));
        bindings.extend([
            read("thermal", Element::Real4),
            read("seam_row", Element::U32x4),
            read("seam_pair", Element::U32),
            read("seam_weight", Element::Real2),
            read("content", value),
            write("after", value),
        ]);
        let held = if self.held { held } else { "seams/no_held" };
        let mean = format!("operator/{}", self.pair_mean.name());
        let slots = ["curve/each", "curve/segments", &mean, "seams/rows", of, to, held];
        source(self.precision, self.workgroup_size, "seam", bindings, &slots)
    }
}

/// The curves: segments and, where each place has that of its material, which and where these begin.
fn of_curves(each: bool) -> impl Iterator<Item = Binding> {
    let of_each = [read("curve_of", Element::U32), read("curve_start", Element::U32)];
    [read("curve", Element::Real4)].into_iter().chain(of_each.into_iter().filter(move |_| each))
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
