// The state is in parts, as in `lattice/split`.

fn potential_at(site: u32) -> Value {
    if site >= part.first_site && site < part.end_site {
        return before[site - part.first_site];
    }
    if site >= part.below_first && site < part.below_end {
        return below[site - part.below_first];
    }
    return above[site - part.above_first];
}

fn content_at(site: u32) -> Value {
    if site >= part.first_site && site < part.end_site {
        return content[site - part.first_site];
    }
    if site >= part.below_first && site < part.below_end {
        return content_below[site - part.below_first];
    }
    return content_above[site - part.above_first];
}
