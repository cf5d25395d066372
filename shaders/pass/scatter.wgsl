// Puts the particles of each cell side by side, in an order that differs from run to run.

@compute @workgroup_size(WORKGROUP_SIZE)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < grid.particles {
        let id = cell[i];
        scattered[cell_start[id] + atomicAdd(&taken[id], 1u)] = i;
    }
}
