// Adds what the matrix, or what is written, is short of where materials meet, in the share of `seam_share`.

@compute @workgroup_size(WORKGROUP_SIZE)
fn seam(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = flat_index(group, groups, lane);
    if index >= arrayLength(&seam_row) {
        return;
    }
    let row = seam_row[index];
    let increment = seam_share() * shortage(row);
    if row.w == NO_SLOT {
        correct(row.x, increment);
    } else {
        record_short(row, increment);
    }
}
