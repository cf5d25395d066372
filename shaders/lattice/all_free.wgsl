// No particle is held.

fn is_held(row: u32) -> bool {
    return false;
}

fn rate_among_held(row: u32) -> real {
    return real(0.0);
}

fn record_exchange(row: u32, increment: real, step: real) {}

