// Capacity of each particle over the reference.
fn capacity_share(row: u32) -> real {
    return capacity[row];
}
