// The weight w_ab of a pair, a reference step; q is the distance over the support radius.
fn pair_weight(row: u32, other: u32, q_squared: real) -> real {
    let mean = pair_mean(conductivity_ratio(row), conductivity_ratio(other)) / capacity_ratio(row);
    let shape = -kernel_shape_dw_over_r(sqrt(q_squared));
    return grid.weight_scale * volume_ratio(other) * mean * shape;
}
