// Marks the neighbours of what melts: few are, and the others have no flows to a front.

fn value_at(other: u32) -> Value {
    atomicOr(&near[other], MARKED);
    return exactly(real(0.0));
}

fn own_value(place: u32) -> Value {
    return exactly(real(0.0));
}

// Whether a sum is wanted of a place, whose mark is `local`.
fn begin(place: u32, local: u32) -> bool {
    return is_melting(front_of(place), collapsed(enthalpy_at(place)));
}
