// Of the state, whose enthalpies potentials tell unless they melt. `thermal` has four vectors for each material: potential
// and temperature of one state of a solid, each as the sum of two numbers; the same of a liquid; how temperatures of both
// rise with potentials, and their conductivities; how the conductivity of what melts rises with its enthalpy, and from which
// enthalpy on, as the sum of two numbers.

fn local_at(place: u32, is_changed: bool) -> Local {
    let first = 4u * curve_of[place];
    let potential = state[place];
    let above_melting = collapsed(potential - phases_of(place).melts);
    let is_liquid = above_melting > 0.0;
    let base = thermal[first + u32(is_liquid)];
    let phases = thermal[first + 2u];
    let above = plus(potential, of_words(-base.x, -base.y));
    let temperature =
        plus(of_words(base.z, base.w), select(phases.x, phases.y, is_liquid) * above);
    var conductivity = select(phases.z, phases.w, is_liquid);
    if above_melting == 0.0 {
        let melting = thermal[first + 3u];
        let above_begin = plus(content[place], of_words(-melting.y, -melting.z));
        conductivity += melting.x * collapsed(above_begin);
    }
    return Local(temperature, potential, conductivity);
}

fn shortage(row: vec4<u32>) -> real {
    return seam_sum(row, false);
}
