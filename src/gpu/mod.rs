//! A physics-free layer over wgpu: adapters, a device, buffers, shader linking, passes as data, the
//! exclusive prefix sum, and passes that measure what a device can do at most.
//!
//! Nothing here panics on what a machine may do: a missing adapter, a limit, a shader that the
//! driver refuses or a lost device come back as a [`GpuError`] with the values that explain it.

mod adapter;
mod buffer;
mod device;
mod error;
pub mod limits;
mod link;
mod pace;
mod pass;
mod real;
mod scan;

pub use adapter::{Adapter, AdapterReport, adapters, choose};
pub use buffer::Buffer;
pub use device::{Device, Submission};
pub use error::GpuError;
pub use link::{Binding, BlockLayout, Constant, Element, Holds, PassSource};
pub use pace::Pace;
pub use pass::Pass;
pub use real::Real;
pub use scan::{SCAN_BLOCK, Scan, scan_sources};
