// Some rows get a diagonal and a source from walls. They carry WALL_BIT in their length, and after
// their last neighbour the list names their slot in `wall`: diagonal, flow, what entered, tick.

fn has_wall(row: u32) -> bool {
    return (row_length[row] & WALL_BIT) != 0u;
}

fn wall_slot(row: u32) -> u32 {
    let first = slice_start[row / SLICE_ROWS] + row % SLICE_ROWS;
    return neighbor[first + list_length(row) * SLICE_ROWS];
}

// What the rate of a row gets, whose own value is `own`.
fn wall_rate(row: u32, own: real) -> real {
    if !has_wall(row) {
        return real(0.0);
    }
    let slot = wall_slot(row);
    return wall[slot].x * own + wall_source_at(slot);
}

// Counts what enters through walls in a step, and the step itself.
fn record_inflow(row: u32, own: real, step: real) {
    if has_wall(row) {
        let slot = wall_slot(row);
        wall[slot].z += step * (wall[slot].y * own + wall_source_at(slot));
        end_step(slot);
    }
}

