// Some particles keep their value. `held` has for each the rate that held ones and walls give it,
// which is no exchange with other particles, and what it has given to these.

fn is_held(row: u32) -> bool {
    return exception[row].z != NO_SLOT;
}

// What a held particle would have gained, it has taken from the others.
fn record_exchange(row: u32, increment: real, step: real) {
    let place = exception[row].z;
    held[place].y -= increment - step * held[place].x;
}

