//! The state on the device, and the passes that change it.

use std::borrow::Cow;

use super::enthalpy::{Curves, Enthalpy, HeatFields};
use super::fronts::{DeviceFronts, FrontMakes};
use super::operator::{Fields, Makes, Operator};
use super::passes::{STEP_SIZE, finite, still};
use super::phases::{Told, UpToDate};
use super::seams::{DeviceSeams, SeamFields};
use super::walls::WallSlots;
use crate::gpu::{Buffer, Device, GpuError, Pace, Pass};
use crate::solver::Precision;

/// Dispatches in a submission at most.
const MOST_DISPATCHES: u64 = 1000;

/// What of a scene makes states enthalpies.
#[derive(Debug)]
pub(super) struct Heat<'a> {
    /// The curves that these follow.
    pub(super) curves: Option<&'a Curves>,
    /// Where such curves meet.
    pub(super) seams: Option<DeviceSeams>,
    /// Where something melts at one temperature.
    pub(super) fronts: Option<DeviceFronts>,
}

/// What lists have of what melts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ListedFronts {
    /// Nothing yet.
    Nothing,
    /// What melts.
    Present,
    /// What melted before others than steps have changed the state.
    Past,
}

/// The state with everything that changes it.
#[derive(Debug)]
pub(super) struct Steps {
    precision: Precision,
    /// A step reads one and writes the other; each is in parts that the device can bind.
    state: [Vec<Buffer>; 2],
    /// Which of the two holds the present state.
    current: usize,
    /// The state, in the same two places, only where `state` has its potentials.
    enthalpy: Option<Enthalpy>,
    /// What of it is up to date, where there are phases.
    up_to_date: UpToDate,
    /// Where materials meet of which one has a curve.
    seams: Option<DeviceSeams>,
    /// Where something melts at one temperature.
    fronts: Option<DeviceFronts>,
    /// Lists what melts, by which state that is.
    find_fronts: [Option<Pass>; 2],
    /// What is listed of it.
    listed: ListedFronts,
    /// What held particles have given; only where there is one.
    exchange: Option<Buffer>,
    /// The rows to which walls add more than weights; only where there is one.
    walls: Option<WallSlots>,
    step_size: Buffer,
    over_reference: Option<f64>,
    flag: Buffer,
    /// The passes of a step, by which state it reads.
    step: [Vec<Pass>; 2],
    finite: [Vec<Pass>; 2],
    still: Vec<Pass>,
    pace: Pace,
}

impl Steps {
    /// The passes of `operator`, from a state `initial` in its order, which is an enthalpy where `heat` has curves.
    pub(super) fn new(
        device: &Device,
        operator: &Operator,
        initial: &[f64],
        heat: Heat<'_>,
        exchange: Option<Buffer>,
        walls: Option<WallSlots>,
    ) -> Result<Self, GpuError> {
        let Heat { curves, seams, fronts } = heat;
        let precision = operator.precision();
        let real = precision.real();
        let parts = operator.parts(initial.len());
        let of_curves = |curves| {
            let contents = parts.iter().map(|part| &initial[part.clone()]);
            Enthalpy::new(device, precision, operator.workgroup_size(), curves, contents)
        };
        let enthalpy = curves.map(of_curves).transpose()?;
        let potentials = enthalpy.as_ref().zip(curves);
        let potentials = potentials.map(|(of, curves)| of.potentials(curves, initial));
        let initial = potentials.map_or(Cow::Borrowed(initial), Cow::<[f64]>::Owned);
        let filled = parts.iter().map(|part| {
            device.storage_with("state", &precision.state_to_bytes(&initial[part.clone()]))
        });
        let empty = parts
            .iter()
            .map(|part| device.storage("state", part.len() as u64 * precision.state_bytes()));
        let state: [Vec<Buffer>; 2] =
            [filled.collect::<Result<_, _>>()?, empty.collect::<Result<_, _>>()?];
        let step_size = device.block("step size", &STEP_SIZE.contents(real, [0], [0.0]))?;
        let flag = device.storage("flag", 4)?;
        let step_from = |from: usize| {
            let fronts = fronts.as_ref();
            let heat = enthalpy.as_ref().map(|enthalpy| HeatFields { enthalpy, from, fronts });
            let fields = Fields {
                from: &state[from],
                to: &state[1 - from],
                exchange: exchange.as_ref(),
                walls: walls.as_ref().map(WallSlots::buffers),
                step_size: &step_size,
                combination: None,
                heat,
            };
            let mut passes = operator.front_passes(device, FrontMakes::Near, &fields)?;
            passes.extend(operator.passes(device, Makes::Step, &fields)?);
            let mut corrections = operator.front_passes(device, FrontMakes::Flows, &fields)?;
            if let (Some(heat), Some(seams)) = (heat, &seams) {
                let states = [from, 1 - from].map(|at| &state[at][0]);
                let pass = seams.step(device, &step_size, heat, states, exchange.as_ref())?;
                // Where potentials tell enthalpies it is looked last at what melts.
                let at = if heat.enthalpy.told().is_some() { 0 } else { corrections.len() };
                corrections.insert(at, pass);
            }
            passes.extend(corrections);
            Ok::<_, GpuError>(passes)
        };
        let finite = finite(precision, operator.workgroup_size());
        let finite_of = |from: usize| -> Result<Vec<Pass>, GpuError> {
            let of_part = |part: &Buffer| {
                device.pass(&finite, &[&step_size, part, &flag], precision.values_in(part))
            };
            // What a potential is not known of need not be infinite; what it tells is in no other place.
            let untold = enthalpy.as_ref().filter(|enthalpy| enthalpy.told().is_none());
            let content = untold.map_or(&state[from][..], |enthalpy| enthalpy.parts(from));
            content.iter().map(of_part).collect()
        };
        let still = still(precision, operator.workgroup_size());
        let parts = state[0].iter().zip(&state[1]);
        let of_part = |(one, other): (&Buffer, &Buffer)| {
            let buffers = [&step_size, one, other, &flag];
            device.pass(&still, &buffers, precision.values_in(one))
        };
        let still = parts.map(of_part).collect::<Result<_, _>>()?;
        let step = [step_from(0)?, step_from(1)?];
        let find_fronts = |from: usize| match (&enthalpy, &fronts) {
            (Some(enthalpy), Some(fronts)) => {
                enthalpy.find_fronts(device, &step_size, from, fronts)
            }
            _ => Ok(None),
        };
        let find_fronts = [find_fronts(0)?, find_fronts(1)?];
        Ok(Self {
            precision,
            finite: [finite_of(0)?, finite_of(1)?],
            still,
            pace: Pace::new(MOST_DISPATCHES / step[0].len().max(1) as u64),
            step,
            state,
            current: 0,
            enthalpy,
            up_to_date: UpToDate::Both,
            seams,
            fronts,
            find_fronts,
            listed: ListedFronts::Nothing,
            exchange,
            walls,
            step_size,
            over_reference: None,
            flag,
        })
    }

