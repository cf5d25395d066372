//! Passes on vectors, made once for each set of buffers.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, VecDeque};

use crate::gpu::{Device, GpuError, Pass, Submission};

/// Submissions that the device may be behind by: enough that it does not wait, and few enough that a
/// run can be interrupted.
const IN_FLIGHT: usize = 64;

/// What is done to some vectors; with a number it is the place of the state that takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Operation {
    Rate(usize),
    Apply,
    Update,
    UpdateGiven,
    Divide,
    Multiply,
    PotentialChange(usize),
    SlopeRoot(usize),
    SeamChange(usize),
    Dot,
    Largest,
    LargestValue(usize),
    Scatter,
    Add(usize),
    Restrict,
    Prolong,
}

/// An operation and the numbers of its vectors.
pub(super) type Key = (Operation, Vec<u64>);

/// The passes made so far, and what the device has still to do.
#[derive(Debug, Default)]
pub(super) struct Queue {
    passes: HashMap<Key, Vec<Pass>>,
    in_flight: VecDeque<Submission>,
}

impl Queue {
    /// Gives the passes of `key` to the device; `make` makes them if they do not exist.
    pub(super) fn run(
        &mut self,
        device: &Device,
        key: Key,
        make: impl FnOnce() -> Result<Vec<Pass>, GpuError>,
    ) -> Result<(), GpuError> {
        let passes = match self.passes.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => place.insert(make()?),
        };
        self.in_flight.push_back(device.submit(&*passes)?);
        if self.in_flight.len() > IN_FLIGHT
            && let Some(oldest) = self.in_flight.pop_front()
        {
            device.wait(&oldest)?;
        }
        Ok(())
    }

    /// Drops passes with a vector for which `lives` does not hold.
    pub(super) fn retain(&mut self, lives: impl Fn(u64) -> bool) {
        self.passes.retain(|(_, vectors), _| vectors.iter().all(|&vector| lives(vector)));
    }
}
