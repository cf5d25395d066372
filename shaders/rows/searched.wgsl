// Neighbours are searched for, and their weights computed, in every sum: no memory but that of the
// sorted particles.

var<private> searched_value: Value;
var<private> searched_sum: real;

fn visit(row: u32, other: u32, q_squared: real) {
    searched_sum += pair_weight(row, other, q_squared) * collapsed(value_at(other) - searched_value);
}

// sum_b w_ab (C_b - C_a) of a row: its rate of change, dimensionless in time.
fn row_sum(row: u32) -> real {
    searched_value = own_value(row);
    searched_sum = real(0.0);
    search(row);
    return searched_sum + folded_sum(row);
}