    /// Takes `count` steps of `dt` (s) from `time` (s); the reference step is `reference` (s).
    pub(super) fn run(
        &mut self,
        device: &Device,
        time: f64,
        dt: f64,
        reference: f64,
        count: u64,
    ) -> Result<(), GpuError> {
        let over_reference = dt / reference;
        if self.over_reference != Some(over_reference) {
            let contents = STEP_SIZE.contents(self.precision.real(), [0], [over_reference]);
            device.write(&self.step_size, &contents)?;
            self.over_reference = Some(over_reference);
        }
        self.begin(device)?;
        let mut remaining = count;
        while remaining > 0 {
            let mut steps = self.pace.next(device, remaining)?;
            if let Some(walls) = &mut self.walls {
                steps = steps.min(walls.most_steps());
                walls.prepare(device, time + (count - remaining) as f64 * dt, dt, steps)?;
                walls.advance(steps);
            }
            let from = |k: u64| (self.current + k as usize) % 2;
            let passes = (0..steps).flat_map(|k| &self.step[from(k)]);
            let submission = device.submit(passes)?;
            self.pace.submitted(submission, steps);
            self.current = from(steps);
            remaining -= steps;
        }
        Ok(())
    }

    /// Makes ready for steps.
    fn begin(&mut self, device: &Device) -> Result<(), GpuError> {
        if let Some(told) = self.told() {
            if self.up_to_date == UpToDate::Enthalpies {
                let potentials = told.potentials(&self.read(device, self.content())?);
                self.write(device, self.state(), &potentials)?;
            }
            self.up_to_date = UpToDate::Potentials;
        }
        if self.listed != ListedFronts::Present {
            if let (Some(find), Some(fronts)) = (&self.find_fronts[self.current], &self.fronts) {
                if self.listed == ListedFronts::Past {
                    fronts.clear(device)?;
                }
                device.submit([find])?;
            }
            self.listed = ListedFronts::Present;
        }
        Ok(())
    }

    /// Brings the enthalpies in memory up to date, for what reads or changes them.
    pub(super) fn settle(&mut self, device: &Device) -> Result<(), GpuError> {
        if self.up_to_date == UpToDate::Potentials {
            self.write(device, self.content(), &self.values(device)?)?;
            self.up_to_date = UpToDate::Both;
        }
        Ok(())
    }

    /// The present state by place, whatever the operator acts on.
    pub(super) fn values(&self, device: &Device) -> Result<Vec<f64>, GpuError> {
        let mut values = self.read(device, self.content())?;
        if let (UpToDate::Potentials, Some(told)) = (self.up_to_date, self.told()) {
            told.tell(&self.read(device, self.state())?, &mut values);
        }
        Ok(values)
    }

    fn told(&self) -> Option<&Told> {
        self.enthalpy.as_ref().and_then(Enthalpy::told)
    }

    /// The values of parts of a state, by place.
    pub(super) fn read(&self, device: &Device, parts: &[Buffer]) -> Result<Vec<f64>, GpuError> {
        let mut values = Vec::new();
        for part in parts {
            values.extend(self.precision.state_from_bytes(&device.read(part)?));
        }
        Ok(values)
    }

