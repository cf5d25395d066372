//! What a run is held to.

use super::scan::Bounds;
use super::trial::Trial;
use super::way::Way;
use crate::model::integrator::Tolerance;
use crate::model::operator::FoldNeeds;
use crate::model::{Problem, WallKind};
use crate::report::stability::Check;
use crate::solver::{Foreseen, Precision, SolverError};

/// An error of a run may be this many times its tolerance.
const TIMES_TOLERANCE: f64 = 3.0;

/// What halving a step must leave of the error of explicit Euler: half, and some of it.
const HALVED: f64 = 0.7;

/// Errors below this are rounding in f64, of the scale of the field.
const NO_ERROR: f64 = 1e-9;

/// What a steady state may be off, of the scale of the field.
const STEADY_OFF: f64 = 1e-6;

/// What the growth of a run above its limit may be off.
const GROWTH_OFF: f64 = 0.01;

/// Up to this contrast of diffusivities the accuracy of methods that solve linear systems is promised.
const MOST_CONTRAST: f64 = 1e6 * (1.0 + 1e-9);

/// Up to this error in the field, of its scale, what a solve leaves is promised.
const MOST_UNSOLVED: f64 = 1e-2;

/// Times at which what walls impose is looked at.
const LOOKS: u32 = 32;

/// The values that a scene starts from and that its walls impose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    low: f64,
    high: f64,
    /// Whether nothing else can drive a value anywhere.
    is_whole: bool,
}

impl Range {
    /// That of `problem`.
    pub(super) fn of(problem: &Problem) -> Self {
        let mut range = Self { low: f64::INFINITY, high: f64::NEG_INFINITY, is_whole: true };
        problem.initial.iter().for_each(|value| range.take(*value));
        if FoldNeeds::of(problem) < FoldNeeds::Steady {
            return range;
        }
        for wall in &problem.walls {
            let imposed = &wall.condition.imposed;
            if !matches!(wall.condition.kind, WallKind::Value | WallKind::Convection) {
                range.is_whole &= wall.condition.kind != WallKind::Flux;
                continue;
            }
            let looks = if imposed.depends_on_time() { LOOKS } else { 0 };
            for look in 0..=looks {
                let time = problem.time.end * f64::from(look) / f64::from(looks.max(1));
                for x in &problem.particles.position {
                    range.take(imposed.at(wall.face.foot(&problem.domain, *x), time));
                    if !imposed.depends_on_position() {
                        break;
                    }
                }
            }
        }
        range.is_whole &= problem.surfaces.is_empty() && problem.sources.is_empty();
        range
    }

    fn take(&mut self, value: f64) {
        (self.low, self.high) = (self.low.min(value), self.high.max(value));
    }

    /// The largest magnitude.
    pub(super) fn scale(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// How far values between these leave the range, of the scale.
    fn left_by(&self, [low, high]: [f64; 2]) -> f64 {
        let out = (self.low - low).max(high - self.high);
        let scale = self.scale();
        if out <= 0.0 { 0.0 } else { out / if scale > 0.0 { scale } else { 1.0 } }
    }
}

/// The largest difference of two fields over `scale`.
pub(super) fn distance(a: &[f64], b: &[f64], scale: f64) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    // No number is as far as can be.
    let largest =
        off.fold(0.0, |most: f64, x| if x.is_nan() { f64::INFINITY } else { most.max(x) });
    if scale > 0.0 { largest / scale } else { largest }
}

/// What a trial is judged by.
pub(super) struct Judge<'a> {
    /// The problem that was run, before anything was done to it.
    pub(super) problem: &'a Problem,
    pub(super) bounds: &'a Bounds,
    pub(super) precision: Precision,
    pub(super) range: Range,
}

