// Something is added to an enthalpy that a step has written.

fn correct(i: u32, increment: real) {
    write_enthalpy(i, advanced(content_after[i], increment));
}