    fn write(&self, device: &Device, parts: &[Buffer], values: &[f64]) -> Result<(), GpuError> {
        let mut rest = values;
        for part in parts {
            let (of_part, others) = rest.split_at(self.precision.values_in(part) as usize);
            device.write(part, &self.precision.state_to_bytes(of_part))?;
            rest = others;
        }
        Ok(())
    }

    /// What of the state is up to date.
    pub(super) fn up_to_date(&self) -> UpToDate {
        self.up_to_date
    }

    /// Takes what was written in place of the present state, of which that much is up to date.
    pub(super) fn replaced(&mut self, up_to_date: UpToDate) {
        self.up_to_date = up_to_date;
        if self.listed == ListedFronts::Present {
            self.listed = ListedFronts::Past;
        }
    }

    /// The parts of the present state, whatever the operator acts on; enthalpies in them may have to be settled.
    pub(super) fn content(&self) -> &[Buffer] {
        self.enthalpy.as_ref().map_or(self.state(), |enthalpy| enthalpy.parts(self.current))
    }

    /// The state, where it is not what the operator acts on.
    pub(super) fn enthalpy(&self) -> Option<&Enthalpy> {
        self.enthalpy.as_ref()
    }

    /// Where materials meet of which one has a curve, with what a pass over that needs to add to `after`.
    pub(super) fn seams<'a>(
        &'a self,
        after: &'a Buffer,
    ) -> Option<(&'a DeviceSeams, SeamFields<'a>)> {
        let (enthalpy, seams) = self.enthalpy.as_ref().zip(self.seams.as_ref())?;
        let (step_size, from) = (&self.step_size, self.current);
        Some((seams, SeamFields { step_size, enthalpy, from, after }))
    }

    /// The parts of what the operator acts on.
    pub(super) fn state(&self) -> &[Buffer] {
        &self.state[self.current]
    }

    /// The parts that the next step writes.
    pub(super) fn next(&self) -> &[Buffer] {
        &self.state[1 - self.current]
    }

    /// Which of two places the state is in.
    pub(super) fn current(&self) -> usize {
        self.current
    }

    /// Takes what was written for the next state as the present one.
    pub(super) fn turn(&mut self) {
        self.current = 1 - self.current;
        self.replaced(UpToDate::Enthalpies);
    }

    /// The block with a zero that compilers do not know.
    pub(super) fn step_size(&self) -> &Buffer {
        &self.step_size
    }

    /// What held particles have given.
    pub(super) fn exchange(&self) -> Option<&Buffer> {
        self.exchange.as_ref()
    }

    /// The rows to which walls add more than weights.
    pub(super) fn walls(&self) -> Option<&WallSlots> {
        self.walls.as_ref()
    }

    /// The same, to be changed.
    pub(super) fn walls_mut(&mut self) -> Option<&mut WallSlots> {
        self.walls.as_mut()
    }

    /// The rates of change a reference step at `time` (s); they lie where the next step will write.
    /// A run of explicit steps never asks, so their passes are made here.
    pub(super) fn rate(
        &self,
        device: &Device,
        operator: &Operator,
        time: f64,
    ) -> Result<&[Buffer], GpuError> {
        if let Some(walls) = &self.walls {
            walls.prepare(device, time, 0.0, 1)?;
        }
        let to = self.next();
        let fields = Fields {
            from: self.state(),
            to,
            exchange: self.exchange.as_ref(),
            walls: self.walls.as_ref().map(WallSlots::buffers),
            step_size: &self.step_size,
            combination: None,
            heat: None,
        };
        let mut passes = operator.passes(device, Makes::Rate, &fields)?;
        if let Some((seams, fields)) = self.seams(&to[0]) {
            passes.push(seams.rate(device, fields)?);
        }
        device.submit(&passes)?;
        Ok(to)
    }

    /// Whether every value is finite.
    pub(super) fn is_finite(&self, device: &Device) -> Result<bool, GpuError> {
        Ok(!self.raises_flag(device, &self.finite[self.current])?)
    }

    /// Whether the last step changed nothing. Of potentials that says nothing: they rest while a particle
    /// melts.
    pub(super) fn is_still(&self, device: &Device) -> Result<bool, GpuError> {
        Ok(self.enthalpy.is_none() && !self.raises_flag(device, &self.still)?)
    }

    fn raises_flag(&self, device: &Device, passes: &[Pass]) -> Result<bool, GpuError> {
        device.write(&self.flag, &[0; 4])?;
        device.submit(passes)?;
        Ok(device.read(&self.flag)?.iter().any(|&byte| byte != 0))
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let states = self.state.iter().flatten();
        let buffers = states.chain([&self.step_size, &self.flag]).chain(&self.exchange);
        let enthalpy = self.enthalpy.as_ref().map_or(0, Enthalpy::bytes);
        let seams = self.seams.as_ref().map_or(0, DeviceSeams::bytes);
        buffers.map(Buffer::bytes).sum::<u64>()
            + enthalpy
            + seams
            + self.fronts.as_ref().map_or(0, DeviceFronts::bytes)
            + self.walls.as_ref().map_or(0, WallSlots::bytes)
    }
}
