// Lists the tiles of what melts and of its neighbours: few are, and the others have no flows to a front.

fn value_at(other: u32) -> Value {
    append(other / TILE);
    return exactly(real(0.0));
}

fn own_value(place: u32) -> Value {
    return exactly(real(0.0));
}

// Whether others see to a place: its neighbours are among those of the stencil.
fn is_left_out(local: u32) -> bool {
    return false;
}

// Whether a sum is wanted of a place.
fn begin(place: u32) -> bool {
    if !is_melting(front_of(place), collapsed(enthalpy_at(place))) {
        return false;
    }
    append(place / TILE);
    return true;
}

// Nothing is known after the step yet.
fn keep_listed(i: u32) {}

// Nothing flows yet.
fn correct(i: u32, increment: real) {}
