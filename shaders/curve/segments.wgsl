// The potential of an enthalpy. `curve` has two vectors for each segment: where it begins and the
// potential there, each as the sum of two numbers; slope, half of how that changes, and, only where
// materials meet, conductivity and how that changes. `curve_bounds` names the segments of a place.

fn segment_at(place: u32, enthalpy: real) -> u32 {
    let bounds = curve_bounds(place);
    var first = bounds.x;
    var end = bounds.y;
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

// The potential so far above where a segment begins.
fn potential_in(segment: u32, above: Value) -> Value {
    let shape = curve[2u * segment + 1u];
    let base = curve[2u * segment].zw;
    return plus(of_words(base.x, base.y), (shape.x + shape.y * collapsed(above)) * above);
}

fn potential_of(place: u32, enthalpy: Value) -> Value {
    let segment = segment_at(place, collapsed(enthalpy));
    return potential_in(segment, above_start(segment, enthalpy));
}

// Whether an enthalpy of a segment melts at one temperature: potentials do not rise there, and its start is a solid
// still.
fn melts_in(segment: u32, enthalpy: real) -> bool {
    return curve[2u * segment + 1u].x == 0.0 && enthalpy > curve[2u * segment].x;
}

// d potential / d enthalpy.
fn slope_of(place: u32, enthalpy: Value) -> real {
    let segment = segment_at(place, collapsed(enthalpy));
    let shape = curve[2u * segment + 1u];
    return shape.x + 2.0 * shape.y * collapsed(above_start(segment, enthalpy));
}
