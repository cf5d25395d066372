// Rows in place of the stencil. `exception` names the first element of each, and the others follow SLICE_ROWS apart: the
// number of neighbours, then these with their weights.

fn own_row_sum(row: u32, own: Value) -> real {
    let first = exception[row].w;
    let end = first + (row_neighbor[first] + 1u) * SLICE_ROWS;
    var sum = real(0.0);
    for (var i = first + SLICE_ROWS; i < end; i += SLICE_ROWS) {
        sum += times(row_weight[i], collapsed(value_at(row_neighbor[i]) - own));
    }
    return sum;
}
