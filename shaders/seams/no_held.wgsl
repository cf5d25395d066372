// No particle is held.

fn record_short(row: vec4<u32>, increment: real) {}

