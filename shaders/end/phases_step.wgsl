// A step takes potentials on as if nothing left its phase. What does is looked at after it: until then what melts has
// what is added to its enthalpy in place of a potential.

fn advance(i: u32, own: Value, increment: real) {
    let above = collapsed(own - melting_potential());
    let next = advanced(own, slope_there(above) * increment);
    after[i] = select(next, exactly(increment), above == 0.0);
    if leaves_phase(above, collapsed(next - melting_potential())) {
        note(i);
    }
}

fn keep(i: u32, own: Value) {
    after[i] = own;
    if collapsed(own - melting_potential()) == 0.0 {
        content_after[i] = content[i];
    }
}
