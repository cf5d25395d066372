// Adds to each value the sum of the blocks before its own.

@compute @workgroup_size(WORKGROUP_SIZE)
fn scan_add(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&values) {
        values[i] += sums[i / (WORKGROUP_SIZE * SCAN_ITEMS)];
    }
}
