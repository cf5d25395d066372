// Something is added to what was written.

fn correct(i: u32, increment: real) {
    after[i] = advanced(after[i], increment);
}

