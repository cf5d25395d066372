// A value of the state is one number.

alias Value = real;

// A value, or a sum of differences of values, as one number.
fn collapsed(value: Value) -> real {
    return value;
}

fn exactly(number: real) -> Value {
    return number;
}

fn of_words(first: real, second: real) -> Value {
    return first + second;
}

fn plus(value: Value, other: Value) -> Value {
    return value + other;
}

// A weight, which has the words of a value, times a number.
fn times(weight: Value, number: real) -> real {
    return weight * number;
}

fn advanced(value: Value, increment: real) -> Value {
    return value + increment;
}

