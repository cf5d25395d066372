// All particles have the reference capacity.
fn capacity_share(row: u32) -> real {
    return real(1.0);
}
