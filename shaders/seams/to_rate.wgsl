// To rates a reference step.

fn seam_share() -> real {
    return real(1.0);
}

