// What fronts change of a step of the rows of a chunk, or the tiles where they may.

@compute @workgroup_size(WORKGROUP_SIZE)
fn front(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = front_place(flat_index(group, groups, lane));
    if row < chunk.first_row || row >= chunk.end_row {
        return;
    }
    leave(row);
    if !begin(row) {
        return;
    }
    let increment = step_size.over_reference * row_sum(row);
    if is_held(row) {
        record_exchange(row, increment);
        keep_listed(row);
    } else {
        correct(row, increment);
    }
}
