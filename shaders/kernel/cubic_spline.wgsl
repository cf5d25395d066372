// Cubic spline (Monaghan and Lattanzio 1985). Twin of src/model/kernel/cubic_spline.rs.

fn kernel_shape(q: real) -> real {
    let s = 2.0 * q;
    if s < 1.0 {
        return 1.0 - s * s * (1.5 - 0.75 * s);
    }
    let t = 2.0 - s;
    return 0.25 * t * t * t;
}

fn kernel_shape_dw_over_r(q: real) -> real {
    let s = 2.0 * q;
    if s < 1.0 {
        return 9.0 * s - 12.0;
    }
    let t = 2.0 - s;
    return -3.0 * t * t / s;
}

