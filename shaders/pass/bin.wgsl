// Puts every particle into the cell where its offset points: after a move, or where rounding to
// this precision has brought an offset to 1.

fn settle_axis(i: u32, axis: u32, at: u32, cells: u32, periodic: bool) -> u32 {
    let value = offset[i * DIMENSION + axis];
    let carry = i32(floor(value));
    offset[i * DIMENSION + axis] = value - real(settled_carry(at, carry, cells, periodic));
    return settled(at, carry, cells, periodic);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i >= grid.particles {
        return;
    }
    var at = cell_coordinates(cell[i]);
    at.x = settle_axis(i, 0u, at.x, grid.cells_x, PERIODIC_X);
    if DIMENSION > 1u {
        at.y = settle_axis(i, 1u, at.y, grid.cells_y, PERIODIC_Y);
    }
    if DIMENSION > 2u {
        at.z = settle_axis(i, 2u, at.z, grid.cells_z, PERIODIC_Z);
    }
    cell[i] = cell_id(at);
}
