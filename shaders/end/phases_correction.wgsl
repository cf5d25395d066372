// Something is added to an enthalpy that a step has written, and that its potential tells, unless it melts.

// The enthalpy of what melts.
fn kept(i: u32) -> Value {
    return content_after[i];
}

fn correct(i: u32, increment: real) {
    go_on(i, after[i], increment);
}
