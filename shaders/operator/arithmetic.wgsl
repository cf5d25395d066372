// a + b, the report's (107).
fn pair_mean(a: real, b: real) -> real {
    return a + b;
}

