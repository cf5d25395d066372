//! Steps of an enthalpy beside seams.

use super::super::Lattice;
use super::*;
use crate::model::material::Melting;
use crate::model::operator::{SeamGroup, Seams};
use crate::model::{Condition, Conductivity, Face, KernelKind, Wall, scenes};
use crate::solver::cpu::operator::{Combine, CpuOperator};

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

/// What is written, and what held particles give, by rows with what seams add to the matrix, and by the stencil with what
/// they add to a step; how many sites are left to the stencil, and how many there are at seams.
fn by_rows_and_by_stencil(problem: &Problem) -> ([(Vec<f64>, f64); 2], [usize; 2]) {
    let mixed = MixedScene::of(problem).expect("a lattice");
    let lattice = mixed.lattice.clone();
    let (_, rows) = mixed.assemble(problem);
    let left = mixed.beside_seams(problem, &rows, MOST_OF_WEIGHT);
    let operator = Lattice::new(Mixed::new(problem, Arc::new(mixed.clone()), rows));
    let count = lattice.counts.iter().product();
    for place in 0..count {
        let Some(entries) = operator.written_entries(place) else { continue };
        let weights = entries.to_vec(place);
        assert!(left.contains(&(place as u32)), "{place}");
        let expected = mixed.stencil(problem, place);
        assert_eq!(weights.len(), expected.len());
        for ((other, weight), (expected, of_model)) in weights.into_iter().zip(expected) {
            assert!(other == expected && (weight / of_model - 1.0).abs() < 1e-12);
        }
    }
    let site = lattice.sites();
    let place: Vec<u32> = (0..problem.particles.len() as u32).map(&site).collect();
    let written = |place| Some(operator.written_entries(place)?.to_vec(place));
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
    // Of each material another step.
    let combines = [1.0, 2.0, 3.0].map(|factor| Combine::new(0.5, factor));
    let all = [false, true].map(|to_step| {
        let (mut out, mut given) = (vec![0.0; count], 0.0);
        // In two parts, the second from the middle of a line on.
        let middle = (count / 2 / lattice.counts[0]) * lattice.counts[0] + 3;
        let (begin, end) = out.split_at_mut(middle);
        for (first, out) in [(0, begin), (middle, end)] {
            let (scratch, written) = (&mut scratch, Written::Each(&combines));
            let by = if to_step { BesideSeams::ByStencil } else { BesideSeams::ByRows };
            given += operator.of.advance(scratch, &now, first, out, written, by);
        }
        for SeamGroup { material, rows } in seams.groups() {
            let factor = combines[usize::from(*material)].factors[0];
            let add = |place: usize, _, rate: f64| out[place] += factor * rate;
            given += match to_step {
                true => seams.add_to_step(rows.clone(), &locals, add),
                false => seams.add(rows.clone(), &locals, add),
            };
        }
        (out, given)
    });
    let left = (0..count).filter(|&place| operator.written_entries(place).is_some());
    (all, [left.count(), seams.places().len()])
}

#[test]
fn what_seams_add_to_comes_of_the_stencil_as_of_rows() {
    let no = |_: f64| false;
    let right = |x: f64| x > 0.62;
    let layer = |x: f64| x > 0.62 && x < 0.71;
    // As many sites as are left to the stencil, and as are at seams.
    let cases = [
        (scene(2.0, [14, 9, 8], right, no), [2 * 9 * 8, 2 * 9 * 8]),
        (scene(2.0, [14, 9, 1], right, no), [2 * 9, 2 * 9]),
        (scene(2.0, [14, 1, 1], right, no), [2, 2]),
        (scene(2.5, [14, 9, 8], right, no), [4 * 9 * 8, 4 * 9 * 8]),
        // Next to a layer of one on either side, pairs of two spacings go through it.
        (scene(2.5, [14, 9, 1], layer, no), [3 * 9, 5 * 9]),
        // What shares a curve conducts as well: no seam, and the weights of the stencil. Ten rows more are between these.
        (scene(2.0, [14, 9, 1], right, |y| y < 0.2), [40, 30]),
    ];
    for (which, (problem, expected)) in cases.into_iter().enumerate() {
        for more in ["nothing", "a hole", "held", "walls", "round"] {
            let mut problem = problem.clone();
            // At the seam, and not at an end.
            let [_, ny, nz] = [14, 9, 8].map(|count| count.min(problem.particles.len() / 14));
            let (y, z) = (ny / 2, if problem.dimension == 3 { nz / 2 } else { 0 });
            let at_seam = (z * 9 + y) * 14 + 6;
            match more {
                "a hole" if problem.dimension == 1 => continue,
                "a hole" => {
                    problem.particles.position.remove(at_seam);
                    problem.particles.material.remove(at_seam);
                    problem.particles.volume.pop();
                    problem.initial.pop();
                }
                "held" => problem.held = vec![at_seam as u32],
                "walls" => {
                    let faces = Face::all(problem.dimension);
                    let wall = |face| Wall {
                        name: "a wall".into(),
                        face,
                        covers: None,
                        condition: Condition::insulated(),
                    };
                    problem.walls = faces.map(wall).collect();
                }
                "round" => problem.domain.periodic = [false, problem.dimension > 1, false],
                _ => {}
            }
            let ([by_rows, by_stencil], left) = by_rows_and_by_stencil(&problem);
            match more {
                "a hole" | "held" => {
                    assert!(left[0] < expected[0] && left[0] > 0, "{which}, {more}: {left:?}");
                }
                // Of lines that would end behind the last site rows share none; round an axis more materials meet.
                "round" => assert!(left[0] >= expected[0] / 2, "{which}: {left:?}"),
                _ => assert_eq!(left, expected, "{which}, {more}"),
            }
            let largest = by_rows.0.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
            for (place, (one, other)) in by_rows.0.iter().zip(&by_stencil.0).enumerate() {
                assert!((one - other).abs() < 1e-12 * largest, "{which}, {more}: {place}");
            }
            assert!((by_rows.1 - by_stencil.1).abs() <= 1e-12 * by_rows.1.abs());
            assert_eq!(by_rows.1 != 0.0, more == "held", "{which}");
        }
    }
}

#[test]
fn rows_of_which_the_stencil_has_far_more_are_not_left_to_it() {
    let problem = scene(2.0, [14, 9, 1], |x| x > 0.62, |_| false);
    let mixed = MixedScene::of(&problem).expect("a lattice");
    let (_, rows) = mixed.assemble(&problem);
    // 10 and 6 W/(m K) have 7.5 between them.
    for (most, expected) in [(1.4, 2 * 9), (1.3, 9), (0.7, 0)] {
        assert_eq!(mixed.beside_seams(&problem, &rows, most).len(), expected, "{most}");
    }
}
