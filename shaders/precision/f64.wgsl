// A NaN fails every comparison. There is no bit cast of an f64 without 64-bit integers.
fn is_finite(value: real) -> bool {
    return abs(value) <= LARGEST;
}

