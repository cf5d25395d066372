//! What a time integrator needs, on the device.

use super::phases::UpToDate;
use super::walls::WallSlots;
use super::{GpuBackend, GpuField, GpuVector, Saved};
use crate::gpu::{Buffer, GpuError};
use crate::solver::{Backend, Precision, SolverError};

impl Backend for GpuBackend {
    type Field = GpuField;
    type Vector = GpuVector;

    fn euler(&mut self, time: f64, dt: f64, count: u64) -> Result<(), SolverError> {
        Ok(self.steps.run(&self.device, time, dt, self.reference_step, count)?)
    }

    fn precision(&self) -> Precision {
        self.operator.precision()
    }

    fn wait(&mut self) -> Result<(), SolverError> {
        Ok(self.device.wait_for_all()?)
    }

    fn read(&mut self) -> Result<GpuField, SolverError> {
        Ok(self.by_particle(self.steps.values(&self.device)?))
    }

    fn rate(&mut self, time: f64) -> Result<GpuField, SolverError> {
        self.steps.settle(&self.device)?;
        let rate = self.steps.rate(&self.device, &self.operator, time)?;
        let mut rate = self.steps.read(&self.device, rate)?;
        rate.iter_mut().for_each(|rate| *rate /= self.reference_step);
        Ok(self.by_particle(rate))
    }

    fn exchange(&mut self) -> Result<f64, SolverError> {
        let walls = self.steps.walls().map(|walls| walls.inflow(&self.device));
        let through_walls = walls.transpose()?.unwrap_or(0.0);
        let Some(buffer) = self.steps.exchange() else {
            return Ok(through_walls);
        };
        let real = self.operator.precision().real();
        let given = real.from_bytes(&self.device.read(buffer)?);
        let amount = |&(place, volume): &(usize, f64)| volume * (given[place] + given[place + 1]);
        Ok(through_walls + self.held.iter().map(amount).sum::<f64>())
    }

    fn is_finite(&mut self) -> Result<bool, SolverError> {
        Ok(self.steps.is_finite(&self.device)?)
    }

    fn is_still(&mut self) -> Result<bool, SolverError> {
        let may_stagnate = self.operator.precision() != Precision::F64;
        Ok(may_stagnate && self.steps.is_still(&self.device)?)
    }

    fn save(&mut self) -> Result<(), SolverError> {
        if self.saved.is_none() {
            let twin = |buffer: &Buffer| self.device.storage("saved state", buffer.bytes());
            self.saved = Some(Saved {
                state: self.steps.state().iter().map(twin).collect::<Result<_, _>>()?,
                enthalpy: match self.steps.enthalpy() {
                    Some(_) => self.steps.content().iter().map(twin).collect::<Result<_, _>>()?,
                    None => Vec::new(),
                },
                exchange: self.steps.exchange().map(twin).transpose()?,
                walls: self.steps.walls().map(|walls| twin(&walls.wall)).transpose()?,
                up_to_date: UpToDate::Both,
                tick: 0,
            });
        }
        if let Some(saved) = &mut self.saved {
            saved.up_to_date = self.steps.up_to_date();
            saved.tick = self.steps.walls().map_or(0, WallSlots::tick);
        }
        Ok(self.copy_saved(|here, saved| (here, saved))?)
    }

    fn restore(&mut self) -> Result<(), SolverError> {
        if let Some(saved) = &self.saved {
            self.steps.replaced(saved.up_to_date);
            if let Some(walls) = self.steps.walls_mut() {
                walls.set_tick(saved.tick);
            }
        }
        Ok(self.copy_saved(|here, saved| (saved, here))?)
    }

    fn memory_bytes(&self) -> u64 {
        let saved = self.saved.as_ref().map_or(0, |saved| {
            let states = saved.state.iter().chain(&saved.enthalpy);
            let buffers = states.chain(&saved.exchange).chain(&saved.walls);
            buffers.map(Buffer::bytes).sum::<u64>()
        });
        self.operator.bytes() + self.steps.bytes() + saved + self.vector_bytes()
    }

    fn vector(&mut self) -> Result<GpuVector, SolverError> {
        Ok(self.vectors()?.vector()?)
    }

    fn load(&mut self, values: &[f64], out: &mut GpuVector) -> Result<(), SolverError> {
        Ok(self.vectors()?.load(values, out)?)
    }

