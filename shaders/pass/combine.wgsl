// A share of each value and of its rate, for the rows of a chunk; held ones have the rate 0.

@compute @workgroup_size(WORKGROUP_SIZE)
fn combine(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = chunk.first_row + flat_index(group, groups, lane);
    if row < chunk.end_row {
        let own = before[row];
        let rate = row_sum(row) + wall_rate(row, collapsed(own));
        after[row] = combined(own, select(rate, real(0.0), is_held(row)));
    }
}
