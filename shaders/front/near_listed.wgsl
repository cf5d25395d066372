// What is in no listed tile has no neighbour that melts.

fn is_near(local: u32) -> bool {
    return (atomicLoad(&tiles[local / TILE]) & LISTED) != 0u;
}
