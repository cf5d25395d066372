// One explicit Euler step of the rows of a chunk, the report's (115).

@compute @workgroup_size(WORKGROUP_SIZE)
fn step(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = chunk.first_row + flat_index(group, groups, lane);
    if row >= chunk.end_row {
        return;
    }
    let own = before[row];
    let step = step_size.over_reference;
    let increment = step * (row_sum(row) + wall_rate(row, collapsed(own)));
    record_inflow(row, collapsed(own), step);
    if is_held(row) {
        record_exchange(row, increment);
        keep(row, own);
    } else {
        advance(row, own, increment);
    }
}
