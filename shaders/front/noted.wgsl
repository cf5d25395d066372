// The tile of a place is listed. Those who read a list see for themselves what of it melts.

fn note(place: u32) {
    append(place / TILE);
}
