// Sums over the stencil of a full lattice. Sites are numbered along x, then y, then z.

// What is found at a place along an axis.
struct Place {
    index: u32,
    // How much more than the value there a ghost behind a wall has, in parts of it: so that a wall that gives
    // little gives that to the rounding of the little.
    excess: real,
    // Nothing is past a free end.
    exists: bool,
}

fn along(at: u32, step: i32, count: u32, axis: u32, periodic: bool) -> Place {
    let place = i32(at) + step;
    let whole = i32(count);
    if place >= 0 && place < whole {
        return Place(u32(place), real(0.0), true);
    }
    if periodic {
        return Place(u32((place % whole + whole) % whole), real(0.0), true);
    }
    let upper = place >= whole;
    let layer = select(-1 - place, place - whole, upper);
    let end = 2u * axis + u32(upper);
    // A body thinner than the stencil has no particle that far in, whose ghost this would be.
    if layer >= whole || (MIRRORS >> end & 1u) == 0u {
        return Place(at, real(0.0), false);
    }
    let index = select(layer, whole - 1 - layer, upper);
    return Place(u32(index), ghost_excess[end * REACH + u32(layer)], true);
}

// The excess of a ghost of a ghost.
fn joined(one: real, other: real) -> real {
    return one + other + one * other;
}

// The difference to what is at a site, or to a ghost of it.
fn difference(site: u32, excess: real, exists: bool, own: Value) -> Value {
    let value = value_at(site);
    return select(exactly(real(0.0)), (value - own) + excess * value, exists);
}
