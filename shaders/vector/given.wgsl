// What the outside gave: an entry for each held particle, then one for each slot of a wall.

fn record_given(entry: u32, rate: real) {
    given[entry] = combined(given_before[entry], rate);
}

