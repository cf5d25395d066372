// To a vector of rates.

fn seam_share() -> real {
    return factors.scale;
}

