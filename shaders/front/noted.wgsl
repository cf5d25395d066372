// The tile of a place is listed.

fn note(place: u32) {
    append(place / TILE);
}
