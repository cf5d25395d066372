//! The coefficients of TR-BDF2.

use std::f64::consts::SQRT_2;

/// TR-BDF2 (Bank and others 1985, IEEE Trans. Electron Devices 32, 1992; Hosea and Shampine 1996, Appl.
/// Numer. Math. 20, 21): the trapezoidal rule over a part gamma of the step, then the second backward
/// difference formula. Both stages solve with one matrix, 1 - d dt A.
///
/// For the changes D1 and D2 of the state after the stages, with F the rate at the start and s what is
/// imposed:
///
/// (1 - d dt A) D1 = d dt [2 F + s(t + gamma dt) - s(t)],
/// (1 - d dt A) D2 = alpha D1 + d dt [F + s(t + dt) - s(t)].
pub struct TrBdf2;

impl TrBdf2 {
    /// Where the first stage ends, as a part of the step.
    pub const GAMMA: f64 = 2.0 - SQRT_2;
    /// The implicit part of the step in each stage.
    pub const D: f64 = 0.5 * Self::GAMMA;
    /// Of the change of the first stage in the second.
    pub const ALPHA: f64 = 1.0 / (Self::GAMMA * (2.0 - Self::GAMMA));
    /// Weight of the rates at the start and of the first stage in the step.
    pub const W: f64 = 0.25 * SQRT_2;
    /// The difference to the embedded method of third order (Hosea and Shampine, equation 13) is a sum of
    /// dt F, D1 and D2 with these factors.
    pub const ERROR: [f64; 3] =
        [4.0 * Self::W / 3.0, -(1.0 + 2.0 * Self::W) / (3.0 * Self::D), 2.0 / 3.0];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The changes of both stages for C' = -z C, C = 1, dt = 1.
    fn changes(z: f64) -> [f64; 2] {
        let matrix = 1.0 + TrBdf2::D * z;
        let first = -TrBdf2::D * 2.0 * z / matrix;
        [first, (TrBdf2::ALPHA * first - TrBdf2::D * z) / matrix]
    }

    #[test]
    fn it_is_of_second_order_and_damps_what_is_fast() {
        let z = 1e-3;
        let defect = (changes(z)[1] + z - 0.5 * z * z) / (z * z);
        assert!(defect.abs() < 1e-3, "{defect:e}");
        assert!((1.0 + changes(1e9)[1]).abs() < 1e-6);
    }

    #[test]
    fn the_embedded_difference_is_the_error_up_to_its_order() {
        for z in [1e-2, 1e-3] {
            let [first, second] = changes(z);
            let [f, d1, d2] = TrBdf2::ERROR;
            let estimate = -f * z + d1 * first + d2 * second;
            let error = (-z).exp_m1() - second;
            assert!(
                (estimate.abs() / error.abs() - 1.0).abs() < 20.0 * z,
                "{estimate:e} {error:e}"
            );
        }
    }
}
