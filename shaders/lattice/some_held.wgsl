// Some particles keep their value. `held` has for each what it has given to others, in two words,
// and the rate that held ones and walls give it, which is no exchange with these.

fn is_held(row: u32) -> bool {
    return exception[row].z != NO_SLOT;
}

fn rate_among_held(row: u32) -> real {
    return held[exception[row].z].z;
}

// What a held particle would have gained, it has taken from the others.
fn record_exchange(row: u32, increment: real, step: real) {
    let place = exception[row].z;
    let given = step * held[place].z - increment;
    held[place] = vec4<real>(accumulated(held[place].xy, given), held[place].zw);
}

