// Volume and diffusivity of each row, over the reference volume and diffusivity.

fn volume_ratio(row: u32) -> real {
    return coefficient[row].x;
}

fn diffusivity_ratio(row: u32) -> real {
    return coefficient[row].y;
}

