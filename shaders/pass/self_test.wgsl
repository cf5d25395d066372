// Adds an increment to each of some values, and takes the differences to two others, as to neighbours
// on opposite sides: whether this device keeps what rounding takes is seen by comparison with the same
// on the CPU.

@compute @workgroup_size(WORKGROUP_SIZE)
fn self_test(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&before) {
        let value = before[i];
        difference[i] = collapsed((other[i] - value) + (other[i ^ 1u] - value));
        after[i] = advanced(value, step_size.over_reference * rate[i]);
    }
}
