// Something is added to what a step has written, before it is looked at what leaves its phase.

fn correct(i: u32, increment: real) {
    let phases = phases_of(i);
    let above = collapsed(state[i] - phases.melts);
    let slope = select(slope_there(phases, above), real(1.0), above == 0.0);
    let next = advanced(after[i], slope * increment);
    after[i] = next;
    // What melts is looked at already.
    if above != 0.0 && leaves_phase(phases, above, collapsed(next - phases.melts)) {
        note(i);
    }
}
