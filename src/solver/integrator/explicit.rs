//! Explicit methods of second order.

use super::Integrator;
use crate::model::integrator::Recurrence;
use crate::solver::{Backend, SolverError};

/// Steps of a [`Recurrence`].
pub struct Explicit<B: Backend> {
    recurrence: Recurrence,
    /// No eigenvalue of -A is above this, 1/s.
    largest: f64,
    /// The rate of the present state, and whether it is known.
    rate: B::Vector,
    knows_rate: bool,
    /// The changes after a stage and the one before it.
    changes: [B::Vector; 2],
    /// What of a rate a stage adds.
    added: B::Vector,
    /// What changing sources add; only where there are any.
    imposed: Option<B::Vector>,
    /// The last proposal: from when, s, and how long, s.
    proposed: [f64; 2],
    applications: u64,
}

impl<B: Backend> Explicit<B> {
    /// For a scene where no eigenvalue of -A is above `largest` (1/s).
    pub fn new(backend: &mut B, recurrence: Recurrence, largest: f64) -> Result<Self, SolverError> {
        let imposed = backend.is_source_changing().then(|| backend.vector()).transpose()?;
        Ok(Self {
            recurrence,
            largest,
            rate: backend.vector()?,
            knows_rate: false,
            changes: [backend.vector()?, backend.vector()?],
            added: backend.vector()?,
            imposed,
            proposed: [0.0; 2],
            applications: 0,
        })
    }

    /// `added` = `share` D + `scale` (A D + s(`to`) - s(`from`)) for the change D after the last stage, with
    /// the change of the potential for D behind A where the state is an enthalpy.
    fn add(
        &mut self,
        backend: &mut B,
        [share, scale]: [f64; 2],
        [from, to]: [f64; 2],
    ) -> Result<(), SolverError> {
        if backend.is_linear() {
            backend.apply(&self.changes[0], share, scale, &mut self.added)?;
        } else {
            backend.rate_change(&self.changes[0], &mut self.added)?;
            backend.update(&mut self.added, scale, &[(share, &self.changes[0])])?;
        }
        self.applications += 1;
        if let Some(imposed) = &mut self.imposed {
            backend.source_change(from, to, imposed)?;
            backend.update(&mut self.added, 1.0, &[(scale, imposed)])?;
        }
        Ok(())
    }
}

impl<B: Backend> Integrator<B> for Explicit<B> {
    fn propose(&mut self, backend: &mut B, time: f64, dt: f64) -> Result<(), SolverError> {
        if !self.knows_rate {
            backend.rate_into(time, &mut self.rate)?;
            self.applications += 1;
            self.knows_rate = true;
        }
        let mut before = time;
        for (number, stage) in self.recurrence.stages(dt, self.largest).into_iter().enumerate() {
            if number == 0 {
                let [first, zero] = &mut self.changes;
                backend.update(first, 0.0, &[(stage.first * dt, &self.rate)])?;
                backend.update(zero, 0.0, &[])?;
            } else {
                self.add(backend, [stage.mu, stage.last * dt], [time, before])?;
                let terms = [(1.0, &self.added), (stage.first * dt, &self.rate)];
                backend.update(&mut self.changes[1], stage.nu, &terms)?;
                self.changes.swap(0, 1);
            }
            before = time + stage.time * dt;
        }
        self.proposed = [time, dt];
        Ok(())
    }

    /// What the cubic through the states and rates at both ends tells (Sommeijer, Shampine and Verwer
    /// 1997, J. Comput. Appl. Math. 88, 315, equation 2.9). The rate at the end is not kept for the next step: what
    /// rounding leaves of a large rate would stay in all that follow.
    fn error(&mut self, backend: &mut B, _negligible: f64) -> Result<f64, SolverError> {
        let [time, dt] = self.proposed;
        self.add(backend, [0.0, 1.0], [time, time + dt])?;
        backend.update(&mut self.added, 1.0, &[(1.0, &self.rate)])?;
        let [change, error] = &mut self.changes;
        let both = [(0.4 * dt, &self.rate), (0.4 * dt, &self.added), (-0.8, &*change)];
        backend.update(error, 0.0, &both)?;
        backend.largest(error)
    }

    fn accept(&mut self, backend: &mut B) -> Result<(), SolverError> {
        backend.add(&self.changes[0])?;
        self.knows_rate = false;
        Ok(())
    }

    fn applications(&self) -> u64 {
        self.applications
    }
}
