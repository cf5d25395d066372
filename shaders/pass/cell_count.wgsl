// Counts the particles of each cell.

@compute @workgroup_size(WORKGROUP_SIZE)
fn cell_count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < grid.particles {
        atomicAdd(&count[cell[i]], 1u);
    }
}
