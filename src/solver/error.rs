//! What can go wrong while solving.

use glam::DVec3;

/// A run that could not start or go on.
#[derive(Debug, thiserror::Error)]
pub enum SolverError {
    /// The step is above the measured stability limit.
    #[error(
        "step {step:.6e} s is above the stability limit {limit:.6e} s ({:.3} times); \
         lower `time.step`, leave it out for an automatic step, or pass --allow-unstable",
        step / limit
    )]
    UnstableStep {
        /// The step asked for, s.
        step: f64,
        /// The measured limit 2 / lambda_max, s.
        limit: f64,
    },
    /// Two particles sit where the kernel has no finite weight.
    #[error(
        "particles {a} and {b} coincide at {at}, where the kernel `{kernel}` has no finite weight"
    )]
    CoincidentParticles {
        /// Index of the one.
        a: usize,
        /// Index of the other.
        b: usize,
        /// Their position, m.
        at: DVec3,
        /// The kernel's name.
        kernel: &'static str,
    },
    /// A value that is not finite came up.
    #[error(
        "the run diverged at step {step} (t = {time:.6e} s): particle {particle} at {position} \
         became {value}"
    )]
    Diverged {
        /// The first step whose result is not finite, from 1.
        step: u64,
        /// The time at the end of that step, s.
        time: f64,
        /// The first particle that is not finite.
        particle: usize,
        /// Its position, m.
        position: DVec3,
        /// Its value.
        value: f64,
    },
    /// A value that is not finite came up once, but not when the steps were taken again.
    #[error(
        "a value that is not finite came up after step {step}, but not when the steps were taken \
         again: the device does not repeat its results"
    )]
    NotRepeatable {
        /// The last step known to be good.
        step: u64,
    },
    /// The user stopped the run.
    #[error("interrupted at step {step} (t = {time:.6e} s)")]
    Interrupted {
        /// Steps taken.
        step: u64,
        /// Time reached, s.
        time: f64,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] crate::gpu::GpuError),
}
