// Calls `visit(row, other, q_squared)`, which the pass defines, for every neighbour of a row: cells
// z-major, then y, then x, and inside a cell in sorted order. q is the distance over the support
// radius.

fn search(row: u32) {
    let home = cell_coordinates(cell[row]);
    let here = load_offset(row);
    let first = vec3<i32>(
        first_step(home.x, grid.cells_x, PERIODIC_X),
        first_step(home.y, grid.cells_y, PERIODIC_Y),
        first_step(home.z, grid.cells_z, PERIODIC_Z),
    );
    let last = vec3<i32>(
        last_step(home.x, grid.cells_x, PERIODIC_X),
        last_step(home.y, grid.cells_y, PERIODIC_Y),
        last_step(home.z, grid.cells_z, PERIODIC_Z),
    );
    for (var z = first.z; z <= last.z; z++) {
        for (var y = first.y; y <= last.y; y++) {
            for (var x = first.x; x <= last.x; x++) {
                search_cell(row, here, home, vec3<i32>(x, y, z));
            }
        }
    }
}

fn search_cell(row: u32, here: vec3<real>, home: vec3<u32>, step: vec3<i32>) {
    let id = cell_id(vec3<u32>(
        stepped(home.x, step.x, grid.cells_x),
        stepped(home.y, step.y, grid.cells_y),
        stepped(home.z, step.z, grid.cells_z),
    ));
    let toward = vec3<real>(step) - here;
    for (var other = cell_start[id]; other < cell_start[id + 1u]; other++) {
        let q_squared = distance_squared(toward + load_offset(other));
        if other != row && q_squared < CUTOFF_SQUARED {
            visit(row, other, q_squared);
        }
    }
}

// Squared distance over the support radius, of a difference in cells.
fn distance_squared(difference: vec3<real>) -> real {
    let x = nearest_image(difference.x, grid.cells_x, PERIODIC_X) * grid.cell_over_support_x;
    let y = nearest_image(difference.y, grid.cells_y, PERIODIC_Y) * grid.cell_over_support_y;
    let z = nearest_image(difference.z, grid.cells_z, PERIODIC_Z) * grid.cell_over_support_z;
    return x * x + y * y + z * z;
}

