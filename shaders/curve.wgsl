// The potential of an enthalpy. `curve` has two vectors for each segment: where it begins and the
// potential there, each as the sum of two numbers; slope, and half of how that changes.

fn segment_at(enthalpy: real) -> u32 {
    var first = 0u;
    var end = arrayLength(&curve) / 2u;
    while end - first > 1u {
        let middle = (first + end) / 2u;
        if curve[2u * middle].x <= enthalpy {
            first = middle;
        } else {
            end = middle;
        }
    }
    return first;
}

// How far an enthalpy is above where its segment begins.
fn above_start(segment: u32, enthalpy: Value) -> Value {
    let start = curve[2u * segment].xy;
    return plus(enthalpy, of_words(-start.x, -start.y));
}

fn potential_of(enthalpy: Value) -> Value {
    let segment = segment_at(collapsed(enthalpy));
    let above = above_start(segment, enthalpy);
    let shape = curve[2u * segment + 1u];
    let base = curve[2u * segment].zw;
    return plus(of_words(base.x, base.y), (shape.x + shape.y * collapsed(above)) * above);
}

// d potential / d enthalpy.
fn slope_of(enthalpy: Value) -> real {
    let segment = segment_at(collapsed(enthalpy));
    let shape = curve[2u * segment + 1u];
    return shape.x + 2.0 * shape.y * collapsed(above_start(segment, enthalpy));
}
