// Multiplies each element of a vector by that of another.

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_multiply(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&after) {
        after[i] = collapsed(by[i]) * after[i];
    }
}
