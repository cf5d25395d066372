//! Steady states of an enthalpy: what a change of its potentials makes of it.

use std::array;

use rayon::prelude::*;

use crate::model::{HeatCurve, Problem};
use crate::solver::{Backend, SolverError};

/// Doublings and halvings that leave nothing between two numbers.
const MOST_TRIALS: u32 = 200;

/// Adds `change` (K), which is 0 for held particles, to the potentials of the state. In each of `bodies`,
/// where nothing holds a value and potentials are known up to a constant, takes the one that keeps the
/// energy. Where all of a body ends at its melting point, rounding decides which particles are liquid.
///
/// # Errors
/// [`SolverError::ConductivityUnknown`].
pub(super) fn add_to_potentials<B: Backend>(
    backend: &mut B,
    problem: &Problem,
    bodies: &[Vec<u32>],
    change: &B::Vector,
) -> Result<(), SolverError> {
    let before = backend.read()?.as_ref().to_vec();
    // A vector is read by adding it; what that leaves is no state of the scene.
    backend.save()?;
    backend.add(change)?;
    let moved = backend.read()?.as_ref().to_vec();
    backend.restore()?;
    let curve = |particle: usize| problem.curve(particle);
    let aim = |particle: usize, shift: f64| match curve(particle) {
        Some(curve) => {
            curve.potential(before[particle]) + (moved[particle] - before[particle]) + shift
        }
        None => moved[particle] + shift,
    };
    let mut after = before.clone();
    for (particle, after) in after.iter_mut().enumerate() {
        if moved[particle] != before[particle] {
            *after = of_potential(curve(particle), aim(particle, 0.0));
        }
    }
    for body in bodies {
        let energy = |particle: u32, enthalpy: f64| problem.capacity(particle as usize) * enthalpy;
        let wanted: f64 = body.iter().map(|&p| energy(p, before[p as usize])).sum();
        let total = |shift: f64| -> f64 {
            let of = |p: u32| of_potential(curve(p as usize), aim(p as usize, shift));
            let each: Vec<f64> = body.par_iter().map(|&p| energy(p, of(p))).collect();
            each.iter().sum()
        };
        let [low, high] = around(total, wanted);
        let totals = [low, high].map(total);
        let share = match totals[1] - totals[0] {
            0.0 => 0.0,
            gap => (wanted - totals[0]) / gap,
        };
        for &particle in body {
            let p = particle as usize;
            let [from, to]: [f64; 2] =
                array::from_fn(|end| of_potential(curve(p), aim(p, [low, high][end])));
            after[p] = from + share * (to - from);
        }
    }
    let is_unknown = |p: usize| curve(p).is_some_and(|curve| curve.potential(after[p]).is_nan());
    let is_beyond = (0..after.len()).any(is_unknown);
    let error = is_beyond.then(|| SolverError::of_temperatures(problem, &after, 0, 0.0));
    if let Some(error) = error.flatten() {
        return Err(error);
    }
    let correction: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
    let mut vector = backend.vector()?;
    backend.load(&correction, &mut vector)?;
    backend.add(&vector)
}

fn of_potential(curve: Option<&HeatCurve>, potential: f64) -> f64 {
    curve.map_or(potential, |curve| curve.enthalpy_of_potential(potential))
}

/// Two neighbouring shifts between which a total that never falls passes `wanted`.
fn around(total: impl Fn(f64) -> f64, wanted: f64) -> [f64; 2] {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..MOST_TRIALS {
        match (total(low) > wanted, total(high) < wanted) {
            (true, _) => low *= 2.0,
            (_, true) => high *= 2.0,
            _ => break,
        }
    }
    for _ in 0..MOST_TRIALS {
        let middle = 0.5 * (low + high);
        if middle.abs() < f64::EPSILON || middle <= low || middle >= high {
            break;
        }
        if total(middle) <= wanted { low = middle } else { high = middle }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_total_is_met_from_both_sides_also_where_it_jumps() {
        let straight = around(|shift| 3.0 * shift, 12.0);
        assert!(straight[0] <= 4.0 && straight[1] >= 4.0 && straight[1] - straight[0] < 1e-14);
        let jump = around(|shift| if shift > -700.0 { 1.0 } else { 0.0 }, 0.5);
        assert_eq!(jump, [-700.0, (-700.0_f64).next_up()]);
    }
}
