// Cells, numbered x fastest. Offsets are stored DIMENSION reals a particle; the axes past it have
// one cell and offset 0, and the compiler drops their arithmetic.

fn cell_coordinates(id: u32) -> vec3<u32> {
    let layer = id / grid.cells_x;
    if DIMENSION == 1u {
        return vec3<u32>(id, 0u, 0u);
    }
    if DIMENSION == 2u {
        return vec3<u32>(id % grid.cells_x, layer, 0u);
    }
    return vec3<u32>(id % grid.cells_x, layer % grid.cells_y, layer / grid.cells_y);
}

fn cell_id(at: vec3<u32>) -> u32 {
    return (at.z * grid.cells_y + at.y) * grid.cells_x + at.x;
}

// Offset of a particle in its cell, in cells.
fn load_offset(i: u32) -> vec3<real> {
    var value = vec3<real>();
    value.x = offset[i * DIMENSION];
    if DIMENSION > 1u {
        value.y = offset[i * DIMENSION + 1u];
    }
    if DIMENSION > 2u {
        value.z = offset[i * DIMENSION + 2u];
    }
    return value;
}

