// Raises the flag if a value is not finite.

@compute @workgroup_size(WORKGROUP_SIZE)
fn finite(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&state) && !is_finite(collapsed(state[i])) {
        atomicMax(&flag[0], 1u);
    }
}
