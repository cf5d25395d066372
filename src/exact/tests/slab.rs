use super::super::modes::SHORT;
use super::*;

const SIDES: [Side; 6] = [
    Side::Value(3.0),
    Side::Flux(0.7),
    Side::INSULATED,
    Side::Convection { coefficient: 0.9, ambient: -2.0 },
    Side::Convection { coefficient: 1e-3, ambient: 40.0 },
    Side::Convection { coefficient: 400.0, ambient: 2.5 },
];

fn slab(left: Side, right: Side) -> Slab {
    Slab::new(SlabSetup {
        axis: 1,
        from: 0.2,
        to: 1.1,
        left,
        right,
        initial: 1.0,
        diffusivity: 0.3,
    })
}

fn at(place: f64) -> DVec3 {
    DVec3::new(0.4, 0.2 + 0.9 * place, -0.3)
}

/// Every combination but two insulated faces, where nothing happens.
fn combinations() -> impl Iterator<Item = [Side; 2]> {
    let all = SIDES.into_iter().flat_map(|left| SIDES.map(|right| [left, right]));
    all.filter(|sides| *sides != [Side::INSULATED; 2])
}

fn rod() -> Slab {
    Slab::new(SlabSetup {
        axis: 0,
        from: 0.0,
        to: 0.1,
        left: Side::Value(500.0),
        right: Side::Value(300.0),
        initial: 300.0,
        diffusivity: 1.28e-4,
    })
}

#[test]
fn every_combination_satisfies_the_equation() {
    let points = [0.03, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97].map(at);
    for [left, right] in combinations() {
        let solution = Solution::Slab(slab(left, right));
        for t in [0.01, 0.02, 0.11, 0.9] {
            let found = residual(&solution, 2, 0.3, &points, (t, 1e-2 * t));
            assert!(found < 1e-5, "{left:?} {right:?} t = {t}: {found}");
            let wrong = residual(&solution, 2, 0.33, &points, (t, 1e-2 * t));
            assert!(wrong > 1e-2, "{left:?} {right:?} t = {t}: {wrong}");
        }
    }
}

#[test]
fn every_combination_satisfies_its_conditions() {
    for sides in combinations() {
        let solution = Solution::Slab(slab(sides[0], sides[1]));
        for t in [0.01, 0.02, 0.11, 0.9, 20.0] {
            for (side, place, out) in [(sides[0], 0.0, -DVec3::Y), (sides[1], 1.0, DVec3::Y)] {
                let scale = side_scale(side);
                let found = broken(&solution, side, 0.3, (at(place), out), t);
                assert!(found < 1e-8 * scale, "{sides:?} {place} t = {t}: {found}");
            }
        }
    }
    // Negative control: a coefficient 1% off.
    let solution = Solution::Slab(slab(SIDES[3], SIDES[1]));
    let other = Side::Convection { coefficient: 0.909, ambient: -2.0 };
    assert!(broken(&solution, other, 0.3, (at(0.0), -DVec3::Y), 0.11) > 1e-3);
}

#[test]
fn the_two_forms_agree() {
    for [left, right] in combinations() {
        let slab = slab(left, right);
        for time in [0.9 * SHORT, SHORT] {
            for place in [0.0, 0.01, 0.1, 0.5, 0.93, 1.0] {
                let (short, long) = (slab.half_spaces(place, time), slab.waves(place, time));
                let difference = (short - long).abs();
                assert!(difference < 1e-12, "{left:?} {right:?} {place}: {short} {long}");
            }
        }
    }
    for place in [0.1, 0.5, 0.93] {
        let (short, long) = (rod().half_spaces(place, SHORT), rod().waves(place, SHORT));
        close(short / 200.0, long / 200.0, 1e-13);
    }
}

