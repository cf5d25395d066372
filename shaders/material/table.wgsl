// Volume, conductivity and capacity of each row, over those that weights are relative to.

fn volume_ratio(row: u32) -> real {
    return coefficient[row].x;
}

fn conductivity_ratio(row: u32) -> real {
    return coefficient[row].y;
}

fn capacity_ratio(row: u32) -> real {
    return coefficient[row].z;
}
