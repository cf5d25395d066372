//! What runs of a scene should come to.

use super::scan::Bounds;
use super::scenes::{ExtremeScene, Length};
use super::trial::{self, Watch};
use super::way::{Way, implicit_reference, reference};
use crate::model::operator::floating_bodies;
use crate::model::{Problem, WallKind};
use crate::solver::Machine;

/// Steps of the reference to one safe step.
const FINER: f64 = 4.0;

/// The tolerance of the reference over a long time.
const TIGHT: f64 = 1e-5;

/// What runs of a scene should come to, computed once each where something asks for it.
#[derive(Default)]
pub(super) struct References {
    fast: Option<Option<Vec<f64>>>,
    slow: Option<Option<Vec<f64>>>,
    steady: Option<Option<Vec<f64>>>,
}

impl References {
    /// What `way` should come to; `None` where nothing is known.
    pub(super) fn of(
        &mut self,
        way: Way,
        scene: &ExtremeScene,
        bounds: &Bounds,
        watch: &mut Watch<'_>,
    ) -> Option<&[f64]> {
        let problem = way.problem(scene, bounds);
        let mut solved = |problem: &Problem| {
            let trial = trial::run(problem, &Machine::Cpu, false, watch).ok()?;
            trial.stopped.is_none().then_some(trial.state)
        };
        let found = match (way, scene.length) {
            (Way::EulerAbove, _) => return None,
            // After that many steps nothing moves any more.
            (Way::Steady, _) | (_, Length::EqualSteps(_)) => {
                self.steady.get_or_insert_with(|| steady(&scene.problem))
            }
            (Way::Slow, _) => {
                self.slow.get_or_insert_with(|| solved(&implicit_reference(&problem, TIGHT)))
            }
            (Way::EulerSafe | Way::EulerBelow | Way::Tolerant(_), _) => {
                let step = problem.time.end / scene.length.steps() as f64;
                self.fast.get_or_insert_with(|| solved(&reference(&problem, step, FINER)))
            }
        };
        found.as_deref()
    }
}

/// The steady state of a scene whose walls impose one value, if any: that value, and the mean of bodies in
/// which nothing holds a value.
fn steady(problem: &Problem) -> Option<Vec<f64>> {
    let is_value = |kind: WallKind| kind == WallKind::Value;
    let is_silent = |kind: WallKind| matches!(kind, WallKind::Free | WallKind::Insulated);
    let mut values = Vec::new();
    for condition in problem.walls.iter().map(|wall| &wall.condition) {
        let field = &condition.imposed;
        if is_value(condition.kind) && !field.depends_on_time() && !field.depends_on_position() {
            values.push(field.at(problem.domain.min, 0.0));
        } else if !is_silent(condition.kind) {
            return None;
        }
    }
    let same = values.windows(2).all(|pair| pair[0] == pair[1]);
    if !same || !problem.held.is_empty() || !problem.surfaces.is_empty() {
        return None;
    }
    let mut state = vec![values.first().copied().unwrap_or(f64::NAN); problem.particles.len()];
    let volume = &problem.particles.volume;
    for body in floating_bodies(problem) {
        let particles = || body.iter().map(|&particle| particle as usize);
        let whole: f64 = particles().map(|a| volume[a]).sum();
        let mean = particles().map(|a| volume[a] * problem.initial[a]).sum::<f64>() / whole;
        particles().for_each(|a| state[a] = mean);
    }
    Some(state)
}