    fn is_linear(&self) -> bool {
        self.steps.enthalpy().is_none()
    }

    fn rate_change(&mut self, x: &GpuVector, out: &mut GpuVector) -> Result<(), SolverError> {
        Ok(self.vectors()?.rate_change(x, out)?)
    }

    fn slope_root(&mut self, x: &GpuVector, out: &mut GpuVector) -> Result<(), SolverError> {
        Ok(self.vectors()?.slope_root(x, out)?)
    }

    fn multiply(&mut self, out: &mut GpuVector, by: &GpuVector) -> Result<(), SolverError> {
        Ok(self.vectors()?.multiply(out, by)?)
    }

    fn rate_into(&mut self, time: f64, out: &mut GpuVector) -> Result<(), SolverError> {
        Ok(self.vectors()?.rate(time, out)?)
    }

    fn is_source_changing(&self) -> bool {
        self.steps.walls().is_some_and(WallSlots::is_changing)
    }

    fn source_change(
        &mut self,
        from: f64,
        to: f64,
        out: &mut GpuVector,
    ) -> Result<(), SolverError> {
        Ok(self.vectors()?.source_change(from, to, out)?)
    }

    fn apply(
        &mut self,
        x: &GpuVector,
        share: f64,
        scale: f64,
        out: &mut GpuVector,
    ) -> Result<(), SolverError> {
        Ok(self.vectors()?.apply(x, share, scale, out)?)
    }

    fn update(
        &mut self,
        out: &mut GpuVector,
        keep: f64,
        terms: &[(f64, &GpuVector)],
    ) -> Result<(), SolverError> {
        Ok(self.vectors()?.update(out, keep, terms)?)
    }

    fn update_given(
        &mut self,
        out: &mut GpuVector,
        keep: f64,
        terms: &[(f64, &GpuVector)],
    ) -> Result<(), SolverError> {
        Ok(self.vectors()?.update_given(out, keep, terms)?)
    }

    fn divide(
        &mut self,
        x: &GpuVector,
        shift: f64,
        scale: f64,
        out: &mut GpuVector,
    ) -> Result<(), SolverError> {
        Ok(self.vectors()?.divide(x, shift, scale, out)?)
    }

    fn dot(&mut self, x: &GpuVector, y: &GpuVector) -> Result<f64, SolverError> {
        Ok(self.vectors()?.dot(x, y)?)
    }

    fn aggregate(&mut self, of: &[u32], count: usize) -> Result<(), SolverError> {
        Ok(self.vectors()?.aggregate(of, count)?)
    }

    fn restrict(&mut self, x: &GpuVector, out: &mut [f64]) -> Result<(), SolverError> {
        Ok(self.vectors()?.restrict(x, out)?)
    }

    fn prolong(&mut self, values: &[f64], out: &mut GpuVector) -> Result<(), SolverError> {
        Ok(self.vectors()?.prolong(values, out)?)
    }

    fn largest(&mut self, x: &GpuVector) -> Result<f64, SolverError> {
        Ok(self.vectors()?.largest(x)?)
    }

    fn largest_value(&mut self) -> Result<f64, SolverError> {
        Ok(self.vectors()?.largest_value()?)
    }

    fn add(&mut self, x: &GpuVector) -> Result<(), SolverError> {
        Ok(self.vectors()?.add(x)?)
    }
}

impl GpuBackend {
    /// Copies between the state and what is saved, from the first of `direction` to its second;
    /// nothing where nothing is saved.
    fn copy_saved(
        &self,
        direction: for<'a> fn(&'a Buffer, &'a Buffer) -> (&'a Buffer, &'a Buffer),
    ) -> Result<(), GpuError> {
        let Some(saved) = &self.saved else {
            return Ok(());
        };
        let exchange = self.steps.exchange().zip(saved.exchange.as_ref());
        let state = self.steps.state().iter().zip(&saved.state);
        // Nothing is saved of an enthalpy where there is none.
        let state = state.chain(self.steps.content().iter().zip(&saved.enthalpy));
        let mut pairs: Vec<_> = state.map(|(here, there)| direction(here, there)).collect();
        pairs.extend(exchange.map(|(here, there)| direction(here, there)));
        let walls = self.steps.walls().zip(saved.walls.as_ref());
        pairs.extend(walls.map(|(here, there)| direction(&here.wall, there)));
        self.device.copy(&pairs)
    }
}
