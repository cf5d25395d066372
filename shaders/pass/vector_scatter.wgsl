// Writes the source of each slot of a wall to its place in a part of a vector.

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = places.first_exception + flat_index(group, groups, lane);
    if row < places.end_exception && exception[row].y != NO_SLOT {
        after[exception[row].x - places.first_place] = exactly(source[exception[row].y]);
    }
}
