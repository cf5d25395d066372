// The sums over a stencil with many neighbours, as loops over the buffer of them.

fn interior_sum(site: u32, own: real) -> real {
    var sum = real(0.0);
    for (var k = 0u; k < arrayLength(&entry); k++) {
        let step = vec3<i32>(entry[k].xyz);
        let further = (step.z * i32(NY) + step.y) * i32(NX) + step.x;
        sum += entry[k].w * (value_at(u32(i32(site) + further)) - own);
    }
    return sum;
}

fn edge_sum(at: vec3<u32>, own: real) -> real {
    var sum = real(0.0);
    for (var k = 0u; k < arrayLength(&entry); k++) {
        let step = vec3<i32>(entry[k].xyz);
        let x = along(at.x, step.x, NX, 0u, PERIODIC_X);
        let y = along(at.y, step.y, NY, 1u, PERIODIC_Y);
        let z = along(at.z, step.z, NZ, 2u, PERIODIC_Z);
        let site = (z.index * NY + y.index) * NX + x.index;
        let factor = x.factor * y.factor * z.factor;
        let exists = x.exists && y.exists && z.exists;
        sum += entry[k].w * difference(site, factor, exists, own);
    }
    return sum;
}

