// All places have one curve.

fn curve_bounds(place: u32) -> vec2<u32> {
    return vec2<u32>(0u, arrayLength(&curve) / 2u);
}

