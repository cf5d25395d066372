//! A physics-free layer over wgpu.

/// A failure of the device.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// Placeholder.
    #[error("no adapter")]
    NoAdapter,
}
