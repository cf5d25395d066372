//! Plan, backends and the time loop.

mod advance;
pub mod backend;
pub mod cpu;
mod error;
pub mod gpu;
pub mod plan;
mod step;

pub use advance::{Observer, Progress, Wish, advance};
pub use backend::Backend;
pub use error::SolverError;
pub use step::{Step, StepLimits, choose_step};
