// Neighbours with their weights from the list. A row's mark has its length, with HELD_BIT in held rows
// and WALL_BIT in those with a slot of a wall, which their list names after the last neighbour.

// How many neighbours a row has.
fn list_length(row: u32) -> u32 {
    return row_mark[row] & MARKED_MASK;
}

// sum_b w_ab (C_b - C_a) over the list of a row: its rate of change, dimensionless in time.
fn row_sum(row: u32) -> real {
    let own = own_value(row);
    let first = slice_start[row / SLICE_ROWS] + row % SLICE_ROWS;
    let end = first + list_length(row) * SLICE_ROWS;
    var sum = real(0.0);
    for (var i = first; i < end; i += SLICE_ROWS) {
        sum += weight[i] * collapsed(value_at(neighbor[i]) - own);
    }
    return sum;
}

// The factor of a row's own value in that.
fn row_diagonal(row: u32) -> real {
    let first = slice_start[row / SLICE_ROWS] + row % SLICE_ROWS;
    let end = first + list_length(row) * SLICE_ROWS;
    var sum = real(0.0);
    for (var i = first; i < end; i += SLICE_ROWS) {
        sum -= weight[i];
    }
    return sum;
}

fn has_wall(row: u32) -> bool {
    return (row_mark[row] & WALL_BIT) != 0u;
}

fn wall_slot(row: u32) -> u32 {
    let first = slice_start[row / SLICE_ROWS] + row % SLICE_ROWS;
    return neighbor[first + list_length(row) * SLICE_ROWS];
}
