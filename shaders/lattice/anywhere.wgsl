// Each neighbour is found for itself, wherever a site is: where values cost more than places, and sites of both kinds are
// worked on together, two sums would take twice as long as one.

// sum_b w_ab (C_b - C_a) around a site: its rate of change, dimensionless in time.
fn stencil_sum(site: u32, own: Value) -> real {
    return edge_sum(vec3<u32>(site % NX, site / NX % NY, site / (NX * NY)), own);
}
