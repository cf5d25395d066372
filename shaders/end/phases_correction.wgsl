// Something is added to what a step has written, after which it is known what melts.

fn correct(i: u32, increment: real) {
    let phases = phases_of(i);
    let melts = phases.melts;
    var enthalpy = content[i];
    if own_above == 0.0 {
        enthalpy = advanced(enthalpy, collapsed(after[i]) + increment);
    } else {
        let slope = slope_there(phases, own_above);
        let next = advanced(after[i], slope * increment);
        let above_next = collapsed(next - melts);
        if !leaves_phase(phases, own_above, above_next) {
            after[i] = next;
            return;
        }
        enthalpy = advanced(select(phases.begins, phases.ends, own_above > 0.0), above_next / slope);
    }
    content_after[i] = enthalpy;
    let of_solid = phases.slopes.x * collapsed(enthalpy - phases.begins);
    let of_liquid = phases.slopes.y * collapsed(enthalpy - phases.ends);
    if of_solid < -phases.width {
        after[i] = advanced(melts, of_solid);
    } else if of_liquid > phases.width {
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
