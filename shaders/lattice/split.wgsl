// The state is in parts, since it is larger than what a shader sees at once. A stencil reaches into
// the parts below and above its own.

fn value_at(site: u32) -> Value {
    if site >= part.first_site && site < part.end_site {
        return before[site - part.first_site];
    }
    if site >= part.below_first && site < part.below_end {
        return below[site - part.below_first];
    }
    return above[site - part.above_first];
}

fn own_value(site: u32) -> Value {
    return before[site - part.first_site];
}