impl Judge<'_> {
    /// What rounding makes of a sum over neighbours in a step, in as many steps as were taken: the worst
    /// case, in which all errors have one sign.
    fn rounding(&self, steps: u64) -> f64 {
        let unit = match self.precision {
            Precision::F32 => f64::from(f32::EPSILON),
            // Weights, and what walls impose, are in f32.
            Precision::Compensated => 0.1 * f64::from(f32::EPSILON),
            Precision::F64 => f64::EPSILON,
        };
        unit * (steps.min(1000) + 10) as f64 * self.bounds.neighbors as f64
    }

    /// Whether f32 is known beforehand to harm the run, of which it then warns.
    fn is_warned(&self) -> bool {
        self.precision == Precision::F32 && Foreseen::of(self.problem) != Foreseen::Good
    }

    /// Whether the accuracy of `way` is promised: methods that solve linear systems know small residuals
    /// alone, and at a large contrast the error may be far larger.
    fn is_promised(&self, way: Way) -> bool {
        let is_small =
            || contrast(self.problem) <= MOST_CONTRAST && self.unsolved(way) <= MOST_UNSOLVED;
        !self.is_warned() && (!way.solves() || is_small())
    }

    /// What the end of a linear system's solve leaves in the field, over what it leaves of the residual: as much as
    /// the contrast is.
    fn unsolved(&self, way: Way) -> f64 {
        if way.solves() { self.precision.finest() * contrast(self.problem) } else { 0.0 }
    }

    /// What `trial` in this `way` is held to; `reference` is what it should have come to, `halved` the same
    /// with half the step, and `in_f64` the state of the same way in f64.
    pub(super) fn checks(
        &self,
        way: Way,
        trial: &Trial,
        reference: Option<&[f64]>,
        halved: Option<&[f64]>,
        in_f64: Option<&[f64]>,
    ) -> Vec<Check> {
        let mut checks = vec![self.bounded(way, trial), self.kept(trial)];
        let scale = self.range.scale();
        let unsolved = self.unsolved(way);
        if let Some(reference) = reference {
            let error = distance(&trial.state, reference, scale);
            let promised = self.is_promised(way);
            checks.push(match (way, halved) {
                (Way::EulerSafe, Some(halved)) => {
                    let less = distance(halved, reference, scale);
                    let left = if error <= NO_ERROR.max(self.precision.finest()) {
                        0.0
                    } else {
                        less / error
                    };
                    Check::at_most("error left by half the step", left, HALVED, promised)
                }
                (Way::EulerSafe | Way::EulerBelow | Way::EulerAbove, _) => {
                    Check::at_most("error", error, 1.0, promised)
                }
                (Way::Steady, _) => {
                    let off = STEADY_OFF.max(10.0 * self.precision.finest());
                    Check::at_most("error", error, off.max(unsolved), promised)
                }
                (Way::Tolerant(_) | Way::Slow, _) => {
                    let most = TIMES_TOLERANCE * Tolerance::DEFAULT.relative;
                    Check::at_most("error", error, most + unsolved, promised)
                }
            });
        }
        if reference.is_none() {
            checks.push(Check::that("compared with a reference", false, false));
        }
        if let Some(in_f64) = in_f64 {
            let off = distance(&trial.state, in_f64, scale);
            let most = match (way, self.precision) {
                // Rounding may have other steps taken, and what these leave counts as well.
                (Way::Tolerant(_) | Way::Slow, _) => 2.0 * Tolerance::DEFAULT.relative,
                (Way::Steady, _) => 100.0 * self.precision.finest(),
                (_, Precision::F32) => 1e-4,
                (_, Precision::Compensated | Precision::F64) => 1e-6,
            };
            let what = format!("{} against f64", self.precision.name());
            checks.push(Check::at_most(&what, off, most.max(unsolved), self.is_promised(way)));
        }
        checks
    }

    /// How far values leave the range that they start from and that walls impose.
    fn bounded(&self, way: Way, trial: &Trial) -> Check {
        let left = self.range.left_by(trial.seen);
        let (most, promised) = match way {
            Way::EulerSafe => (self.rounding(trial.steps), true),
            // The norm falls, but not every value stays inside.
            Way::EulerBelow => (self.rounding(trial.steps), false),
            Way::EulerAbove => (f64::INFINITY, false),
            Way::Tolerant(_) | Way::Slow => {
                (TIMES_TOLERANCE * Tolerance::DEFAULT.relative, self.is_promised(way))
            }
            Way::Steady => (STEADY_OFF.max(10.0 * self.precision.finest()), self.is_promised(way)),
        };
        let most = most.max(self.unsolved(way));
        Check::at_most("leaves the range by", left, most, promised && self.range.is_whole)
    }

    /// Whether walls, sources or held particles give anything.
    fn exchanges(&self) -> bool {
        !self.problem.held.is_empty() || FoldNeeds::of(self.problem) >= FoldNeeds::Steady
    }

    /// What the total lost.
    fn kept(&self, trial: &Trial) -> Check {
        let drift = trial.conserved.relative_drift.abs();
        // A rate has the rounding of its largest term, lambda_max times a value; over a time T that is what
        // the exchange may be off.
        let reach = if self.bounds.limit.is_finite() {
            2.0 * self.problem.time.end / self.bounds.limit
        } else {
            0.0
        };
        let most = match self.precision {
            Precision::F32 => 1e-4,
            // Sums are compensated, what walls and held particles give in a step is not.
            Precision::Compensated if self.exchanges() => {
                1e-6_f64.max(f64::from(f32::EPSILON) * reach)
            }
            Precision::Compensated => 1e-6,
            Precision::F64 => 1e-13_f64.max(f64::EPSILON * reach),
        };
        Check::at_most("drift of the total", drift, most, !self.is_warned())
    }

    /// A step below the limit: however far values leave the range, the norm bounds them.
    pub(super) fn bounded_by_norm(&self, trial: &Trial) -> Check {
        let volume = &self.problem.particles.volume;
        let least = volume.iter().copied().fold(f64::INFINITY, f64::min);
        let most = (volume.iter().sum::<f64>() / least).sqrt();
        let left = self.range.left_by(trial.seen);
        Check::at_most("bounded: leaves the range by", left, most, self.range.is_whole)
    }
}

