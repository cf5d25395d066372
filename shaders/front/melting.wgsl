// Where materials melt. `fronts` has two vectors for each: the enthalpies where melting begins and ends, and the
// potential meanwhile, as the sum of two numbers; the mean distance of neighbours, in spacings, and one over the enthalpy
// of melting. What does not melt at one temperature begins after it ends, and is below that potential.

struct Front {
    begins: real,
    ends: real,
    potential: Value,
    distance: real,
    per_width: real,
}

fn front_at(index: u32) -> Front {
    let melts = fronts[2u * index];
    let more = fronts[2u * index + 1u];
    return Front(melts.x, melts.y, of_words(melts.z, melts.w), more.x, more.y);
}

fn is_melting(front: Front, enthalpy: real) -> bool {
    return front.begins < enthalpy && enthalpy < front.ends;
}

// How much more flows between what melts and a solid neighbour, or a liquid one, in parts.
fn front_excess(front: Front, enthalpy: real, is_solid: bool) -> real {
    let of_solid = (enthalpy - front.begins) * front.per_width - 0.5;
    let nearer = select(-of_solid, of_solid, is_solid);
    return nearer / (front.distance - nearer);
}

fn above_front(front: Front, potential: Value) -> real {
    return collapsed(potential - front.potential);
}
