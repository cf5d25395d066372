// What fronts change of a step of the rows of a chunk.

@compute @workgroup_size(WORKGROUP_SIZE)
fn front(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = chunk.first_row + flat_index(group, groups, lane);
    if row >= chunk.end_row || !begin(row, row) {
        return;
    }
    let increment = step_size.over_reference * row_sum(row);
    if is_held(row) {
        record_exchange(row, increment);
    } else {
        after[row] = advanced(after[row], increment);
    }
}
