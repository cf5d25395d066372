//! What is kept and written while a run goes on.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use glam::DVec3;

use super::pictures;
use super::run::RunError;
use crate::case::{OutputField, Scene};
use crate::model::Problem;
use crate::model::integrator::Segment;
use crate::model::interpolation::Interpolation;
use crate::model::operator::rows;
use crate::report::run::ProbeReport;
use crate::report::{
    FrontWriter, History, HistoryPlot, OutputFolder, ProbeRecord, ProbeWriter, Reading,
    SeriesWriter,
};
use crate::solver::{Observer, Progress, Still};

/// Writes fields, probes and the front at their times, and keeps the last state.
pub(super) struct Recorder<'a> {
    scene: &'a Scene,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    files: Option<Files>,
    interpolations: Vec<Interpolation>,
    /// The summation density, where a file wants it.
    density: Vec<f64>,
    /// Time of the last state, s.
    pub(super) time: f64,
    /// The last state, in the problem's order.
    pub(super) state: Cow<'a, [f64]>,
    /// What the first probes read on the way, where there are files.
    pub(super) histories: Vec<History>,
    /// Where the front was on the way, where there are files and something melts.
    pub(super) fronts: History,
    /// Since when the state has not changed.
    pub(super) still: Option<Still>,
    /// Time spent here.
    pub(super) spent: Duration,
}

struct Files {
    series: SeriesWriter,
    probes: ProbeWriter,
    /// Of a scene that melts.
    front: Option<FrontWriter>,
}

