// What the matrix, or what a step has written, is short of where materials meet (`Seams` in src/model/operator/seams.rs). A
// row of `seam_row` has the place of a particle, its first and end pair, and its place among the held ones or NO_SLOT. A
// pair has the place of the other particle, the weight that is known of it, a reference step, and the matrix's over the mean
// of the reference conductivities.

struct Local {
    temperature: Value,
    potential: Value,
    conductivity: real,
}

// The rate that is missing, dimensionless in time.
fn seam_sum(row: vec4<u32>, is_changed: bool) -> real {
    let own = local_at(row.x, is_changed);
    var sum = real(0.0);
    for (var i = row.y; i < row.z; i++) {
        let other = local_at(seam_pair[i], is_changed);
        let weight = seam_weight[i];
        let mean = pair_mean(own.conductivity, other.conductivity);
        let by_heat = weight.y * mean * collapsed(other.temperature - own.temperature);
        sum += by_heat - weight.x * collapsed(other.potential - own.potential);
    }
    return sum;
}

