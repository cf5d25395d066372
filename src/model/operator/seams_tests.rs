//! Rows of seams, one by one and several at once.

use std::collections::HashMap;

use super::*;
use crate::model::material::Melting;
use crate::model::scenes::lattice;
use crate::model::{Conductivity, KernelKind, Problem};

/// Three materials, two of which melt, that meet along a plane and around a block; some particles are held.
fn three() -> Problem {
    let mut problem = lattice(KernelKind::WendlandC2, 3, [9, 12, 10], 0.1, 2.5);
    let melts = |solid: f64, at: f64, liquid: f64| {
        let melting = Melting {
            solidus: at,
            liquidus: at,
            latent: 2e6,
            conductivity: Conductivity::constant(liquid),
            capacity: 1e4,
        };
        Material::thermal("metal", &Conductivity::constant(solid), 1e4, Some(&melting), 1000.0)
    };
    problem.materials = vec![
        melts(10.0, 330.0, 4.0),
        Material::diffusive("sand", 0.3, 1e3),
        melts(6.0, 335.0, 9.0),
    ];
    for particle in 0..problem.particles.len() {
        let position = problem.particles.position[particle];
        let in_block = position.max_element() < 0.35;
        problem.particles.material[particle] =
            if in_block { 1 } else { 2 * u16::from(position.x > 0.55) };
    }
    problem.held =
        (0..problem.particles.len() as u32).filter(|particle| particle % 41 == 7).collect();
    problem
}

/// Seams of it, where places are particles, and the states of their particles for some enthalpies.
fn seams_and_locals(problem: &Problem, on_sites: bool) -> (Seams, Locals) {
    let place: Vec<u32> = (0..problem.particles.len() as u32).collect();
    let seams = Seams::of(problem, &place, on_sites, |_| None).expect("materials meet");
    let locals = seams.locals(|row, place| seams.local(row, 250.0 + ((place * 37) % 400) as f64));
    (seams, locals)
}

#[test]
fn rows_are_grouped_by_material_and_ascend_in_each() {
    let problem = three();
    let (seams, _) = seams_and_locals(&problem, true);
    let mut end = 0;
    for SeamGroup { material, rows } in seams.groups() {
        assert!(rows.start == end && !rows.is_empty());
        end = rows.end;
        let places = &seams.places()[rows.clone()];
        assert!(places.windows(2).all(|two| two[0] < two[1]));
        let of = |place: &u32| problem.particles.material[*place as usize];
        assert!(places.iter().all(|place| of(place) == *material));
    }
    assert_eq!((end, seams.groups().len()), (seams.places().len(), 3));
}

#[test]
fn what_is_added_is_the_flow_of_heat_without_that_of_potentials() {
    let mut problem = three();
    let choices = PairMean::ALL.into_iter().flat_map(|mean| [(mean, true), (mean, false)]);
    for (pair_mean, on_sites) in choices {
        problem.pair_mean = pair_mean;
        // With the arithmetic mean round an axis too.
        problem.domain.periodic = [false, pair_mean == PairMean::Arithmetic, false];
        let problem = &problem;
        let (seams, locals) = seams_and_locals(problem, on_sites);
        let row_of: HashMap<u32, usize> =
            seams.places().iter().enumerate().map(|(row, &place)| (place, row)).collect();
        let mean = |a: f64, b: f64| problem.pair_mean.of(a, b);
        let reference = |m: u16| problem.materials[usize::from(m)].conductivity;
        let (mut expected, mut given) = (HashMap::new(), 0.0);
        for (row, Seam { place, material, pairs }) in seams.rows().enumerate() {
            let mut rate = 0.0;
            for (other, other_material, [weight, _]) in pairs {
                assert_ne!(material, other_material);
                let other = row_of[&other];
                let conductivity = |row: usize| match pair_mean {
                    PairMean::Harmonic => 1.0 / locals.terms[row],
                    PairMean::Arithmetic => locals.terms[row],
                };
                let ratio = mean(conductivity(row), conductivity(other))
                    / mean(reference(material), reference(other_material));
                let by_heat = ratio * (locals.temperatures[other] - locals.temperatures[row]);
                rate += weight * (by_heat - (locals.potentials[other] - locals.potentials[row]));
            }
            match problem.is_held(place as usize) {
                true => given -= problem.capacity(place as usize) * rate,
                false => assert!(expected.insert(place as usize, (row, rate)).is_none()),
            }
        }
        let largest =
            expected.values().fold(0.0, |largest: f64, (_, rate)| largest.max(rate.abs()));
        assert!(largest > 1.0, "something flows: {largest}");
        // All at once, and so that several of one kind are cut apart.
        for task in [usize::MAX, 7, 5, 1] {
            let (mut found, mut given_here) = (0, 0.0);
            for group in seams.groups() {
                let mut rows = group.rows.clone();
                while !rows.is_empty() {
                    let end = rows.end.min(rows.start.saturating_add(task));
                    given_here += seams.add(rows.start..end, &locals, |place, potential, rate| {
                        let (row, expected) = expected[&place];
                        assert!((rate - expected).abs() < 1e-11 * largest, "{place}");
                        assert_eq!(potential, locals.potentials[row]);
                        found += 1;
                    });
                    rows.start = end;
                }
            }
            assert_eq!(found, expected.len());
            assert!((given_here - given).abs() < 1e-9 * given.abs());
        }
    }
}

#[test]
fn rows_along_a_plane_of_a_lattice_are_of_few_kinds() {
    let mut problem = three();
    for material in &mut problem.particles.material {
        *material &= 2;
    }
    problem.held.clear();
    let (seams, _) = seams_and_locals(&problem, true);
    // At most five along each axis, near the ends and between them, in two layers on either side.
    assert_eq!(seams.rows.len(), 12 * 10 * 4);
    assert!(seams.kinds.len() <= 5 * 5 * 4, "{}", seams.kinds.len());
}
