// Raises the flag if a step has changed a value.

@compute @workgroup_size(WORKGROUP_SIZE)
fn still(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    // One is enough, and the others need not wait for each other.
    if i < arrayLength(&state) && collapsed(state[i] - before[i]) != 0.0 && atomicLoad(&flag[0]) == 0u {
        atomicMax(&flag[0], 1u);
    }
}
