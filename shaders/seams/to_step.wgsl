// To a step.

fn seam_share() -> real {
    return step_size.over_reference;
}

