// Some particles keep their value; the rows of these carry HELD_BIT in their length.

fn is_held(row: u32) -> bool {
    return (row_length[row] & HELD_BIT) != 0u;
}

// What a held particle would have gained, it has taken from the others.
fn record_exchange(row: u32, increment: real) {
    exchange[row] = accumulated(exchange[row], -increment);
}

