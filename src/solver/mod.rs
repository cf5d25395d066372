//! Plan, backends and the time loop.

pub mod backend;
pub mod cpu;
mod error;
pub mod gpu;
mod precision;

pub use backend::Backend;
pub use error::SolverError;
pub use precision::Precision;
