// The same of a lattice, whose held particles have a vector each.

fn record_short(row: vec4<u32>, increment: real) {
    let own = held[row.w];
    held[row.w] = vec4<real>(accumulated(own.xy, -increment), own.zw);
}

