//! Drivers above the solver: one run of a scene with its report, a study of many runs, numerical
//! stability, and the benchmark.

mod bench;
mod memory;
mod pictures;
mod recorder;
mod run;
mod stability;
mod stagnated;
mod sweep;

pub use bench::{BenchOptions, BenchOutcome, BenchProgress, LEAST_SIZE, bench};
pub use run::{
    Driver, Operator, Outcome, Prepared, RunError, RunOptions, lattice_walls, prepare, run, start,
};
pub use stability::{StabilityOptions, StabilityOutcome, StabilityProgress, Tampering, stability};
pub use sweep::{StudyError, StudyOptions, StudyProgress, Vary, study, study_machine};
