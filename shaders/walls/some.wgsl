// Some rows get a diagonal and a source from walls. They have a slot in `wall`: diagonal, flow, what
// entered, tick. `has_wall` and `wall_slot` belong to the path.

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

