// The same, of a vector.

fn record_short(row: vec4<u32>, increment: real) {
    given[row.w] = advanced(given[row.w], -increment);
}

