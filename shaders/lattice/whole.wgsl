// The state is one buffer.

fn value_at(site: u32) -> real {
    return before[site];
}

fn own_value(site: u32) -> real {
    return before[site];
}

