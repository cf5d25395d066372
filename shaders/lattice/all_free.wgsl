// No particle is held.

fn is_held(row: u32) -> bool {
    return false;
}

fn record_exchange(row: u32, own: real, increment: real, step: real) {}

