// The state is one buffer.

fn value_at(site: u32) -> Value {
    return before[site];
}

fn own_value(site: u32) -> Value {
    return before[site];
}

