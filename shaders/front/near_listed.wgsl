// What is in no listed tile is left out: nothing melts there, or nothing around it.

fn is_near(local: u32) -> bool {
    return (atomicLoad(&tiles[local / TILE]) & LISTED) != 0u;
}