/// What is to be seen of a step above the limit: that it is refused, that it grows as it must, and that its
/// end is named.
pub(super) fn above(
    refused: &Result<Trial, SolverError>,
    growth: Option<f64>,
    ended: &Result<Trial, SolverError>,
    ratio: f64,
) -> Vec<Check> {
    let is_refused = matches!(refused, Err(SolverError::UnstableStep { .. }));
    let stopped = ended.as_ref().ok().and_then(|trial| trial.stopped.as_ref());
    let is_named = matches!(stopped, Some(SolverError::Diverged { step, .. }) if *step > 0);
    let mut checks = vec![
        Check::that("refused unless allowed", is_refused, true),
        Check::that("divergence named", is_named, true),
    ];
    if let Some(growth) = growth {
        let off = (growth / (2.0 * ratio - 1.0) - 1.0).abs();
        checks.push(Check::at_most("growth off |1 - dt lambda|", off, GROWTH_OFF, true));
    }
    checks
}

/// The largest diffusivity of any particle over the smallest.
fn contrast(problem: &Problem) -> f64 {
    let of = |material: &u16| problem.materials[usize::from(*material)].diffusivity();
    let each = || problem.particles.material.iter().map(of);
    each().fold(0.0, f64::max) / each().fold(f64::INFINITY, f64::min)
}

/// How an error counts: as one that the README documents, or as a fault.
pub(super) fn is_documented(error: &SolverError) -> bool {
    matches!(
        error,
        SolverError::NotSymmetric { .. }
            | SolverError::NeverSteady
            | SolverError::NoSteadyState { .. }
            | SolverError::CoincidentParticles { .. }
            | SolverError::NotCompensated { .. }
            | SolverError::NothingBetter { .. }
    )
}
