// What melts after a step is listed.

fn note(place: u32, enthalpy: real) {
    if is_melting(front_of(place), enthalpy) {
        append(place / TILE);
    }
}
