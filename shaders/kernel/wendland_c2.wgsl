// Wendland's C2 function (Wendland 1995). Twin of src/model/kernel/wendland_c2.rs.

fn kernel_shape(q: real) -> real {
    let t = 1.0 - q;
    return t * t * t * t * (1.0 + 4.0 * q);
}

fn kernel_shape_dw_over_r(q: real) -> real {
    let t = 1.0 - q;
    return -20.0 * t * t * t;
}

