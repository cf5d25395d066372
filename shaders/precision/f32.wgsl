// Infinities and NaN have all exponent bits set. Compilers may assume that a float is finite, but
// not so of its bits.
fn is_finite(value: real) -> bool {
    return (bitcast<u32>(value) & 0x7f800000u) != 0x7f800000u;
}

