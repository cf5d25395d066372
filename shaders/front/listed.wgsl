// The places of a pass are in tiles that `listed` names: how many, and then which.

fn front_place(i: u32) -> u32 {
    let k = i / TILE;
    if k >= listed[0] {
        return NO_SLOT;
    }
    return listed[1u + k] * TILE + i % TILE;
}

// A tile that was gone through may be listed again.
fn leave(place: u32) {
    if place % TILE == 0u {
        atomicAnd(&tiles[place / TILE], ~LISTED);
    }
}
