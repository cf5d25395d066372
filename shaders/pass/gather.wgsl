// Copies offsets and cells into sorted order.

@compute @workgroup_size(WORKGROUP_SIZE)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = flat_index(group, groups, lane);
    if row >= grid.particles {
        return;
    }
    let particle = order[row];
    for (var axis = 0u; axis < DIMENSION; axis++) {
        sorted_offset[row * DIMENSION + axis] = offset[particle * DIMENSION + axis];
    }
    sorted_cell[row] = cell[particle];
}