#[test]
fn given_fluxes_are_taken_up() {
    for (left, right, inflow) in [
        (Side::Flux(0.7), Side::INSULATED, 0.7),
        (Side::INSULATED, Side::Flux(-0.4), -0.4),
        (Side::Flux(0.7), Side::Flux(-0.4), 0.3),
        (Side::Flux(0.7), Side::Convection { coefficient: 0.0, ambient: 9.0 }, 0.7),
    ] {
        let slab = slab(left, right);
        for t in [0.002, 0.02, 0.7, 30.0] {
            let taken = 0.9 * integral(|place| slab.at(at(place), t) - 1.0, 0.0, 1.0);
            close(taken / (inflow * t), 1.0, 1e-9);
        }
    }
}

#[test]
fn a_mirror_is_an_insulated_face() {
    for side in SIDES.into_iter().filter(|side| *side != Side::INSULATED) {
        let half = slab(side, Side::INSULATED);
        let whole = Slab::new(SlabSetup {
            axis: 1,
            from: 0.2,
            to: 2.0,
            left: side,
            right: side,
            initial: 1.0,
            diffusivity: 0.3,
        });
        for t in [0.004, 0.03, 0.4, 3.0] {
            for place in [0.0, 0.2, 0.7, 1.0, 1.6] {
                let mirrored = if place > 1.0 { 2.0 - place } else { place };
                close(half.at(at(mirrored), t), whole.at(at(place), t), 2e-12);
            }
        }
    }
}

/// First roots and amplitudes of a wall that loses through both faces (Incropera and DeWitt 2002,
/// table 5.1), half of which is a wall with one face insulated.
#[test]
fn first_waves_of_the_tables() {
    for (biot, root, amplitude) in
        [(0.1, 0.3111, 1.0161), (1.0, 0.8603, 1.1191), (10.0, 1.4289, 1.2620)]
    {
        let right = Side::Convection { coefficient: biot * 0.3 / 0.9, ambient: 0.0 };
        let mode = &slab(Side::INSULATED, right).modes[0];
        close(mode.root, root, 5.1e-5);
        close(mode.amplitude, amplitude, 5.1e-5);
        assert_eq!(mode.phase, 0.0);
        close(mode.root * mode.root.tan() / biot, 1.0, 1e-13);
    }
}

#[test]
fn known_values() {
    for (x, expected) in [(0.01, 431.7062733), (0.02, 375.3518236), (0.05, 305.4250772)] {
        close(rod().at(DVec3::splat(x), 2.0), expected, 5e-8);
    }
}

#[test]
fn ends_of_time_and_space() {
    for t in [0.0, 0.1, 2.0, 1e6] {
        assert_eq!(rod().at(DVec3::ZERO, t), 500.0);
        assert_eq!(rod().at(DVec3::splat(0.1), t), 300.0);
        assert_eq!(rod().at(DVec3::splat(0.2), t), 300.0);
    }
    assert_eq!(rod().at(DVec3::splat(0.05), 0.0), 300.0);
    assert_eq!(rod().at(DVec3::splat(0.05), 1e-9), 300.0);
    close(rod().at(DVec3::splat(0.025), 1e6), 450.0, 1e-12);
    for [left, right] in combinations() {
        let slab = slab(left, right);
        assert_eq!(slab.at(at(0.0), 0.0), left.held().unwrap_or(1.0));
        assert_eq!(slab.at(at(1.0), 0.0), right.held().unwrap_or(1.0));
        for place in [0.1, 0.5, 0.9] {
            assert_eq!(slab.at(at(place), 0.0), 1.0);
            close(slab.at(at(place), 1e-5), 1.0, 1e-12);
        }
        assert_eq!(slab.at(at(-3.0), 0.2), slab.at(at(0.0), 0.2));
        assert_eq!(slab.at(at(1.3), 0.2), slab.at(at(1.0), 0.2));
    }
    let still = slab(Side::INSULATED, Side::INSULATED);
    assert_eq!([0.001, 7.0].map(|t| still.at(at(0.3), t)), [1.0; 2]);
}
