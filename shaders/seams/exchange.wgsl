// What a held particle would have gained, it has taken from the others.

fn record_short(row: vec4<u32>, increment: real) {
    exchange[row.x] = accumulated(exchange[row.x], -increment);
}

