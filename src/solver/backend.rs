//! What a time integrator needs of a machine.

use super::SolverError;

/// The state of a scene on some machine, with the operations that time integrators are made of.
///
/// Particle order is the problem's everywhere outside a backend; inside, each keeps its own.
/// `Field` is a type of the backend's own, so that a cross-check cannot be fed one side twice.
pub trait Backend {
    /// A field as read back: one f64 a particle, in the problem's order.
    type Field: AsRef<[f64]>;

    /// Takes `count` explicit Euler steps of `dt` (s) from `time` (s), which is where the state is.
    fn euler(&mut self, time: f64, dt: f64, count: u64) -> Result<(), SolverError>;

    /// Blocks until everything asked for so far is done: steps may only have been handed over.
    fn wait(&mut self) -> Result<(), SolverError>;

    /// Reads the values back.
    fn read(&mut self) -> Result<Self::Field, SolverError>;

    /// dC/dt of the present state at `time` (s), 1/s x the value's unit; 0 for held particles.
    fn rate(&mut self, time: f64) -> Result<Self::Field, SolverError>;

    /// What held particles and walls have given to the others since the start: value x volume.
    fn exchange(&mut self) -> Result<f64, SolverError>;

    /// Whether every value is finite.
    fn is_finite(&mut self) -> Result<bool, SolverError>;

    /// Whether the last step changed nothing at all, as far as the machine looks: in f64 it need not.
    fn is_still(&mut self) -> Result<bool, SolverError> {
        Ok(false)
    }

    /// Keeps a copy of the state on the machine, replacing the one before.
    fn save(&mut self) -> Result<(), SolverError>;

    /// Goes back to the state last saved.
    fn restore(&mut self) -> Result<(), SolverError>;

    /// Bytes that the state and the operator hold on the machine.
    fn memory_bytes(&self) -> u64;
}
