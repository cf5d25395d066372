// The sums over a stencil with many neighbours, as loops over the buffer of them. Each of its entries
// stands for the neighbour on the other side as well, and the differences to both are added first.

fn interior_sum(site: u32, own: Value) -> real {
    var sum = real(0.0);
    for (var k = 0u; k < arrayLength(&entry); k++) {
        let step = vec3<i32>(entry[k].xyz);
        let further = u32((step.z * i32(NY) + step.y) * i32(NX) + step.x);
        let differences = (value_at(site - further) - own) + (value_at(site + further) - own);
        sum += times(entry_weight[k], collapsed(differences));
    }
    return sum;
}

fn edge_sum(at: vec3<u32>, own: Value) -> real {
    var sum = real(0.0);
    for (var k = 0u; k < arrayLength(&entry); k++) {
        let step = vec3<i32>(entry[k].xyz);
        let differences = edge_difference(at, -step, own) + edge_difference(at, step, own);
        sum += times(entry_weight[k], collapsed(differences));
    }
    return sum;
}

fn edge_difference(at: vec3<u32>, step: vec3<i32>, own: Value) -> Value {
    let x = along(at.x, step.x, NX, 0u, PERIODIC_X);
    let y = along(at.y, step.y, NY, 1u, PERIODIC_Y);
    let z = along(at.z, step.z, NZ, 2u, PERIODIC_Z);
    let site = (z.index * NY + y.index) * NX + x.index;
    let excess = joined(joined(x.excess, y.excess), z.excess);
    return difference(site, excess, x.exists && y.exists && z.exists, own);
}

