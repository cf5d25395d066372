//! Plan, backends and the time loop; what a machine can do at most.

mod adaptive;
mod advance;
pub mod backend;
pub mod cpu;
mod error;
pub mod gpu;
pub mod integrator;
pub mod limits;
mod machine;
mod method;
pub mod plan;
mod precision;
mod stagnation;
mod step;
mod timing;

pub use advance::{Observer, Progress, Still, Taken, advance};
pub use backend::Backend;
pub use error::SolverError;
pub use integrator::Stepper;
pub use limits::Limits;
pub use machine::{BackendWish, Machine, MachineKind, MachineWish, Opened};
pub use plan::{Path, PathChoice, PathWish, Plan};
pub use precision::Precision;
pub use stagnation::{Foreseen, Stagnation, slowest_rates};
pub use step::{Step, StepLimits, choose_step, measure_limit};
pub use timing::Timing;
