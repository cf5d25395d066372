// The places of a pass are in tiles that `listed` names: see `append`. Another list, which others have gone through, is empty
// after it.

fn front_place(i: u32) -> u32 {
    if i == 0u {
        emptied[0] = 1u;
        emptied[1] = 1u;
        emptied[LIST_LENGTH] = 0u;
    }
    let k = i / TILE;
    if k >= listed[LIST_LENGTH] {
        return NO_SLOT;
    }
    return listed[LIST_LENGTH + 1u + k] * TILE + i % TILE;
}

// A tile that was gone through may be listed again.
fn leave(place: u32) {
    if place % TILE == 0u {
        atomicAnd(&tiles[place / TILE], ~LISTED);
    }
}
