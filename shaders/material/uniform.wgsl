// One material and one volume: both ratios to the reference are 1 for every particle.

fn volume_ratio(row: u32) -> real {
    return real(1.0);
}

fn diffusivity_ratio(row: u32) -> real {
    return real(1.0);
}

