// Where materials melt. `fronts` has two vectors for each: the enthalpies where melting begins and ends, and the
// potential meanwhile, as the sum of two numbers; the mean distance of neighbours, in spacings. What does not
// melt at one temperature begins after it ends, and is below that potential.

struct Front {
    begins: real,
    ends: real,
    potential: Value,
    distance: real,
}

fn front_at(index: u32) -> Front {
    let melts = fronts[2u * index];
    return Front(melts.x, melts.y, of_words(melts.z, melts.w), fronts[2u * index + 1u].x);
}

fn is_melting(front: Front, enthalpy: real) -> bool {
    return front.begins < enthalpy && enthalpy < front.ends;
}

// How much more flows between what melts and a liquid neighbour, and a solid one, in parts.
fn front_excess(front: Front, enthalpy: real) -> vec2<real> {
    let s = (enthalpy - front.begins) / (front.ends - front.begins) - 0.5;
    return vec2<real>(-s / (front.distance + s), s / (front.distance - s));
}

fn above_front(front: Front, potential: Value) -> real {
    return collapsed(potential - front.potential);
}
