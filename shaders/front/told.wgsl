// Enthalpies are in memory where they melt: elsewhere potentials tell them, and on which side of melting is enough.

fn enthalpy_at(place: u32) -> Value {
    let front = front_of(place);
    let above = above_front(front, potential_at(place));
    if may_melt(above) {
        return content_at(place);
    }
    return exactly(select(front.begins, front.ends, above > 0.0));
}

// Whether what has a potential so far above that of its front may melt.
fn may_melt(above: real) -> bool {
    return above == 0.0;
}
