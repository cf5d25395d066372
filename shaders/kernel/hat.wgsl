// The hat (21), in 1-D; it diverges at q = 0. Twin of src/model/kernel/hat.rs.

fn kernel_shape(q: real) -> real {
    return 1.0 - q;
}

fn kernel_shape_dw_over_r(q: real) -> real {
    return -1.0 / q;
}

