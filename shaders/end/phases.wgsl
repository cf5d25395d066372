// The state is an enthalpy that its potential tells, unless it melts: then the potential is that of melting, and the
// enthalpy is kept. A potential that is nearer to that of melting than a few roundings is taken for it, so that whoever
// compares them finds the same. `curve` has the segments of a solid, of what melts, and of a liquid.

fn melting_potential() -> Value {
    let base = curve[2].zw;
    return of_words(base.x, base.y);
}

// The enthalpy at which a solid begins to melt, or a liquid to freeze.
fn phase_end(is_liquid: bool) -> Value {
    let start = select(curve[2].xy, curve[4].xy, is_liquid);
    return of_words(start.x, start.y);
}

// Takes on a potential by what is added to its enthalpy.
fn go_on(i: u32, potential: Value, increment: real) {
    let melts = melting_potential();
    let above = collapsed(potential - melts);
    let slope = select(curve[1].x, curve[5].x, above > 0.0);
    let next = advanced(potential, slope * increment);
    let above_next = collapsed(next - melts);
    let width = ROUNDINGS * abs(collapsed(melts));
    if (above < 0.0 && above_next < -width) || (above > 0.0 && above_next > width) {
        after[i] = next;
        return;
    }
    // It melts, or begins or ends to.
    var enthalpy = phase_end(above > 0.0);
    if above == 0.0 {
        enthalpy = kept(i);
    } else {
        enthalpy = advanced(enthalpy, above / slope);
    }
    enthalpy = advanced(enthalpy, increment);
    content_after[i] = enthalpy;
    let of_solid = curve[1].x * collapsed(enthalpy - phase_end(false));
    let of_liquid = curve[5].x * collapsed(enthalpy - phase_end(true));
    if of_solid < -width {
        after[i] = advanced(melts, of_solid);
    } else if of_liquid > width {
        after[i] = advanced(melts, of_liquid);
    } else if is_finite(collapsed(enthalpy)) {
        after[i] = melts;
        note(i, 1u, collapsed(enthalpy));
    } else {
        after[i] = enthalpy;
    }
}
