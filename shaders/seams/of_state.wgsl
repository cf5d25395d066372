// Of the state.

fn local_at(place: u32, is_changed: bool) -> Local {
    return local_of(place, content[place]);
}

fn shortage(row: vec4<u32>) -> real {
    return seam_sum(row, false);
}

