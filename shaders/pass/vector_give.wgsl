// Adds to totals in two words what a vector says that the outside gave.

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_give(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < entries.count {
        let at = place[i];
        total[at] = accumulated(total[at], collapsed(given[entries.first + i]));
    }
}
