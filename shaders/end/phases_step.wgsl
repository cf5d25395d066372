// A step takes potentials on as if nothing left its phase. What does is looked at after it: until then what melts has
// what is added to its enthalpy in place of a potential.

fn advance(i: u32, own: Value, increment: real) {
    let phases = phases_of(i);
    let above = collapsed(own - phases.melts);
    let next = advanced(own, slope_there(phases, above) * increment);
    after[i] = select(next, exactly(increment), above == 0.0);
    if leaves_phase(phases, above, collapsed(next - phases.melts)) {
        note(i);
    }
}

fn keep(i: u32, own: Value) {
    after[i] = own;
    if collapsed(own - phases_of(i).melts) == 0.0 {
        content_after[i] = content[i];
    }
}
