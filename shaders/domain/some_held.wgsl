// Some particles keep their value; the marks of their rows carry HELD_BIT.

fn is_held(row: u32) -> bool {
    return (row_mark[row] & HELD_BIT) != 0u;
}

// What a held particle would have gained, it has taken from the others.
fn record_exchange(row: u32, increment: real) {
    exchange[row] = accumulated(exchange[row], -increment);
}

