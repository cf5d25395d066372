// 4 a b / (a + b), the report's (109), in the form that neither overflows nor underflows.
fn pair_mean(a: real, b: real) -> real {
    return 4.0 / (1.0 / a + 1.0 / b);
}

