// Sums over the stencil of a full lattice. Sites are numbered along x, then y, then z.

// What is found at a place along an axis.
struct Place {
    index: u32,
    // Of the value there, where it is a ghost behind a wall.
    factor: real,
    // Nothing is past a free end.
    exists: bool,
}

fn along(at: u32, step: i32, count: u32, axis: u32, periodic: bool) -> Place {
    let place = i32(at) + step;
    let whole = i32(count);
    if place >= 0 && place < whole {
        return Place(u32(place), real(1.0), true);
    }
    if periodic {
        return Place(u32((place + whole) % whole), real(1.0), true);
    }
    let upper = place >= whole;
    let layer = select(-1 - place, place - whole, upper);
    let index = select(layer, whole - 1 - layer, upper);
    let end = 2u * axis + u32(upper);
    return Place(u32(index), edge_factor[end * REACH + u32(layer)], (MIRRORS >> end & 1u) == 1u);
}

// The sum where the stencil reaches past an end of the lattice.
fn edge_sum(at: vec3<u32>, own: real) -> real {
    var sum = real(0.0);
    for (var k = 0u; k < arrayLength(&entry); k++) {
        let x = along(at.x, i32(entry[k].x), NX, 0u, PERIODIC_X);
        let y = along(at.y, i32(entry[k].y), NY, 1u, PERIODIC_Y);
        let z = along(at.z, i32(entry[k].z), NZ, 2u, PERIODIC_Z);
        if x.exists && y.exists && z.exists {
            let value = value_at((z.index * NY + y.index) * NX + x.index);
            sum += entry[k].w * (x.factor * y.factor * z.factor * value - own);
        }
    }
    return sum;
}

fn is_inside(at: u32, count: u32, reach: u32) -> bool {
    return at >= reach && at + reach < count;
}

// sum_b w_ab (C_b - C_a) around a site: its rate of change, dimensionless in time. `interior_sum` is
// generated.
fn stencil_sum(site: u32, own: real) -> real {
    let at = vec3<u32>(site % NX, site / NX % NY, site / (NX * NY));
    if is_inside(at.x, NX, REACH) && is_inside(at.y, NY, REACH_Y) && is_inside(at.z, NZ, REACH_Z) {
        return interior_sum(site, own);
    }
    return edge_sum(at, own);
}

