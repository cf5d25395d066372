//! Drivers above the solver: one run of a scene with its report.

mod recorder;
mod run;

pub use run::{Operator, Outcome, Prepared, RunError, RunOptions, lattice_walls, prepare, run};
