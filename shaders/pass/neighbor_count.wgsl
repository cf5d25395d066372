// Counts the neighbours of each row.

var<private> found: u32;

fn visit(row: u32, other: u32, q_squared: real) {
    found++;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn neighbor_count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = flat_index(group, groups, lane);
    if row < grid.particles {
        search(row);
        row_length[row] = found;
    }
}
