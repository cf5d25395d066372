//! Time integrators as data, and the times that a run must land on.

mod recurrence;
mod schedule;
mod tolerance;
mod tr_bdf2;

pub use recurrence::{Recurrence, Stage, rkl2_reach, rkl2_stages};
pub use schedule::{Schedule, Segment};
pub use tolerance::Tolerance;
pub use tr_bdf2::TrBdf2;

/// A time integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Explicit Euler (115): first order, one operator application a step.
    Euler,
    /// Heun's method: second order, two applications a step.
    Heun,
    /// Runge-Kutta-Legendre super time stepping: second order, s applications for a step that may be
    /// about s^2 / 4 times as long as that of explicit Euler.
    Rkl2,
    /// TR-BDF2: implicit, second order, L-stable; two linear systems a step.
    TrBdf2,
    /// No time at all: straight to the steady state.
    Steady,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 5] = [Self::Euler, Self::Heun, Self::Rkl2, Self::TrBdf2, Self::Steady];

    /// The name in case files, flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Euler => "euler",
            Self::Heun => "heun",
            Self::Rkl2 => "rkl2",
            Self::TrBdf2 => "tr_bdf2",
            Self::Steady => "steady",
        }
    }

    /// Whether it has an estimate of its error, so that a tolerance can set its steps.
    pub fn has_estimate(self) -> bool {
        matches!(self, Self::Heun | Self::Rkl2 | Self::TrBdf2)
    }

    /// Whether the largest eigenvalue limits its step.
    pub fn is_limited(self) -> bool {
        matches!(self, Self::Euler | Self::Heun)
    }

    /// Whether it solves linear systems, for which the operator has to be symmetric.
    pub fn is_implicit(self) -> bool {
        matches!(self, Self::TrBdf2 | Self::Steady)
    }
}

/// What conjugate gradients are preconditioned by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preconditioner {
    /// The diagonal alone.
    Jacobi,
    /// The diagonal and a coarse space of aggregates.
    TwoLevel,
}

impl Preconditioner {
    /// Every one.
    pub const ALL: [Self; 2] = [Self::Jacobi, Self::TwoLevel];

    /// The name in case files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jacobi => "jacobi",
            Self::TwoLevel => "two_level",
        }
    }
}

/// Where the method comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodChoice {
    /// The cheapest one that is accurate enough.
    Automatic,
    /// Given by the case.
    Given(Method),
}

impl MethodChoice {
    /// The name of the automatic choice.
    pub const AUTO: &'static str = "auto";

    /// Every choice.
    pub fn all() -> Vec<Self> {
        let given = Method::ALL.into_iter().map(Self::Given);
        given.chain([Self::Automatic]).collect()
    }

    /// The name in case files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Automatic => Self::AUTO,
            Self::Given(method) => method.name(),
        }
    }
}
