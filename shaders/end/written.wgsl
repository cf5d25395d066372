// A place has an enthalpy after a step, and the potential that comes of it.

fn write_enthalpy(i: u32, enthalpy: Value) {
    let segment = segment_at(i, collapsed(enthalpy));
    content_after[i] = enthalpy;
    after[i] = potential_in(segment, above_start(segment, enthalpy));
    if melts_in(segment, collapsed(enthalpy)) {
        note(i);
    }
}
