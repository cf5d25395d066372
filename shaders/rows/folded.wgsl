// Walls add to some rows, each of which has an element of `fold`: the row, its first and end entry, its
// slot. The mark of every row names its element, or is MARKED_MASK; WALL_BIT says that it has a slot.

fn folded(row: u32) -> vec4<u32> {
    let index = row_mark[row] & MARKED_MASK;
    if index == MARKED_MASK {
        return vec4<u32>(row, 0u, 0u, NO_SLOT);
    }
    return fold[index];
}

// What ghosts behind walls give to a row.
fn folded_sum(row: u32) -> real {
    let entries = folded(row);
    var sum = real(0.0);
    for (var entry = entries.y; entry < entries.z; entry++) {
        sum += fold_weight[entry] * collapsed(value_at(fold_neighbor[entry]) - own_value(row));
    }
    return sum;
}

// The factor of a row's own value in that.
fn folded_diagonal(row: u32) -> real {
    let entries = folded(row);
    var sum = real(0.0);
    for (var entry = entries.y; entry < entries.z; entry++) {
        sum -= fold_weight[entry];
    }
    return sum;
}

fn has_wall(row: u32) -> bool {
    return (row_mark[row] & WALL_BIT) != 0u;
}

fn wall_slot(row: u32) -> u32 {
    return folded(row).w;
}
