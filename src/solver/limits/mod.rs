//! What a machine can do at most, measured: how fast it copies, how fast it reads, and how fast it multiplies
//! and adds. Every run is bounded by one of these.

mod cpu;

use std::time::Duration;

use super::{Machine, Precision, SolverError, Timing};
use crate::gpu::limits::{Arithmetic, Copy};
use crate::gpu::{Device, Real};

pub use cpu::instructions;

/// Seconds that one run of the arithmetic pass should take at least: far more than it takes to
/// start.
const DISPATCH: f64 = 5e-3;

/// Rounds of the arithmetic pass at most.
const MOST_ROUNDS: u32 = 1 << 22;

/// What a machine can do at most in one precision. The best of several rounds each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Bytes read and written a second in copying arrays far larger than caches.
    pub copy: f64,
    /// The same on one thread, where there are threads.
    pub copy_one_thread: Option<f64>,
    /// Bytes a second in reading an array far larger than caches, where that was measured: a processor may
    /// write past its caches at the side of reading, so that it moves more in a copy than it can read.
    pub read: Option<f64>,
    /// Operations a second in chains of fused multiplications and additions, which count as two.
    pub arithmetic: f64,
}

impl Limits {
    /// Measures `machine`, about `least` for each limit; each of two arrays may take `most` bytes.
    ///
    /// # Errors
    /// A device that fails.
    pub fn measure(machine: &Machine, least: Duration, most: u64) -> Result<Self, SolverError> {
        match machine {
            Machine::Cpu => Ok(cpu::measure(least, most)),
            Machine::Gpu { device, precision } => of_device(device, *precision, least, most),
        }
    }
}

fn of_device(
    device: &Device,
    precision: Precision,
    least: Duration,
    most: u64,
) -> Result<Limits, SolverError> {
    let real = precision.real();
    let mut copy = copy(device, real, most)?.pass;
    let copying = Timing::of(least, |count| copy.run(count))?;
    let mut arithmetic = arithmetic(device, real)?.pass;
    let computing = Timing::of(least, |count| arithmetic.run(count))?;
    Ok(Limits {
        copy: copy.amount() as f64 / copying.best(),
        copy_one_thread: None,
        read: None,
        arithmetic: arithmetic.amount() as f64 / computing.best(),
    })
}

/// The copy of as large arrays as the device has room for.
fn copy(device: &Device, real: Real, most: u64) -> Result<Copy, SolverError> {
    let mut most = most;
    loop {
        match Copy::new(device, real, most) {
            Err(error) if error.is_lack_of_room() && most > 1 << 20 => most /= 2,
            made => return Ok(made?),
        }
    }
}

/// Chains long enough to be timed: how long is only known of a device once it has been tried.
fn arithmetic(device: &Device, real: Real) -> Result<Arithmetic, SolverError> {
    let mut rounds = 4;
    loop {
        // The values neither grow nor come to rest soon.
        let mut made = Arithmetic::new(device, real, rounds, [1.0, -0.999, 1.0])?;
        let timing = Timing::of(Duration::ZERO, |count| made.pass.run(count))?;
        if timing.best() >= DISPATCH || rounds >= MOST_ROUNDS {
            return Ok(made);
        }
        rounds *= 4;
    }
}
