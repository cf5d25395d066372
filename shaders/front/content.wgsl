// Enthalpies are in memory.

fn enthalpy_at(place: u32) -> Value {
    return content_at(place);
}

// Whether what has a potential so far above that of its front may melt.
fn may_melt(above: real) -> bool {
    return true;
}
