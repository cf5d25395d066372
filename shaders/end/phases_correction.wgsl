// Something is added to what a step has written, after which it is known what melts.

// The enthalpy at which a solid begins to melt, or a liquid to freeze.
fn phase_end(is_liquid: bool) -> Value {
    return select(of_words(BEGINS, BEGINS_REST), of_words(ENDS, ENDS_REST), is_liquid);
}

fn correct(i: u32, increment: real) {
    let melts = melting_potential();
    var enthalpy = content[i];
    if own_above == 0.0 {
        enthalpy = advanced(enthalpy, collapsed(after[i]) + increment);
    } else {
        let slope = slope_there(own_above);
        let next = advanced(after[i], slope * increment);
        let above_next = collapsed(next - melts);
        if !leaves_phase(own_above, above_next) {
            after[i] = next;
            return;
        }
        enthalpy = advanced(phase_end(own_above > 0.0), above_next / slope);
    }
    content_after[i] = enthalpy;
    let of_solid = SOLID_SLOPE * collapsed(enthalpy - phase_end(false));
    let of_liquid = LIQUID_SLOPE * collapsed(enthalpy - phase_end(true));
    if of_solid < -WIDTH {
        after[i] = advanced(melts, of_solid);
    } else if of_liquid > WIDTH {
        after[i] = advanced(melts, of_liquid);
    } else if is_finite(collapsed(enthalpy)) {
        after[i] = melts;
        if of_solid > 0.0 {
            note(i);
        }
    } else {
        after[i] = enthalpy;
    }
}
