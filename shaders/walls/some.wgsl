// Some rows get a diagonal and a source from walls. They have a slot of two vectors in
// `wall`: diagonal, flow and tick; what entered, in two words. `has_wall` and `wall_slot` belong to
// the path.

// What the rate of a row gets, whose own value is `own`.
fn wall_rate(row: u32, own: real) -> real {
    if !has_wall(row) {
        return real(0.0);
    }
    let slot = wall_slot(row);
    return wall[2u * slot].x * own + wall_source_at(slot);
}

// The factor of a row's own value in that.
fn wall_diagonal(row: u32) -> real {
    if !has_wall(row) {
        return real(0.0);
    }
    return wall[2u * wall_slot(row)].x;
}

// What enters through walls a reference step, in a row that has a slot.
fn inflow(row: u32, own: real) -> real {
    let slot = wall_slot(row);
    return wall[2u * slot].y * own + wall_source_at(slot);
}

// Counts what enters through walls in a step, and the step itself.
fn record_inflow(row: u32, own: real, step: real) {
    if has_wall(row) {
        let slot = wall_slot(row);
        let entered = step * inflow(row, own);
        let total = accumulated(wall[2u * slot + 1u].xy, entered);
        wall[2u * slot + 1u] = vec4<real>(total, real(0.0), real(0.0));
        end_step(slot);
    }
}

