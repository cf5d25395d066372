// The sites where more than the stencil acts: each has its number, its slot in `wall`, its place among the
// held ones and the first element of its row, or NO_SLOT.

fn has_wall(row: u32) -> bool {
    return exception[row].y != NO_SLOT;
}

fn wall_slot(row: u32) -> u32 {
    return exception[row].y;
}

