// Adds to the weights of a chunk's rows what ghosts behind walls give them, and writes the slot of
// a row behind its last neighbour. `fold` holds a row, its first and end entry, and its slot.

@compute @workgroup_size(WORKGROUP_SIZE)
fn wall_fold(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = flat_index(group, groups, lane);
    if index >= arrayLength(&fold) {
        return;
    }
    let row = fold[index].x;
    if row < chunk.first_row || row >= chunk.end_row {
        return;
    }
    let first = slice_start[row / SLICE_ROWS] + row % SLICE_ROWS;
    let end = first + (row_mark[row] & MARKED_MASK) * SLICE_ROWS;
    for (var entry = fold[index].y; entry < fold[index].z; entry++) {
        for (var i = first; i < end; i += SLICE_ROWS) {
            if neighbor[i] == fold_neighbor[entry] {
                weight[i] += fold_weight[entry];
            }
        }
    }
    if fold[index].w != NO_SLOT {
        neighbor[end] = fold[index].w;
    }
}
