//! Sums and quotients of vectors.

use std::ops::Range;

use super::passes::{ENTRIES, MOST_TERMS, UPDATE, divide, give, update};
use super::queue::Operation;
use super::{GpuVector, Operations};
use crate::gpu::{Buffer, Device, GpuError, Pass};
use crate::solver::Precision;
use crate::solver::gpu::operator::{Fields, Makes, Operator};
use crate::solver::gpu::steps::Steps;
use crate::solver::gpu::walls::WallSlots;

impl Operations<'_> {
    /// `keep` out + the sum of factor x vector.
    pub(in crate::solver::gpu) fn update(
        &mut self,
        out: &mut GpuVector,
        keep: f64,
        terms: &[(f64, &GpuVector)],
    ) -> Result<(), GpuError> {
        self.update_in(Operation::Update, out, keep, terms)
    }

    /// The same for what the outside gave, alone.
    pub(in crate::solver::gpu) fn update_given(
        &mut self,
        out: &mut GpuVector,
        keep: f64,
        terms: &[(f64, &GpuVector)],
    ) -> Result<(), GpuError> {
        self.update_in(Operation::UpdateGiven, out, keep, terms)
    }

    fn update_in(
        &mut self,
        operation: Operation,
        out: &mut GpuVector,
        keep: f64,
        terms: &[(f64, &GpuVector)],
    ) -> Result<(), GpuError> {
        let (now, later) = terms.split_at(terms.len().min(MOST_TERMS));
        self.write_update(keep, now.iter().map(|(factor, _)| *factor))?;
        let (tools, steps, precision) = (&mut *self.tools, &*self.steps, self.operator.precision());
        let numbers = now.iter().map(|(_, vector)| vector.number);
        let key = (operation, std::iter::once(out.number).chain(numbers).collect());
        tools.queue.run(self.device, key, || {
            let source = update(precision, now.len());
            let pass = |(k, to): (usize, &Buffer)| {
                let mut buffers = vec![steps.step_size(), &tools.update, to];
                buffers.extend(now.iter().filter_map(|(_, vector)| vector.buffers().nth(k)));
                self.device.pass(&source, &buffers, precision.values_in(to))
            };
            let values = if operation == Operation::UpdateGiven { out.parts.len() } else { 0 };
            out.buffers().enumerate().skip(values).map(pass).collect()
        })?;
        match later {
            [] => Ok(()),
            later => self.update_in(operation, out, 1.0, later),
        }
    }

    /// x_a / (`shift` + `scale` A_aa); the outside gave nothing to that.
    pub(in crate::solver::gpu) fn divide(
        &mut self,
        x: &GpuVector,
        shift: f64,
        scale: f64,
        out: &mut GpuVector,
    ) -> Result<(), GpuError> {
        self.find_diagonal()?;
        self.update_given(out, 0.0, &[])?;
        self.write_factors(shift, scale / self.reference_step)?;
        let (tools, steps, precision) = (&mut *self.tools, &*self.steps, self.operator.precision());
        let key = (Operation::Divide, vec![out.number, x.number]);
        tools.queue.run(self.device, key, || {
            let source = divide(precision);
            let pass = |((x, diagonal), out): ((&Buffer, &Buffer), &Buffer)| {
                let buffers = [steps.step_size(), &tools.combination, x, diagonal, out];
                self.device.pass(&source, &buffers, precision.values_in(out))
            };
            x.parts.iter().zip(&tools.diagonal).zip(&out.parts).map(pass).collect()
        })
    }

    /// Has the device find the diagonal, once.
    fn find_diagonal(&mut self) -> Result<(), GpuError> {
        if !self.tools.diagonal.is_empty() {
            return Ok(());
        }
        let twin = |buffer: &Buffer| self.device.storage("diagonal", buffer.bytes());
        let diagonal: Vec<Buffer> =
            self.steps.state().iter().map(twin).collect::<Result<_, _>>()?;
        let fields = Fields {
            from: self.steps.state(),
            to: &diagonal,
            exchange: self.steps.exchange(),
            walls: self.steps.walls().map(WallSlots::buffers),
            step_size: self.steps.step_size(),
            combination: None,
            heat: None,
        };
        self.device.submit(&self.operator.passes(self.device, Makes::Diagonal, &fields)?)?;
        if let (Operator::Lattice(lattice), Some(slots)) = (self.operator, self.steps.walls()) {
            self.add_sources(&lattice.parts(), slots, &diagonal)?;
        }
        self.tools.diagonal = diagonal;
        Ok(())
    }

    /// Adds to the diagonal of a stencil what sources in proportion to the value add. It is done once, and
    /// few scenes have any.
    fn add_sources(
        &self,
        parts: &[Range<usize>],
        slots: &WallSlots,
        diagonal: &[Buffer],
    ) -> Result<(), GpuError> {
        let precision = self.operator.precision();
        for (sites, buffer) in parts.iter().zip(diagonal) {
            let mut here = slots.diagonals().filter(|(site, _)| sites.contains(site)).peekable();
            if here.peek().is_none() {
                continue;
            }
            let mut values = precision.state_from_bytes(&self.device.read(buffer)?);
            here.for_each(|(site, by_sources)| values[site - sites.start] += by_sources);
            self.device.write(buffer, &precision.state_to_bytes(&values))?;
        }
        Ok(())
    }

    /// Adds a vector to the state, and what the outside gave to the exchange. The sum is the next
    /// state, as after a step, so that the one before is still there to compare with.
    pub(in crate::solver::gpu) fn add(&mut self, x: &GpuVector) -> Result<(), GpuError> {
        self.write_update(0.0, [1.0, 1.0].into_iter())?;
        let (tools, steps, precision) = (&mut *self.tools, &*self.steps, self.operator.precision());
        let key = (Operation::Add(steps.current()), vec![x.number]);
        tools.queue.run(self.device, key, || {
            let mut passes: Vec<Pass> = match steps.enthalpy() {
                None => {
                    let source = update(precision, 2);
                    let state = steps.state().iter().zip(steps.next());
                    let pass = |((now, next), x): ((&Buffer, &Buffer), &Buffer)| {
                        let buffers = [steps.step_size(), &tools.update, next, now, x];
                        self.device.pass(&source, &buffers, precision.values_in(now))
                    };
                    state.zip(&x.parts).map(pass).collect::<Result<_, _>>()?
                }
                Some(enthalpy) => {
                    let (step_size, from) = (steps.step_size(), steps.current());
                    enthalpy.add(self.device, step_size, from, &x.parts, steps.next())?
                }
            };
            let give = |total: Option<&Buffer>, first, places: Vec<u32>| {
                total.map(|total| give_to(self.device, precision, steps, x, total, first, &places))
            };
            // A total begins with the first of two words.
            let held = self.held.iter().map(|(at, _)| (at / 2) as u32);
            let held = give(steps.exchange(), 0, held.collect());
            let slots = (0..self.scene.entries().1 as u32).map(|slot| 4 * slot + 2);
            let walls = steps.walls().map(|walls| &walls.wall);
            let walls = give(walls, self.held.len() as u32, slots.collect());
            for given in held.into_iter().chain(walls) {
                passes.push(given?);
            }
            Ok(passes)
        })?;
        self.steps.turn();
        Ok(())
    }

    /// Writes the factors of the next sum.
    fn write_update(&self, keep: f64, factors: impl Iterator<Item = f64>) -> Result<(), GpuError> {
        let mut reals = [0.0; 1 + MOST_TERMS];
        let all = std::iter::once(keep).chain(factors);
        reals.iter_mut().zip(all).for_each(|(real, factor)| *real = factor);
        let keeps = u32::from(keep != 0.0);
        let contents = UPDATE.contents(self.operator.precision().real(), [keeps], reals);
        self.device.write(&self.tools.update, &contents)
    }
}

/// Adds the entries of `x` from `first` on to what is at `places` of `total`.
fn give_to(
    device: &Device,
    precision: Precision,
    steps: &Steps,
    x: &GpuVector,
    total: &Buffer,
    first: u32,
    places: &[u32],
) -> Result<Pass, GpuError> {
    let entries = ENTRIES.contents(precision.real(), [first, places.len() as u32], []);
    let entries = device.block("entries", &entries)?;
    let place = device.storage_with("places of totals", bytemuck::cast_slice(places))?;
    let buffers = [steps.step_size(), &entries, &x.given, &place, total];
    device.pass(&give(precision), &buffers, places.len() as u64)
}
