// Some particles keep their value. `held` has for each what ghosts add to its diagonal, which is no
// exchange with other particles, and what it has given.

fn is_held(row: u32) -> bool {
    return exception[row].z != NO_SLOT;
}

// What a held particle would have gained, it has taken from the others.
fn record_exchange(row: u32, own: real, increment: real, step: real) {
    let place = exception[row].z;
    held[place].y -= increment - step * held[place].x * own;
}

