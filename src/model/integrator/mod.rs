//! Time integrators as data, and the times that a run must land on.

mod schedule;

pub use schedule::{Schedule, Segment};

/// A time integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Explicit Euler (115): first order, one operator application a step.
    Euler,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 1] = [Self::Euler];

    /// The name in case files, flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Euler => "euler",
        }
    }
}
