// Sums in f64, which lose nothing that counts.

fn accumulated(total: vec2<real>, increment: real) -> vec2<real> {
    return vec2<real>(total.x + increment, 0.0);
}

