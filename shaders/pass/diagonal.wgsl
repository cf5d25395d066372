// The factor of each row's own value in its rate, a reference step.

@compute @workgroup_size(WORKGROUP_SIZE)
fn diagonal(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = chunk.first_row + flat_index(group, groups, lane);
    if row < chunk.end_row {
        after[row] = exactly(row_diagonal(row) + wall_diagonal(row));
    }
}
