// Writes the neighbours of each row of a chunk with their weights, into slices of SLICE_ROWS rows:
// neighbour k of a row sits SLICE_ROWS elements after neighbour k - 1.

var<private> position: u32;

fn visit(row: u32, other: u32, q_squared: real) {
    neighbor[position] = other;
    weight[position] = pair_weight(row, other, q_squared);
    position += SLICE_ROWS;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn list(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = chunk.first_row + flat_index(group, groups, lane);
    if row < chunk.end_row {
        position = slice_start[row / SLICE_ROWS] + row % SLICE_ROWS;
        search(row);
    }
}
