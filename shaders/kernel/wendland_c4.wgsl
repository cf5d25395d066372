// Wendland's C4 function (Wendland 1995). Twin of src/model/kernel/wendland_c4.rs.

fn kernel_shape(q: real) -> real {
    let t = 1.0 - q;
    let t2 = t * t;
    return t2 * t2 * t2 * (1.0 + q * (6.0 + q * (35.0 / 3.0)));
}

fn kernel_shape_dw_over_r(q: real) -> real {
    let t = 1.0 - q;
    let t2 = t * t;
    return (-56.0 / 3.0) * t2 * t2 * t * (1.0 + 5.0 * q);
}

