//! Drivers above the solver: one run of a scene with its report.

mod recorder;
mod run;

pub use run::{Assembled, Outcome, Prepared, RunError, RunOptions, prepare, run};
