//! Steps of an enthalpy beside seams.

use super::super::Lattice;
use super::*;
use crate::model::material::Melting;
use crate::model::operator::{SeamGroup, Seams};
use crate::model::{Conductivity, KernelKind, scenes};
use crate::solver::cpu::operator::{CpuOperator, RATE};

/// Two materials that melt, the second where `is_second` of x, and one that shares the curve of the first where
/// `is_third` of a position.
fn scene(
    support_ratio: f64,
    counts: [usize; 3],
    is_second: impl Fn(f64) -> bool,
    is_third: impl Fn(f64) -> bool,
) -> Problem {
    let dimension = counts.iter().filter(|&&count| count > 1).count();
    let kind = KernelKind::CubicSpline;
    let mut problem = scenes::lattice(kind, dimension, counts, 0.1, support_ratio);
    let melts = |solid: f64, capacity: f64, at: f64| {
        let melting = Melting {
            solidus: at,
            liquidus: at,
            latent: 1e6,
            conductivity: Conductivity::constant(4.0),
            capacity,
        };
        let solid = Conductivity::constant(solid);
        Material::thermal("metal", &solid, capacity, Some(&melting), 1000.0)
    };
    let first = melts(10.0, 1e4, 330.0);
    let third = Material { capacity: 3e4, ..first.clone() };
    problem.materials = vec![first, melts(6.0, 2e4, 335.0), third];
    for (particle, material) in problem.particles.material.iter_mut().enumerate() {
        let at = problem.particles.position[particle];
        *material = if is_third(at.y) { 2 } else { u16::from(is_second(at.x)) };
    }
    problem
}

/// Rates by rows with what seams add to the matrix, and by the stencil with what they add to a step; how many sites
/// are left to the stencil, and how many there are at seams.
fn by_rows_and_by_stencil(problem: &Problem) -> ([Vec<f64>; 2], [usize; 2]) {
    let mixed = MixedScene::of(problem).expect("a lattice");
    let lattice = mixed.lattice.clone();
    let (_, rows) = mixed.assemble(problem);
    let operator = Lattice::new(Mixed::new(problem, Arc::new(mixed), rows));
    let site = lattice.sites();
    let place: Vec<u32> = (0..problem.particles.len() as u32).map(&site).collect();
    let written = |place: usize, other: usize| operator.written_weight(place, other);
    let seams = Seams::of(problem, &place, true, written).expect("materials meet");
    let enthalpy = |place: usize| 250.0 + ((place * 37) % 400) as f64;
    let values = (0..problem.particles.len()).map(|particle| {
        let material = &problem.materials[usize::from(problem.particles.material[particle])];
        let curve = material.curve.as_ref().expect("it melts");
        curve.potential(enthalpy(place[particle] as usize))
    });
    let values = operator.by_place(&values.collect::<Vec<_>>());
    let locals = seams.locals(|row, place| seams.local(row, enthalpy(place)));
    let (mut scratch, now) = (Scratch::new(&lattice), Now::state(&values, &[]));
    let rates = [false, true].map(|to_step| {
        let mut rates = vec![0.0; values.len()];
        let (scratch, out, written) = (&mut scratch, &mut rates[..], Written::Same(RATE));
        match to_step {
            true => operator.of.advance_to_seams(scratch, &now, 0, out, written),
            false => operator.of.advance(scratch, &now, 0, out, written),
        };
        for SeamGroup { rows, .. } in seams.groups() {
            let add = |place: usize, _, rate: f64| rates[place] += rate;
            match to_step {
                true => seams.add_to_step(rows.clone(), &locals, add),
                false => seams.add(rows.clone(), &locals, add),
            };
        }
        rates
    });
    let left = seams.places().iter().filter(|&&place| written(place as usize, 0).is_some());
    (rates, [left.count(), seams.places().len()])
}

#[test]
fn what_seams_add_to_comes_of_the_stencil_as_of_rows() {
    let no = |_: f64| false;
    let right = |x: f64| x > 0.62;
    let layer = |x: f64| x > 0.62 && x < 0.71;
    // As many sites as are left to the stencil, of those at seams.
    let cases = [
        // Those of the last line are no rows that share lines.
        (scene(2.0, [14, 9, 8], right, no), [2 * 9 * 8, 2 * 9 * 8]),
        (scene(2.0, [14, 9, 1], right, no), [2 * 9, 2 * 9]),
        (scene(2.0, [14, 1, 1], right, no), [2, 2]),
        (scene(2.5, [14, 9, 8], right, no), [4 * 9 * 8, 4 * 9 * 8]),
        // Next to a layer of one on either side, pairs of two spacings go through it.
        (scene(2.5, [14, 9, 1], layer, no), [3 * 9, 5 * 9]),
        // What shares a curve conducts as well: no seam, and the weights of the stencil.
        (scene(2.0, [14, 9, 1], right, |y| y < 0.2), [30, 30]),
    ];
    for (which, (problem, expected)) in cases.into_iter().enumerate() {
        for more in ["nothing", "a hole", "held"] {
            let mut problem = problem.clone();
            let middle = problem.particles.len() / 2 - 1;
            match more {
                "a hole" if problem.dimension == 1 => continue,
                "a hole" => {
                    problem.particles.position.remove(middle);
                    problem.particles.material.remove(middle);
                    problem.particles.volume.pop();
                    problem.initial.pop();
                }
                "held" => problem.held = vec![middle as u32],
                _ => {}
            }
            let ([by_rows, by_stencil], left) = by_rows_and_by_stencil(&problem);
            match more {
                "nothing" => assert_eq!(left, expected, "{which}"),
                _ => assert!(left[0] <= expected[0] && left[1] <= expected[1], "{which}"),
            }
            let largest = by_rows.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
            assert!(largest > 1e-4, "{which}: something flows: {largest}");
            for (place, (one, other)) in by_rows.iter().zip(&by_stencil).enumerate() {
                assert!((one - other).abs() < 1e-12 * largest, "{which}, {more}: {place}");
            }
        }
    }
}
