// One material and one volume: all ratios to the reference are 1 for every particle.

fn volume_ratio(row: u32) -> real {
    return real(1.0);
}

fn conductivity_ratio(row: u32) -> real {
    return real(1.0);
}

fn capacity_ratio(row: u32) -> real {
    return real(1.0);
}
