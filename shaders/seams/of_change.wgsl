// Of a change of the state.

fn local_at(place: u32, is_changed: bool) -> Local {
    if is_changed {
        return local_of(place, plus(content[place], change[place]));
    }
    return local_of(place, content[place]);
}

fn shortage(row: vec4<u32>) -> real {
    return seam_sum(row, true) - seam_sum(row, false);
}

