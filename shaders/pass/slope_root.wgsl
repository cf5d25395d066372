// The square root of d potential / d enthalpy after a change of the state.

@compute @workgroup_size(WORKGROUP_SIZE)
fn slope_root(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&after) {
        after[i] = exactly(sqrt(slope_of(i, plus(content[i], change[i]))));
    }
}
