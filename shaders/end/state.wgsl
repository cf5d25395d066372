// The state is what the operator acts on, and nothing more comes of a step.

fn advance(i: u32, own: Value, increment: real) {
    after[i] = advanced(own, increment);
}

fn keep(i: u32, own: Value) {
    after[i] = own;
}

