// Wendland's C6 function (Wendland 1995). Twin of src/model/kernel/wendland_c6.rs.

fn kernel_shape(q: real) -> real {
    let t = 1.0 - q;
    let t2 = t * t;
    let t4 = t2 * t2;
    return t4 * t4 * (1.0 + q * (8.0 + q * (25.0 + q * 32.0)));
}

fn kernel_shape_dw_over_r(q: real) -> real {
    let t = 1.0 - q;
    let t2 = t * t;
    return -22.0 * t2 * t2 * t2 * t * (1.0 + q * (7.0 + q * 16.0));
}

