// The rate of change of the rows of a chunk, a reference step; 0 for held ones.

@compute @workgroup_size(WORKGROUP_SIZE)
fn rate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = chunk.first_row + flat_index(group, groups, lane);
    if row < chunk.end_row {
        let rate = row_sum(row) + wall_rate(row, collapsed(before[row]));
        after[row] = exactly(select(rate, real(0.0), is_held(row)));
    }
}
