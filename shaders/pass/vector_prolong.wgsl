// Adds to each element of a vector the value of its aggregate.

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_prolong(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&after) && aggregate[i] < arrayLength(&values) {
        after[i] = plus(after[i], exactly(values[aggregate[i]]));
    }
}
