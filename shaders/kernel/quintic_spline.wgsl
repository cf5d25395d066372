// Quintic spline (Morris, Fox and Zhu 1997). Twin of src/model/kernel/quintic_spline.rs.

fn power_4(t: real) -> real {
    return t * t * t * t;
}

fn kernel_shape(q: real) -> real {
    let s = 3.0 * q;
    var sum = power_4(3.0 - s) * (3.0 - s);
    if s < 2.0 {
        sum -= 6.0 * power_4(2.0 - s) * (2.0 - s);
    }
    if s < 1.0 {
        sum += 15.0 * power_4(1.0 - s) * (1.0 - s);
    }
    return sum;
}

fn kernel_shape_dw_over_r(q: real) -> real {
    let s = 3.0 * q;
    if s < 1.0 {
        return 9.0 * (-120.0 + s * s * (120.0 - 50.0 * s));
    }
    if s < 2.0 {
        return -45.0 * (power_4(3.0 - s) - 6.0 * power_4(2.0 - s)) / s;
    }
    return -45.0 * power_4(3.0 - s) / s;
}

