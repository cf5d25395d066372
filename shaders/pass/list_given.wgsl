// What held particles and walls give to the rows of a chunk, of the same combination.

@compute @workgroup_size(WORKGROUP_SIZE)
fn list_given(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = flat_index(group, groups, lane);
    if index >= arrayLength(&exception) {
        return;
    }
    let row = exception[index].x;
    if row < chunk.first_row || row >= chunk.end_row {
        return;
    }
    if is_held(row) {
        record_given(exception[index].z, -row_sum(row));
    }
    if has_wall(row) {
        record_given(factors.held + wall_slot(row), inflow(row, collapsed(before[row])));
    }
}
