//! Which method a run takes where the case leaves it open.

use super::plan::Path;
use crate::model::integrator::{Method, MethodChoice, Tolerance, rkl2_stages};
use crate::model::{Problem, StepChoice};

/// What an iteration of conjugate gradients costs beside an operator application: on a lattice, where
/// that is cheap, more.
const ITERATION_ON_LATTICE: f64 = 3.0;
const ITERATION_ON_ROWS: f64 = 1.5;

/// What a stage of RKL2 costs in the same way.
const STAGE_ON_LATTICE: f64 = 1.8;
const STAGE_ON_ROWS: f64 = 1.2;

/// Iterations of a solve with the coarse space at most, about.
const MOST_ITERATIONS: f64 = 30.0;

/// Steps of `tr_bdf2` over those of explicit methods from rough data, which it damps at once.
const FEWER: f64 = 0.4;

/// Steps that follow a tolerance where something melts, for each particle: the field has a kink in time
/// wherever one begins or ends to melt, and steps shorten there. `melting_rod` took 2.8 (100 particles) and 2.6
/// (400) by `rkl2`, `freezing_pipe` 6.4; but rarely fewer applications of three to the shortest explicit step.
const STEPS_OF_MELTING: f64 = 4.0;
const LEAST_APPLICATIONS: f64 = 3.0;

/// Linear solves of an implicit stage where the state is an enthalpy.
const SOLVES_OF_NEWTON: f64 = 4.0;

/// The method of a run, and why where the case leaves it open.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ChosenMethod {
    /// The method.
    pub(super) method: Method,
    /// Why, in words.
    pub(super) why: Option<String>,
}

impl ChosenMethod {
    /// The method of `problem`, whose eigenvalues are no larger than about `largest` (1/s) and whose
    /// matrix is `symmetric` or not; the path sets what vectors cost beside an application.
    pub(super) fn of(problem: &Problem, path: Path, largest: f64, symmetric: bool) -> Self {
        if let MethodChoice::Given(method) = problem.time.method {
            return Self { method, why: None };
        }
        let tolerance = match problem.time.step {
            StepChoice::Tolerance(tolerance) => tolerance,
            StepChoice::Automatic | StepChoice::Given(_) => Tolerance::DEFAULT,
        };
        let scale = problem.initial.iter().fold(0.0, |scale: f64, value| scale.max(value.abs()));
        let part = if scale > 0.0 { tolerance.of(scale) / scale } else { tolerance.relative };
        // An absolute tolerance says nothing of a field without a size.
        let part = if part > 0.0 { part } else { Tolerance::DEFAULT.relative };
        let reach = largest * problem.time.end;
        let melting = match problem.melts() {
            true => {
                let particles = problem.particles.len() as f64;
                (STEPS_OF_MELTING * particles).min(reach / LEAST_APPLICATIONS)
            }
            false => 0.0,
        };
        let [steps, implicit] = match problem.time.step {
            StepChoice::Given(step) => [(problem.time.end / step).ceil(); 2],
            _ => [steps_for(part), (FEWER * steps_for(part)).ceil()].map(|n| n.max(melting)),
        };
        let solves = if problem.has_curves() { SOLVES_OF_NEWTON } else { 1.0 };
        let mut costs = costs(path, reach, [steps, implicit], solves, part).to_vec();
        let is_kinked = melting >= steps_for(part);
        if is_kinked && problem.time.step == StepChoice::Automatic {
            // Its steps are as short as the melting makes those of the others.
            costs.insert(0, (Method::Euler, 0.5 * reach));
        }
        let is_stable = match problem.time.step {
            StepChoice::Given(step) => step * largest <= 2.0,
            _ => true,
        };
        let is_possible = |method: Method| {
            (symmetric || !method.is_implicit()) && (is_stable || !method.is_limited())
        };
        let possible = costs.iter().filter(|(method, _)| is_possible(*method));
        let cheapest = possible.min_by(|a, b| a.1.total_cmp(&b.1));
        let method = cheapest.map_or(Method::Rkl2, |(method, _)| *method);
        let others: Vec<String> =
            costs.iter().map(|(method, cost)| format!("{} {cost:.1e}", method.name())).collect();
        let skew = if symmetric { "" } else { "; the matrix is not symmetric" };
        let why = format!(
            "stiffness lambda_max T = {reach:.1e}, estimated costs in applications: {}{skew}",
            others.join(", ")
        );
        Self { method, why: Some(why) }
    }
}

/// Steps of a method of second order for an error that is `part` of the field, from rough data.
fn steps_for(part: f64) -> f64 {
    (0.5 / part.sqrt()).clamp(16.0, 1e6)
}

/// What each method costs, in operator applications.
fn costs(
    path: Path,
    reach: f64,
    [steps, implicit]: [f64; 2],
    solves: f64,
    part: f64,
) -> [(Method, f64); 3] {
    let is_lattice = matches!(path, Path::Lattice | Path::Mixed);
    let [iteration, stage] = match is_lattice {
        true => [ITERATION_ON_LATTICE, STAGE_ON_LATTICE],
        false => [ITERATION_ON_ROWS, STAGE_ON_ROWS],
    };
    // The error of conjugate gradients falls as exp(-2 k / sqrt(condition)) with the diagonal alone; the coarse
    // space bounds what is left to do.
    let condition = 1.0 + 0.3 * reach / implicit;
    let iterations = 0.5 * condition.sqrt() * (1.0 / (0.03 * part)).ln();
    // Newton's method has no coarse space.
    let iterations = if solves > 1.0 { iterations } else { iterations.min(MOST_ITERATIONS) };
    [
        (Method::Heun, 2.0 * stage * (0.5 * reach).max(steps)),
        (Method::Rkl2, stage * steps * rkl2_stages(reach / steps) as f64),
        (Method::TrBdf2, implicit * (1.0 + 2.0 * solves * iteration * iterations)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::scenes::lattice;
    use crate::model::{Conductivity, KernelKind, Material, Melting};

    fn cheapest(reach: f64) -> Method {
        let steps = steps_for(1e-4);
        let costs = costs(Path::List, reach, [steps, FEWER * steps], 1.0, 1e-4);
        costs.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are methods").0
    }

    #[test]
    fn the_stiffer_the_scene_the_more_implicit_the_method() {
        assert_eq!(cheapest(10.0), Method::Heun);
        assert_eq!(cheapest(1e4), Method::Rkl2);
        assert_eq!(cheapest(5e8), Method::TrBdf2);
    }

    #[test]
    fn what_melts_takes_short_explicit_steps_unless_it_is_stiff() {
        let chosen = |particles: usize, largest: f64, melts: bool| {
            let mut problem = lattice(KernelKind::CubicSpline, 1, [particles, 1, 1], 1.0, 2.0);
            problem.time.method = MethodChoice::Automatic;
            problem.time.end = 1.0;
            if melts {
                let solid = Conductivity::constant(1.0);
                let conductivity = solid.clone();
                let melting = Melting {
                    solidus: 1.0,
                    liquidus: 1.0,
                    latent: 1.0,
                    conductivity,
                    capacity: 1.0,
                };
                let made = Material::thermal("m", &solid, 1.0, Some(&melting), 1000.0);
                problem.materials = vec![made];
            }
            ChosenMethod::of(&problem, Path::Lattice, largest, true).method
        };
        assert_eq!(chosen(1000, 1e4, true), Method::Euler);
        assert_eq!(chosen(1000, 1e4, false), Method::Rkl2);
        assert_eq!(chosen(200, 1e7, true), Method::Rkl2);
    }
}
