// The state is an enthalpy: what a step adds to a potential as if it were the state is added to that.

fn advance(i: u32, own: Value, increment: real) {
    write_enthalpy(i, advanced(content[i], increment));
}

fn keep(i: u32, own: Value) {
    write_enthalpy(i, content[i]);
}

