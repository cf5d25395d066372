//! What a time integrator needs of a machine.

use super::{Precision, SolverError};

/// The state of a scene on some machine, with the operations that time integrators and solvers are
/// made of.
///
/// The rate of the state C is dC/dt = A C + s(t), 0 for held particles, where A is the operator and s
/// what walls and held particles impose. Where the state is an enthalpy, it is A psi(C) + s(t) with the
/// potential psi (see [`crate::model::HeatCurve`]). Particle order is the problem's everywhere outside a backend;
/// inside, each keeps its own. `Field` is a type of the backend's own, so that a cross-check cannot be
/// fed one side twice.
pub trait Backend {
    /// A field as read back: one f64 a particle, in the problem's order.
    type Field: AsRef<[f64]>;

    /// A change of the state or a rate: one value a particle, 0 for held ones, and beside these what the
    /// outside gave, value x capacity (of a rate: a second). That follows every sum of vectors, so that
    /// an integrator accounts for it with the accuracy of its steps.
    type Vector;

    /// Takes `count` explicit Euler steps of `dt` (s) from `time` (s), which is where the state is.
    fn euler(&mut self, time: f64, dt: f64, count: u64) -> Result<(), SolverError>;

    /// The precision that it computes in.
    fn precision(&self) -> Precision;

    /// Blocks until everything asked for so far is done: steps may only have been handed over.
    fn wait(&mut self) -> Result<(), SolverError>;

    /// Reads the values back.
    fn read(&mut self) -> Result<Self::Field, SolverError>;

    /// dC/dt of the present state at `time` (s), 1/s x the value's unit; 0 for held particles.
    fn rate(&mut self, time: f64) -> Result<Self::Field, SolverError>;

    /// What held particles and walls have given to the others since the start: value x capacity.
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

    /// A vector of zeros.
    fn vector(&mut self) -> Result<Self::Vector, SolverError>;

    /// `out` = `values`, one a particle in the problem's order, but 0 for held ones.
    fn load(&mut self, values: &[f64], out: &mut Self::Vector) -> Result<(), SolverError>;

    /// Whether the operator acts on the state itself: psi(C) = C.
    fn is_linear(&self) -> bool;

    /// `out` = A (psi(C + x) - psi(C)).
    fn rate_change(&mut self, x: &Self::Vector, out: &mut Self::Vector) -> Result<(), SolverError>;

    /// `out` = the square root of psi'(C + x); what it is at held particles does not matter.
    fn slope_root(&mut self, x: &Self::Vector, out: &mut Self::Vector) -> Result<(), SolverError>;

    /// Multiplies each value of `out` by that of `by`; the outside gave nothing to that.
    fn multiply(&mut self, out: &mut Self::Vector, by: &Self::Vector) -> Result<(), SolverError>;

    /// `out` = A psi(C) + s at `time` (s).
    fn rate_into(&mut self, time: f64, out: &mut Self::Vector) -> Result<(), SolverError>;

    /// Whether s changes in time.
    fn is_source_changing(&self) -> bool;

    /// `out` = s(`to`) - s(`from`), the times in s.
    fn source_change(
        &mut self,
        from: f64,
        to: f64,
        out: &mut Self::Vector,
    ) -> Result<(), SolverError>;

    /// `out` = `share` x + `scale` A x: of potentials, not of states, where these differ.
    fn apply(
        &mut self,
        x: &Self::Vector,
        share: f64,
        scale: f64,
        out: &mut Self::Vector,
    ) -> Result<(), SolverError>;

    /// `out` = `keep` `out` + the sum of factor x vector.
    fn update(
        &mut self,
        out: &mut Self::Vector,
        keep: f64,
        terms: &[(f64, &Self::Vector)],
    ) -> Result<(), SolverError>;

    /// As [`Backend::update`] for what the outside gave, leaving the values as they are.
    fn update_given(
        &mut self,
        out: &mut Self::Vector,
        keep: f64,
        terms: &[(f64, &Self::Vector)],
    ) -> Result<(), SolverError>;

    /// `out` = x_a / (`shift` + `scale` A_aa); the outside gave nothing to that.
    fn divide(
        &mut self,
        x: &Self::Vector,
        shift: f64,
        scale: f64,
        out: &mut Self::Vector,
    ) -> Result<(), SolverError>;

    /// The sum of V x y over all particles: A is symmetric for this product where no wall spoils it.
    fn dot(&mut self, x: &Self::Vector, y: &Self::Vector) -> Result<f64, SolverError>;

    /// Takes note of the aggregate of each particle, in the problem's order, of `count`; held ones are in
    /// none, `u32::MAX`.
    fn aggregate(&mut self, of: &[u32], count: usize) -> Result<(), SolverError>;

    /// `out` = the sum of V x over the particles of each aggregate.
    fn restrict(&mut self, x: &Self::Vector, out: &mut [f64]) -> Result<(), SolverError>;

    /// Adds to `out` at each particle the value of its aggregate; the outside gave nothing to that.
    fn prolong(&mut self, values: &[f64], out: &mut Self::Vector) -> Result<(), SolverError>;

    /// The largest magnitude of a value of x; not finite if a value is not.
    fn largest(&mut self, x: &Self::Vector) -> Result<f64, SolverError>;

    /// The largest magnitude of a value of the state.
    fn largest_value(&mut self) -> Result<f64, SolverError>;

    /// Adds x to the state, and what the outside gave to the exchange.
    fn add(&mut self, x: &Self::Vector) -> Result<(), SolverError>;
}
