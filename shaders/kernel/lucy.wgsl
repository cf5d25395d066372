// Lucy's kernel (Lucy 1977), the report's (183) and (184). Twin of src/model/kernel/lucy.rs.

fn kernel_shape(q: real) -> real {
    let t = 1.0 - q;
    return t * t * t * (1.0 + 3.0 * q);
}

fn kernel_shape_dw_over_r(q: real) -> real {
    let t = 1.0 - q;
    return -12.0 * t * t;
}

