// Some sites have rows of their own in place of the stencil.

fn row_sum(row: u32, site: u32, own: Value) -> real {
    if exception[row].w == NO_SLOT {
        return site_sum(site, own);
    }
    return own_row_sum(row, own);
}
