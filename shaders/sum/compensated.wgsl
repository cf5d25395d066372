// Sums that keep what rounding takes: the second word of a total is part of it (Knuth 1969, The Art
// of Computer Programming 2, 4.2.2, theorem B).

// The same number. A compiler that takes sums for exact would delete the compensation, since it
// finds that it is 0; it cannot see through this, as it does not know the zero.
fn opaque(number: real) -> real {
    return bitcast<real>(bitcast<u32>(number) ^ step_size.opaque_zero);
}

fn accumulated(total: vec2<real>, increment: real) -> vec2<real> {
    let added = increment + total.y;
    let sum = opaque(total.x + added);
    let taken = opaque(sum - total.x);
    return vec2<real>(sum, (total.x - (sum - taken)) + (added - taken));
}

