//! Explicit methods as recurrences for the change of the state over a step.
//!
//! With D_j the change after stage j, f(C) = A C + s the rate and F = f of the state at the start,
//!
//! D_j = mu D_(j-1) + nu D_(j-2) + last dt [A D_(j-1) + s(t_(j-1)) - s(t)] + first dt F,
//!
//! D_0 = 0. Changes instead of states: in f32 a state would lose what a stage adds (the textbook form
//! of RKL2 loses four digits of a long run).

/// The coefficients of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Of D_(j-1).
    pub mu: f64,
    /// Of D_(j-2).
    pub nu: f64,
    /// Of the step times what D_(j-1) and the time since the start of the step add to the rate.
    pub last: f64,
    /// Of the step times the rate at its start.
    pub first: f64,
    /// Where in the step the stage is, 0 to 1.
    pub time: f64,
}

/// An explicit method of second order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recurrence {
    /// Heun's method (Heun 1900).
    Heun,
    /// RKL2 (Meyer, Balsara and Aslam 2014, J. Comput. Phys. 257, 594).
    Rkl2,
}

impl Recurrence {
    /// The stages of a step of `dt` (s), where no eigenvalue of -A is above `largest` (1/s).
    pub fn stages(self, dt: f64, largest: f64) -> Vec<Stage> {
        match self {
            Self::Heun => vec![
                Stage { mu: 0.0, nu: 0.0, last: 0.0, first: 1.0, time: 1.0 },
                Stage { mu: 0.0, nu: 0.0, last: 0.5, first: 1.0, time: 1.0 },
            ],
            Self::Rkl2 => rkl2(rkl2_stages(dt * largest)),
        }
    }
}

/// Stages that a step of RKL2 needs where dt times the largest eigenvalue is `reach`: the least odd
/// number, 3 or more, with (s^2 + s - 2) / 2 >= `reach` (Meyer and others, equation 18).
pub fn rkl2_stages(reach: f64) -> usize {
    // s^2 + s - 2 = 2 reach; rounding must not ask for two more.
    let s = 0.5 * ((9.0 + 8.0 * reach.max(0.0)).sqrt() - 1.0) * (1.0 - 1e-12);
    let s = (s.ceil() as usize).max(3);
    s + (s + 1) % 2
}

/// What [`rkl2_stages`] stages reach.
pub fn rkl2_reach(stages: usize) -> f64 {
    let s = stages as f64;
    0.5 * (s * s + s - 2.0)
}

/// Equations 16 and 17 of Meyer and others, with the changes of stages in place of states.
fn rkl2(stages: usize) -> Vec<Stage> {
    let s = stages as f64;
    let w = 4.0 / (s * s + s - 2.0);
    let b = |j: usize| match j {
        0..=2 => 1.0 / 3.0,
        _ => (j * j + j - 2) as f64 / (2 * j * (j + 1)) as f64,
    };
    let first = b(1) * w;
    let stage = |j: usize| {
        let number = j as f64;
        let mu = (2.0 * number - 1.0) / number * b(j) / b(j - 1);
        let last = mu * w;
        Stage {
            mu,
            nu: -(number - 1.0) / number * b(j) / b(j - 2),
            last,
            // That with which it is in the rate of the stage before, less (1 - b_(j-1)) of it.
            first: b(j - 1) * last,
            time: (number * number + number - 2.0) / (s * s + s - 2.0),
        }
    };
    let first = Stage { mu: 0.0, nu: 0.0, last: 0.0, first, time: first };
    std::iter::once(first).chain((2..=stages).map(stage)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The change over a step of C' = -z C, C = 1, dt = 1.
    fn change(stages: &[Stage], z: f64) -> f64 {
        let (mut last, mut before) = (0.0, 0.0);
        for stage in stages {
            let next =
                stage.mu * last - stage.last * z * last + stage.nu * before - stage.first * z;
            (before, last) = (last, next);
        }
        last
    }

    /// What a method's change has beyond that of the first two orders, over z^2.
    fn defect(stages: &[Stage]) -> f64 {
        let z = 1e-3;
        (change(stages, z) + z - 0.5 * z * z) / (z * z)
    }

    #[test]
    fn both_are_of_second_order_and_a_wrong_coefficient_is_not() {
        for stages in [Recurrence::Heun.stages(1.0, 1.0), rkl2(3), rkl2(9), rkl2(77)] {
            assert!(defect(&stages).abs() < 1e-3, "{}", stages.len());
            let mut wrong = stages.clone();
            let last = wrong.len() - 1;
            wrong[last].first *= 1.01;
            assert!(defect(&wrong).abs() > 4e-3, "{}", stages.len());
        }
    }

    #[test]
    fn rkl2_is_stable_up_to_its_reach_and_not_far_beyond() {
        for s in [3, 5, 15, 77] {
            let stages = rkl2(s);
            let factor = |z: f64| (1.0 + change(&stages, z)).abs();
            let within = (1..=1000).map(|k| factor(f64::from(k) / 1000.0 * rkl2_reach(s)));
            assert!(within.fold(0.0, f64::max) <= 1.0, "{s} stages");
            assert!(factor(1.2 * rkl2_reach(s)) > 1.0, "{s} stages");
            assert_eq!(rkl2_stages(rkl2_reach(s)), s);
            assert_eq!(rkl2_stages(rkl2_reach(s) * 1.001), s + 2);
        }
        assert_eq!(rkl2_stages(0.0), 3);
    }

    #[test]
    fn the_last_stage_is_at_the_end_of_the_step() {
        for stages in [Recurrence::Heun.stages(1.0, 1.0), rkl2(7)] {
            assert!((stages[stages.len() - 1].time - 1.0).abs() < 1e-15);
            // Each stage is where a constant rate brings it.
            let (mut last, mut before) = (0.0, 0.0);
            for stage in &stages[..stages.len() - 1] {
                let next = stage.mu * last + stage.nu * before + stage.first;
                assert!((next - stage.time).abs() < 1e-12, "{next} {}", stage.time);
                (before, last) = (last, next);
            }
        }
    }
}
