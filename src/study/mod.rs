//! Drivers above the solver: one run of a scene with its report, the benchmark, numerical stability.

mod bench;
mod recorder;
mod run;
mod stability;
mod stagnated;

pub use bench::{BenchOptions, BenchOutcome, BenchProgress, LEAST_SIZE, bench};
pub use run::{
    Driver, Operator, Outcome, Prepared, RunError, RunOptions, lattice_walls, prepare, run, start,
};
pub use stability::{StabilityOptions, StabilityOutcome, StabilityProgress, Tampering, stability};
