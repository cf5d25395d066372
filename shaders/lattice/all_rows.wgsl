// Every site of a pass has a row of its own in place of the stencil.

fn row_sum(row: u32, site: u32, own: Value) -> real {
    return own_row_sum(row, own);
}
