// The state is an enthalpy that its potential tells, unless it melts: then the potential is that of melting, and the
// enthalpy is kept. A potential that is nearer to that of melting than a few roundings is taken for it, so that whoever
// compares them finds the same.

fn melting_potential() -> Value {
    return of_words(MELTS, MELTS_REST);
}

// d potential / d enthalpy of what is so far above melting.
fn slope_there(above: real) -> real {
    return select(SOLID_SLOPE, LIQUID_SLOPE, above > 0.0);
}

// Whether what was so far above melting, and would be after a step without it, melts, or begins or ends to. What is not
// a number does not.
fn leaves_phase(above: real, above_next: real) -> bool {
    return (above <= 0.0 && above_next >= -WIDTH) || (above >= 0.0 && above_next <= WIDTH);
}
