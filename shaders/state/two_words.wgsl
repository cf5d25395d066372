// A value of the state is the sum of two numbers, the second of which is what rounding took from the
// first. Values are subtracted word by word: where they are near each other, the difference of the
// first words is exact, and what is rounded is small.

alias Value = vec2<real>;

// A value, or a sum of differences of values, as one number.
fn collapsed(value: Value) -> real {
    return value.x + value.y;
}

fn exactly(number: real) -> Value {
    return Value(number, 0.0);
}

fn of_words(first: real, second: real) -> Value {
    return Value(first, second);
}

// The sum of two values: that of their first words is exact in two.
fn plus(value: Value, other: Value) -> Value {
    return accumulated(accumulated(exactly(value.x), other.x), value.y + other.y);
}

// A weight, which has the words of a value, times a number. Compilers would add up the words first.
fn times(weight: Value, number: real) -> real {
    return opaque(weight.x * number) + weight.y * number;
}

fn advanced(value: Value, increment: real) -> Value {
    return accumulated(value, increment);
}

