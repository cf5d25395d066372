// What walls impose does not change.

fn wall_source_at(slot: u32) -> real {
    return wall_source[slot];
}

fn end_step(slot: u32) {}

