// The state is an enthalpy that its potential tells, unless it melts: then the potential is that of melting, and the
// enthalpy is kept. A potential that is nearer to that of melting than a few roundings is taken for it, so that whoever
// compares them finds the same.

struct Phases {
    // The potential of melting, and how near others are taken for it.
    melts: Value,
    width: real,
    // d potential / d enthalpy of a solid and of a liquid.
    slopes: vec2<real>,
    // The enthalpies at which a solid begins to melt, and a liquid to freeze.
    begins: Value,
    ends: Value,
}

// The slope of what is so far above melting.
fn slope_there(phases: Phases, above: real) -> real {
    return select(phases.slopes.x, phases.slopes.y, above > 0.0);
}

// Whether what was so far above melting, and would be after a step without it, melts, or begins or ends to. What is not
// a number does not.
fn leaves_phase(phases: Phases, above: real, above_next: real) -> bool {
    let width = phases.width;
    return (above <= 0.0 && above_next >= -width) || (above >= 0.0 && above_next <= width);
}