impl<'a> Recorder<'a> {
    /// Starts the files of `folder`, if there is one, with the initial state.
    pub(super) fn start(
        scene: &'a Scene,
        folder: Option<&OutputFolder>,
        progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Self, RunError> {
        let clock = Instant::now();
        let problem = &scene.problem;
        let interpolations = (problem.probes.iter())
            .map(|probe| {
                Interpolation::at(problem, probe.at)
                    .ok_or_else(|| RunError::ProbeInVoid { name: probe.name.clone(), at: probe.at })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let files = folder.map(|folder| Files::create(folder, problem)).transpose()?;
        let wants_density = files.is_some() && scene.fields.contains(&OutputField::Density);
        let density = if wants_density { rows::density(problem) } else { Vec::new() };
        let state = Cow::Borrowed(&problem.initial[..]);
        let mut recorder = Self {
            scene,
            progress,
            files,
            interpolations,
            density,
            time: 0.0,
            state,
            histories: Vec::new(),
            fronts: History::default(),
            still: None,
            spent: Duration::ZERO,
        };
        recorder.write_fields()?;
        recorder.write_probes()?;
        recorder.write_front()?;
        recorder.spent = clock.elapsed();
        Ok(recorder)
    }

    /// The values of the last state: temperatures, where that is an enthalpy.
    pub(super) fn values(&self) -> Cow<'_, [f64]> {
        self.scene.problem.values(&self.state)
    }

    /// What the probes read in the last state.
    pub(super) fn probes(&self) -> Vec<ProbeReport> {
        let values = self.values();
        let probes = self.scene.problem.probes.iter().zip(&self.interpolations);
        probes
            .map(|(probe, interpolation)| ProbeReport {
                name: probe.name.clone(),
                at: probe.at.to_array()[..self.scene.problem.dimension].to_vec(),
                time: self.time,
                value: interpolation.of(&values, self.time),
                exact: self.exact_at(probe.at),
            })
            .collect()
    }

    /// The exact value at a point at the time of the last state, where it is finite.
    fn exact_at(&self, at: DVec3) -> Option<f64> {
        let exact = self.scene.exact.as_ref()?.at(at, self.time);
        exact.is_finite().then_some(exact)
    }

    /// The exact solution at the time of the last state; NaN where it is singular.
    pub(super) fn exact(&self) -> Option<Vec<f64>> {
        let exact = self.scene.exact.as_ref()?;
        let mut values = exact.evaluate(&self.scene.problem.particles.position, self.time);
        // A point source is infinite at its point at t = 0: there is nothing to compare with, and
        // an infinity would spoil the colour range of every viewer.
        values.iter_mut().filter(|x| x.is_infinite()).for_each(|x| *x = f64::NAN);
        Some(values)
    }

    fn write_fields(&mut self) -> Result<(), RunError> {
        if self.files.is_none() {
            return Ok(());
        }
        let wants = |field| self.scene.fields.contains(&field);
        let problem = &self.scene.problem;
        let values = problem.values(&self.state);
        let of_curves = |field, of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            if wants(field) { (0..values.len()).map(of).collect() } else { Vec::new() }
        };
        let enthalpy = of_curves(OutputField::Enthalpy, &|particle| {
            problem.unit_capacity(particle) * self.state[particle]
        });
        let liquid = of_curves(OutputField::LiquidFraction, &|particle| {
            problem.liquid_fraction(particle, self.state[particle])
        });
        let compares = wants(OutputField::Exact) || wants(OutputField::Error);
        let exact = if compares { self.exact().unwrap_or_default() } else { Vec::new() };
        let error: Vec<f64> = if wants(OutputField::Error) {
            values.iter().zip(&exact).map(|(value, exact)| value - exact).collect()
        } else {
            Vec::new()
        };
        let fields: Vec<(&str, &[f64])> = (self.scene.fields.iter())
            .map(|field| match field {
                OutputField::Value => ("value", &values[..]),
                OutputField::Enthalpy => ("enthalpy", &enthalpy[..]),
                OutputField::LiquidFraction => ("liquid_fraction", &liquid[..]),
                OutputField::Exact => ("exact", &exact[..]),
                OutputField::Error => ("error", &error[..]),
                OutputField::Density => ("density", &self.density[..]),
            })
            .collect();
        if let Some(files) = &mut self.files {
            files.series.write(self.time, &self.scene.problem.particles.position, &fields)?;
        }
        Ok(())
    }

    fn write_probes(&mut self) -> Result<(), RunError> {
        let probes = self.probes();
        let Some(files) = &mut self.files else {
            return Ok(());
        };
        self.histories.resize(probes.len().min(HistoryPlot::MOST_TRACES), History::default());
        for (history, probe) in self.histories.iter_mut().zip(&probes) {
            history.push(Reading { time: probe.time, value: probe.value, exact: probe.exact });
        }
        let places = probes.iter().zip(&self.scene.problem.probes);
        let records: Vec<ProbeRecord<'_>> = places
            .map(|(probe, place)| ProbeRecord {
                time: probe.time,
                name: &probe.name,
                at: place.at,
                value: probe.value,
                exact: probe.exact,
            })
            .collect();
        Ok(files.probes.write(&records)?)
    }

    fn write_front(&mut self) -> Result<(), RunError> {
        let Some(writer) = self.files.as_mut().and_then(|files| files.front.as_mut()) else {
            return Ok(());
        };
        let Some(front) = pictures::front(self.scene, &self.state, self.time) else {
            return Ok(());
        };
        self.fronts.push(Reading { time: self.time, value: front.position, exact: front.exact });
        Ok(writer.write(self.time, &front)?)
    }

    fn keep(&mut self, time: f64, state: &[f64]) {
        self.time = time;
        self.state = Cow::Owned(state.to_vec());
    }
}

impl Files {
    fn create(folder: &OutputFolder, problem: &Problem) -> Result<Self, RunError> {
        folder.remove_stale()?;
        let path = folder.path();
        let front = problem.melts().then(|| FrontWriter::create(path)).transpose()?;
        let probes = ProbeWriter::create(path, problem.dimension)?;
        Ok(Self { series: SeriesWriter::new(path), probes, front })
    }
}

impl Observer for Recorder<'_> {
    type Error = RunError;

    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self.still = progress.still;
        (self.progress)(progress)
    }

    fn record(&mut self, segment: &Segment, state: &[f64]) -> Result<(), RunError> {
        let clock = Instant::now();
        self.keep(segment.end, state);
        if segment.output {
            self.write_fields()?;
        }
        if segment.probe {
            self.write_probes()?;
        }
        self.write_front()?;
        self.spent += clock.elapsed();
        Ok(())
    }

    fn last_state(&mut self, time: f64, state: &[f64]) -> Result<(), RunError> {
        let clock = Instant::now();
        if time > self.time {
            self.keep(time, state);
            self.write_fields()?;
            self.write_probes()?;
            self.write_front()?;
        }
        self.spent += clock.elapsed();
        Ok(())
    }
}
