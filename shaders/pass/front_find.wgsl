// Lists what melts.

@compute @workgroup_size(WORKGROUP_SIZE)
fn front_find(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&content) {
        let enthalpy = collapsed(content[i]);
        if melts_in(segment_at(i, enthalpy), enthalpy) {
            note(i);
        }
    }
}
