// Shares of a field and of its rate.

fn combined(own: Value, rate: real) -> Value {
    return advanced(factors.share * own, factors.scale * rate);
}

