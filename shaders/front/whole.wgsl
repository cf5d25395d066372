// The state is one buffer.

fn potential_at(place: u32) -> Value {
    return before[place];
}

fn enthalpy_at(place: u32) -> Value {
    return content[place];
}

// Whether a place has a neighbour that melts. It asks once a step.
fn is_near(local: u32) -> bool {
    return (atomicAnd(&near[local], ~MARKED) & MARKED) != 0u;
}
