// To a step of potentials.

fn seam_share() -> real {
    return step_size.over_reference;
}

