// As `searched`, for the factor of a row's own value.

var<private> searched_sum: real;

fn visit(row: u32, other: u32, q_squared: real) {
    searched_sum -= pair_weight(row, other, q_squared);
}

// The factor of a row's own value in its sum.
fn row_diagonal(row: u32) -> real {
    searched_sum = real(0.0);
    search(row);
    return searched_sum + folded_diagonal(row);
}
