// How many workgroups go through the places of a list, folded into two dimensions; empties another. One
// invocation does it: WORKGROUP_SIZE is that of the passes whose workgroups it counts.

@compute @workgroup_size(1)
fn front_size() {
    let workgroups = (listed[0] * TILE + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    let rows = max((workgroups + MOST_WORKGROUPS - 1u) / MOST_WORKGROUPS, 1u);
    size[0] = (workgroups + rows - 1u) / rows;
    size[1] = rows;
    size[2] = 1u;
    emptied[0] = 0u;
}
