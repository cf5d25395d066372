// The state is in parts, as in `lattice/split`. Nothing is marked, since marks would have to be in all of them.

fn potential_at(site: u32) -> Value {
    if site >= part.first_site && site < part.end_site {
        return before[site - part.first_site];
    }
    if site >= part.below_first && site < part.below_end {
        return below[site - part.below_first];
    }
    return above[site - part.above_first];
}

fn enthalpy_at(site: u32) -> Value {
    if site >= part.first_site && site < part.end_site {
        return content[site - part.first_site];
    }
    if site >= part.below_first && site < part.below_end {
        return content_below[site - part.below_first];
    }
    return content_above[site - part.above_first];
}

// Whether a place may have a neighbour that melts.
fn is_near(local: u32) -> bool {
    return true;
}
