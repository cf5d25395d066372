//! Steps that follow a tolerance.

use crate::model::integrator::Tolerance;

/// What a step aims at, of what it may have.
const SAFETY: f64 = 0.9;

/// What a single step may have of the tolerance: since errors of single steps decay, and estimates are
/// on the safe side, more than its share.
const SHARE: f64 = 10.0;

/// The least factor from one step to the next.
const LEAST: f64 = 0.2;

/// Chooses steps of a method of second order.
///
/// A tolerance is asked of the result, but steps are judged one by one. A method of order p has an error
/// of about dt^(p + 1) in a step and dt^p at the end: what a step may have is the tolerance times its own
/// part of the scale to the power 1 / p, so that the error at the end follows the tolerance
/// (tolerance proportionality: Shampine 1985, SIAM J. Sci. Stat. Comput. 6, 1064).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    tolerance: Tolerance,
    /// The largest factor from one step to the next.
    growth: f64,
    /// The next step, s.
    dt: f64,
}

impl Controller {
    /// Starts with a step of `dt` (s).
    pub fn new(tolerance: Tolerance, growth: f64, dt: f64) -> Self {
        Self { tolerance, growth, dt }
    }

    /// What a step may have of an error where values are up to `scale`.
    pub fn limit(&self, scale: f64) -> f64 {
        let asked = self.tolerance.of(scale);
        let part = if scale > 0.0 { (asked / scale).min(1.0) } else { 1.0 };
        asked * (SHARE * part.sqrt()).min(1.0)
    }

    /// The next step where `remaining` (s) is left: no longer, and no less than half of it where it
    /// would leave little.
    pub fn step(&self, remaining: f64) -> f64 {
        if self.dt >= remaining * (1.0 - 1e-9) {
            remaining
        } else if self.dt > 0.5 * remaining {
            0.5 * remaining
        } else {
            self.dt
        }
    }

    /// Starts again with a step of `dt` (s): something changes at once.
    pub fn restart(&mut self, dt: f64) {
        self.dt = dt;
    }

    /// Takes note that a step of `dt` (s) has an error that is `part` of what it may have; returns
    /// whether that is to be taken.
    pub fn judge(&mut self, dt: f64, part: f64) -> bool {
        // An error that is no number is as bad as can be.
        let factor = SAFETY * part.powf(-1.0 / 3.0);
        let is_good = part <= 1.0;
        if is_good {
            let next = dt * factor.clamp(LEAST, self.growth);
            // A step that was cut short says nothing against the one that was meant.
            self.dt = if dt < self.dt { next.max(self.dt) } else { next };
        } else {
            self.dt = dt * if factor.is_finite() { factor.clamp(LEAST, SAFETY) } else { LEAST };
        }
        is_good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn controller() -> Controller {
        Controller::new(Tolerance { absolute: 0.0, relative: 1e-4 }, 1.2, 1.0)
    }

    #[test]
    fn a_good_step_grows_and_a_bad_one_is_taken_again() {
        let mut control = controller();
        assert!(control.judge(1.0, 1e-6));
        assert_eq!(control.step(100.0), 1.2);
        assert!(!control.judge(1.2, 8.0));
        assert!((control.step(100.0) - 1.2 * 0.45).abs() < 1e-12);
        assert!(!control.judge(0.54, f64::NAN));
        assert!((control.step(100.0) - 0.2 * 0.54).abs() < 1e-12);
    }

    #[test]
    fn steps_land_without_a_tiny_last_one() {
        let control = controller();
        assert_eq!([control.step(0.5), control.step(1.0), control.step(1.5)], [0.5, 1.0, 0.75]);
        let mut cut = controller();
        assert!(cut.judge(0.01, 0.5));
        assert_eq!(cut.step(100.0), 1.0, "a step that was cut short changes nothing");
    }

    #[test]
    fn what_a_step_may_have_falls_faster_than_the_tolerance() {
        let of = |relative| Controller::new(Tolerance { absolute: 0.0, relative }, 1.2, 1.0);
        let ratio = of(1e-4).limit(7.0) / of(1e-6).limit(7.0);
        assert!((ratio - 1e3).abs() < 1e-6, "{ratio}");
        assert_eq!(controller().limit(0.0), 0.0);
    }
}
