// Of the state.

fn enthalpy_at(place: u32, is_changed: bool) -> Value {
    return content[place];
}

fn shortage(row: vec4<u32>) -> real {
    return seam_sum(row, false);
}

