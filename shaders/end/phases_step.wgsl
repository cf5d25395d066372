// A step adds to an enthalpy that its potential tells, unless it melts.

// The enthalpy of what melts.
fn kept(i: u32) -> Value {
    return content[i];
}

fn advance(i: u32, own: Value, increment: real) {
    go_on(i, own, increment);
}

fn keep(i: u32, own: Value) {
    after[i] = own;
    if collapsed(own - melting_potential()) == 0.0 {
        content_after[i] = content[i];
        note(i, 1u, collapsed(content[i]));
    }
}
