//! The passes of vectors.

use crate::gpu::{Binding, BlockLayout, Constant, Element, PassSource};
use crate::solver::Precision;
use crate::solver::gpu::passes::{
    COMBINATION, NO_SLOT, STEP_SIZE, WORKGROUP_SIZE, arithmetic, block, know_finite, read, value,
    write,
};

/// Vectors that are added in one pass at most.
pub(super) const MOST_TERMS: usize = 4;

/// Invocations of a workgroup that reduces a vector, a power of two within the least that WebGPU
/// guarantees.
const REDUCING: u32 = 256;

/// The same of one that sums over an aggregate.
pub(super) const RESTRICTING: u32 = 64;

/// Elements that an invocation of it takes.
const ITEMS: u32 = 8;

/// Elements of which a workgroup makes one number.
pub(super) const REDUCED: u64 = (REDUCING * ITEMS) as u64;

/// Values below this may count as 0 in a sum of products.
const LEAST: f64 = 1e-30;

/// What each vector of a sum is multiplied by, and whether what was there before counts.
pub static UPDATE: BlockLayout = BlockLayout {
    name: "Update",
    counts: &["keeps"],
    reals: &["keep", "first", "second", "third", "fourth"],
};

/// The places of a part of a vector, and its exceptions.
pub static PLACES: BlockLayout = BlockLayout {
    name: "Places",
    counts: &["first_place", "first_exception", "end_exception"],
    reals: &[],
};

/// Some of the entries of what the outside gave.
pub static ENTRIES: BlockLayout =
    BlockLayout { name: "Entries", counts: &["first", "count"], reals: &[] };

/// Every pass of vectors in this precision.
pub fn vector_passes(precision: Precision) -> Vec<PassSource> {
    let updates = (0..=MOST_TERMS).map(|terms| update(precision, terms));
    let dots = [false, true].map(|volumes| dot(precision, volumes));
    let restricts = [false, true].map(|volumes| restrict(precision, volumes));
    let others = [divide, multiply, largest, scatter, give, prolong].map(|pass| pass(precision));
    updates.chain(dots).chain(restricts).chain(others).collect()
}

/// The sum of multiples of a vector and of so many others.
pub(super) fn update(precision: Precision, terms: usize) -> PassSource {
    let names = &UPDATE.reals[1..=terms];
    let mut bindings = vec![block("factors", &UPDATE), write("after", value(precision))];
    bindings.extend(names.iter().map(|&name| read(name, value(precision))));
    let mut products = names.iter().map(|name| format!("factors.{name} * {name}[i]"));
    let first = products.next().unwrap_or_else(|| "exactly(real(0.0))".to_owned());
    let rest: String =
        products.map(|product| format!("    sum = plus(sum, {product});\n")).collect();
    let generated = format!(
        "fn updated(i: u32) -> Value {{\n    var sum = {first};\n    if factors.keeps != 0u {{\n        \
         sum = plus(factors.keep * after[i], sum);\n    }}\n{rest}    return sum;\n}}\n\n"
    );
    PassSource { generated, ..source("vector_update", precision, bindings) }
}

/// A vector over a shift and a multiple of the diagonal.
pub(super) fn divide(precision: Precision) -> PassSource {
    let bindings = vec![
        block("factors", &COMBINATION),
        read("before", value(precision)),
        read("diagonal", value(precision)),
        write("after", value(precision)),
    ];
    source("vector_divide", precision, bindings)
}

/// A vector times another, value by value.
pub(super) fn multiply(precision: Precision) -> PassSource {
    let bindings = vec![read("by", value(precision)), write("after", value(precision))];
    source("vector_multiply", precision, bindings)
}

/// The slot for capacities, with their binding where particles differ.
fn capacity(bindings: &mut Vec<Binding>, differ: bool) -> &'static str {
    if !differ {
        return "capacity/same";
    }
    bindings.push(read("capacity", Element::Real));
    "capacity/each"
}

/// Partial sums of the products of two vectors with capacities, by particle or one for all.
pub(super) fn dot(precision: Precision, capacities: bool) -> PassSource {
    let mut bindings = vec![
        read("one", value(precision)),
        read("other", value(precision)),
        write("sums", Element::Real4),
    ];
    let slot = capacity(&mut bindings, capacities);
    let mut source = reduction("vector_dot", precision, bindings);
    source.constants.push(("LEAST", Constant::Real(LEAST)));
    source.slots.push(slot.to_owned());
    source
}

/// Sums over aggregates with capacities, by particle or one for all.
pub(super) fn restrict(precision: Precision, capacities: bool) -> PassSource {
    let mut bindings = vec![
        read("one", value(precision)),
        read("place", Element::U32),
        read("start", Element::U32),
        write("sums", Element::Real),
    ];
    let slot = capacity(&mut bindings, capacities);
    let mut source = source("vector_restrict", precision, bindings);
    source.workgroup_size = RESTRICTING;
    source.slots.push(slot.to_owned());
    source
}

/// The values of aggregates, to be added to a vector.
pub(super) fn prolong(precision: Precision) -> PassSource {
    let bindings = vec![
        read("aggregate", Element::U32),
        read("values", Element::Real),
        write("after", value(precision)),
    ];
    source("vector_prolong", precision, bindings)
}

/// The largest magnitudes in parts of a vector.
pub(super) fn largest(precision: Precision) -> PassSource {
    let bindings = vec![read("one", value(precision)), write("sums", Element::Real4)];
    let mut source = reduction("vector_largest", precision, bindings);
    know_finite(&mut source);
    source
}

/// Sources of walls at their places.
pub(super) fn scatter(precision: Precision) -> PassSource {
    let bindings = vec![
        block("places", &PLACES),
        read("exception", Element::U32x4),
        read("source", Element::Real),
        write("after", value(precision)),
    ];
    let mut source = source("vector_scatter", precision, bindings);
    source.constants.push(("NO_SLOT", Constant::Count(NO_SLOT)));
    source
}

/// What the outside gave, to be added to totals.
pub(super) fn give(precision: Precision) -> PassSource {
    let bindings = vec![
        block("entries", &ENTRIES),
        read("given", value(precision)),
        read("place", Element::U32),
        write("total", Element::Real2),
    ];
    source("vector_give", precision, bindings)
}

fn reduction(pass: &'static str, precision: Precision, bindings: Vec<Binding>) -> PassSource {
    let mut source = source(pass, precision, bindings);
    source.workgroup_size = REDUCING;
    source.constants.push(("ITEMS", Constant::Count(ITEMS)));
    source
}

/// A pass on these buffers, the first of which is the block with the zero of compensated sums.
fn source(pass: &'static str, precision: Precision, rest: Vec<Binding>) -> PassSource {
    let mut bindings = vec![block("step_size", &STEP_SIZE)];
    bindings.extend(rest);
    PassSource {
        pass,
        real: precision.real(),
        workgroup_size: WORKGROUP_SIZE,
        constants: Vec::new(),
        bindings,
        slots: arithmetic(precision).map(str::to_owned).to_vec(),
        generated: String::new(),
    }
}
