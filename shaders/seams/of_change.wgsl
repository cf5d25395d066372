// Of a change of the state.

fn enthalpy_at(place: u32, is_changed: bool) -> Value {
    if is_changed {
        return plus(content[place], change[place]);
    }
    return content[place];
}

fn shortage(row: vec4<u32>) -> real {
    return seam_sum(row, true) - seam_sum(row, false);
}

