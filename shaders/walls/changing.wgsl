// What walls impose changes: `wall_source` is a ring of SOURCE_STEPS steps, and each slot counts
// its own steps, so that none has to wait for another.

fn wall_source_at(slot: u32) -> real {
    return wall_source[u32(wall[2u * slot].z) * (arrayLength(&wall) / 2u) + slot];
}

fn end_step(slot: u32) {
    wall[2u * slot].z = real((u32(wall[2u * slot].z) + 1u) % SOURCE_STEPS);
}

