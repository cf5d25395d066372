//! Drivers above the solver: one run of a scene with its report, a study of many runs, numerical
//! stability, and the benchmark.

mod bench;
mod memory;
mod pictures;
mod prepare;
mod recorder;
mod run;
mod stability;
mod stagnated;
mod sweep;

pub use bench::{BenchOptions, BenchOutcome, BenchProgress, LEAST_SIZE, bench};
pub use prepare::{Driver, Operator, Prepared, lattice_walls, prepare, start};
pub use run::{Outcome, RunError, RunOptions, run};
pub use stability::{StabilityOptions, StabilityOutcome, StabilityProgress, Tampering, stability};
pub use sweep::{StudyError, StudyOptions, StudyProgress, Vary, study, study_machine};
