// Most sites have all neighbours of the stencil.

fn is_inside(at: u32, count: u32, reach: u32) -> bool {
    return at >= reach && at + reach < count;
}

// sum_b w_ab (C_b - C_a) around a site: its rate of change, dimensionless in time. `interior_sum`
// knows the distances to all neighbours; `edge_sum` finds each.
fn stencil_sum(site: u32, own: Value) -> real {
    let at = vec3<u32>(site % NX, site / NX % NY, site / (NX * NY));
    if is_inside(at.x, NX, REACH) && is_inside(at.y, NY, REACH_Y) && is_inside(at.z, NZ, REACH_Z) {
        return interior_sum(site, own);
    }
    return edge_sum(at, own);
}
