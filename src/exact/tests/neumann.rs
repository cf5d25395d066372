use super::*;

const SOLID: Phase = Phase { conductivity: 0.6, capacity: 2.0 };
const LIQUID: Phase = Phase { conductivity: 0.5, capacity: 1.0 };

/// Melts at 1.
fn setup(wall: f64, initial: f64) -> NeumannSetup {
    NeumannSetup {
        axis: 1,
        at: 0.2,
        above: true,
        initial,
        wall,
        melting: 1.0,
        latent_heat: 2.0,
        solid: SOLID,
        liquid: LIQUID,
    }
}

/// Melting and freezing, of two phases and of one, and one phase far slower than the other.
fn setups() -> [NeumannSetup; 6] {
    let slow = NeumannSetup { latent_heat: 30.0, ..setup(1.2, 0.9) };
    let fast = NeumannSetup { latent_heat: 0.1, ..setup(9.0, 0.5) };
    [setup(3.0, 0.4), setup(-2.0, 1.7), setup(3.0, 1.0), setup(-2.0, 1.0), slow, fast]
}

fn at(depth: f64) -> DVec3 {
    DVec3::new(0.4, 0.2 + depth, -0.3)
}

/// The phase next to the wall, then the other.
fn phases(setup: &NeumannSetup) -> [Phase; 2] {
    if setup.wall > setup.melting {
        [setup.liquid, setup.solid]
    } else {
        [setup.solid, setup.liquid]
    }
}

/// Gold, with latent heat in J/kg.
fn gold(latent_heat: f64) -> Neumann {
    let capacity = 19_300.0 * 129.0;
    Neumann::new(NeumannSetup {
        axis: 0,
        at: 0.0,
        above: true,
        initial: 300.0,
        wall: 500.0,
        melting: 400.0,
        latent_heat: 19_300.0 * latent_heat,
        solid: Phase { conductivity: 1.28e-4 * capacity, capacity },
        liquid: Phase { conductivity: 1.1e-4 * capacity, capacity },
    })
}

/// dT/dz on the side of the front that `step` (m) leads to, one-sided and of fourth order.
fn slope(neumann: &Neumann, t: f64, step: f64) -> f64 {
    let front = neumann.front(t);
    let value = |n: f64| match n {
        0.0 => 1.0,
        _ => neumann.at(at(front + n * step), t),
    };
    let sum = -25.0 * value(0.0) + 48.0 * value(1.0) - 36.0 * value(2.0) + 16.0 * value(3.0)
        - 3.0 * value(4.0);
    sum / (12.0 * step)
}

#[test]
fn known_values() {
    let neumann = gold(63.7e3);
    close(neumann.lambda(), 0.243_463_771_4, 5.1e-11);
    close(neumann.front(15.0), 0.019_779_090_3, 5.1e-11);
    for (x, expected) in [(0.01, 448.699922), (0.03, 383.819284), (0.06, 344.413992)] {
        close(neumann.at(DVec3::X * x, 15.0), expected, 5.1e-7);
    }
    close(gold(6.37e3).front(15.0), 0.033_218_638_4, 5.1e-11);
    close(gold(630e3).front(15.0), 0.007_657_629_5, 5.1e-11);
}

#[test]
fn each_phase_satisfies_its_equation() {
    for setup in setups() {
        let (phases, two) = (phases(&setup), setup.initial != setup.melting);
        let neumann = Neumann::new(setup);
        for t in [0.2, 1.0, 9.0] {
            let points = |shares: &[f64]| -> Vec<DVec3> {
                shares.iter().map(|share| at(share * neumann.front(t))).collect()
            };
            let near = (points(&[0.3, 0.5, 0.85]), phases[0].diffusivity());
            let far = (points(&[1.2, 1.4, 2.0]), phases[1].diffusivity());
            let solution = Solution::Neumann(neumann.clone());
            for (points, diffusivity) in [near, far].iter().take(1 + usize::from(two)) {
                let check = |d: f64| residual(&solution, 2, d, points, (t, 1e-2 * t));
                let found = check(*diffusivity);
                assert!(found < 1e-5, "{neumann:?} t = {t}: {found}");
                assert!(check(1.1 * diffusivity) > 1e-2, "{neumann:?} t = {t}");
            }
        }
    }
}

/// The latent heat that the front takes a second is what flows to it less what flows on.
#[test]
fn energy_balances_at_the_front() {
    for setup in setups() {
        let [near, far] = phases(&setup);
        let sign = (setup.wall - setup.melting).signum();
        let latent_heat = setup.latent_heat;
        let neumann = Neumann::new(setup);
        for t in [0.2, 1.0, 9.0] {
            let front = neumann.front(t);
            let speed = (neumann.front(1.001 * t) - neumann.front(0.999 * t)) / (0.002 * t);
            let arrives = -near.conductivity * slope(&neumann, t, -1e-3 * front);
            let leaves = -far.conductivity * slope(&neumann, t, 1e-3 * front);
            let taken = sign * latent_heat * speed;
            close((arrives - leaves) / taken, 1.0, 1e-6);
            // Negative controls: the latent heat counted twice, the far phase forgotten.
            assert!(((arrives - leaves) / (2.0 * taken) - 1.0).abs() > 0.4);
            if !neumann.is_one_phase() {
                assert!((arrives / taken - 1.0).abs() > 1e-2, "{neumann:?} t = {t}");
            }
        }
    }
}

/// What came through the wall, twice t times its flux at t, is what the body holds.
#[test]
fn all_energy_comes_through_the_wall() {
    for setup in setups() {
        let [near, far] = phases(&setup);
        let sign = (setup.wall - setup.melting).signum();
        let to_melt = far.capacity * (setup.melting - setup.initial) + sign * setup.latent_heat;
        let (wall, melting, initial) = (setup.wall, setup.melting, setup.initial);
        let neumann = Neumann::new(setup);
        let t = 0.7;
        let (front, step) = (neumann.front(t), 1e-3 * neumann.front(t));
        let rise = |z: f64| neumann.at(at(z), t);
        let flux = near.conductivity * (8.0 * (wall - rise(step)) - (wall - rise(2.0 * step)))
            / (6.0 * step);
        let end = front + 16.0 * (far.diffusivity() * t).sqrt();
        let tail = |u: f64| {
            let z = front + u * u;
            let value = if u == 0.0 { melting } else { rise(z) };
            far.capacity * (value - initial) * 2.0 * u
        };
        let held = to_melt * front
            + integral(|z| near.capacity * (rise(z) - melting), 0.0, front)
            + integral(tail, 0.0, (end - front).sqrt());
        close(held / (2.0 * t * flux), 1.0, 1e-5);
    }
}

/// Stefan's equation sqrt(pi) lambda exp(lambda^2) erf(lambda) = c (Tw - Tm) / L, solved with 60
/// digits.
#[test]
fn one_phase_is_stefans_solution() {
    for (number, expected) in [
        (0.1, 0.220_016_272_742_937_9),
        (1.0, 0.620_062_633_313_595_5),
        (5.0, 1.059_687_014_281_902_4),
    ] {
        for (wall, phase) in [(3.0, LIQUID), (-1.0, SOLID)] {
            let latent_heat = 2.0 * phase.capacity / number;
            let stefan = |solid: Phase, liquid: Phase| {
                Neumann::new(NeumannSetup { latent_heat, solid, liquid, ..setup(wall, 1.0) })
            };
            let one = stefan(SOLID, LIQUID);
            assert!(one.is_one_phase());
            close(one.lambda(), expected, 4e-16);
            // The other phase does not matter, however slow or fast.
            for (conductivity, capacity) in [(1e-30, 1e30), (1e30, 1e-30)] {
                let other = Phase { conductivity, capacity };
                let (solid, liquid) = if wall > 1.0 { (other, phase) } else { (phase, other) };
                let same = stefan(solid, liquid);
                assert_eq!(same.lambda(), one.lambda());
                for share in [1.0 + 1e-12, 1.1, 3.0, 1e9] {
                    assert_eq!(same.at(at(share * same.front(0.3)), 0.3), 1.0);
                }
                let inside = at(0.4 * same.front(0.3));
                assert_eq!(same.at(inside, 0.3), one.at(inside, 0.3));
            }
            // It is the limit of two phases.
            let cold = if wall > 1.0 { 1.0 - 1e-9 } else { 1.0 + 1e-9 };
            let two = Neumann::new(NeumannSetup { latent_heat, ..setup(wall, cold) });
            assert!(!two.is_one_phase() && two.lambda() < one.lambda());
            close(two.lambda(), one.lambda(), 1e-8);
        }
    }
    // Slow fronts: lambda^2 = c (Tw - Tm) / (2 L).
    let slow = Neumann::new(NeumannSetup { latent_heat: 2e8, ..setup(3.0, 1.0) });
    close(slow.lambda() / 0.5e-8f64.sqrt(), 1.0, 1e-8);
    let names = [setup(3.0, 1.0), setup(3.0, 0.9)].map(Neumann::new).map(Solution::Neumann);
    assert_eq!(names.map(|solution| solution.name()), ["stefan", "neumann"]);
}

#[test]
fn without_latent_heat_it_is_a_half_space() {
    let neumann =
        Neumann::new(NeumannSetup { latent_heat: 1e-13, solid: LIQUID, ..setup(3.0, 0.4) });
    let surface = Side::Value(3.0);
    let plain = HalfSpace { axis: 1, from: 0.2, surface, initial: 0.4, diffusivity: 0.5 };
    for depth in [0.05, 0.3, 1.0, 2.0, 20.0] {
        close(neumann.at(at(depth), 0.6), plain.at(at(depth), 0.6), 1e-12);
    }
}

#[test]
fn freezing_is_melting_upside_down() {
    let melting = Neumann::new(setup(3.0, 0.4));
    let freezing = Neumann::new(NeumannSetup { solid: LIQUID, liquid: SOLID, ..setup(-1.0, 1.6) });
    let below = Neumann::new(NeumannSetup { above: false, ..setup(3.0, 0.4) });
    assert_eq!(melting.lambda(), freezing.lambda());
    // Negative control: the phases matter.
    assert!((Neumann::new(setup(-1.0, 1.6)).lambda() - melting.lambda()).abs() > 1e-2);
    for depth in [0.05, 0.3, 1.0, 2.0] {
        let expected = melting.at(at(depth), 0.6);
        close(2.0 - freezing.at(at(depth), 0.6), expected, 1e-14);
        close(below.at(at(-depth), 0.6), expected, 1e-15);
        assert_eq!(below.at(at(depth), 0.6), 3.0);
    }
}

#[test]
fn ends_of_time_and_space() {
    for setup in setups() {
        let (wall, initial) = (setup.wall, setup.initial);
        let neumann = Neumann::new(setup);
        assert_eq!([-1.0, 0.0].map(|t| neumann.front(t)), [0.0; 2]);
        for t in [-1.0, 0.0, 1e-300, 0.4, 1e200] {
            assert_eq!(neumann.at(at(0.0), t), wall);
            assert_eq!(neumann.at(at(-0.1), t), wall);
            assert!(neumann.at(at(0.1), t).is_finite());
        }
        assert_eq!([-1.0, 0.0, 1e-300].map(|t| neumann.at(at(0.5), t)), [initial; 3]);
        close(neumann.at(at(0.5), 1e30), wall, 1e-12);
        let front = neumann.front(0.4);
        close(neumann.at(at(front * (1.0 - 1e-12)), 0.4), 1.0, 1e-10);
        close(neumann.at(at(front * (1.0 + 1e-12)), 0.4), 1.0, 1e-10);
        close(neumann.front(1.6) / front, 2.0, 1e-15);
    }
    // A far phase so slow that erfc underflows at the front.
    let solid = Phase { conductivity: 1e-6, capacity: 1e3 };
    let slow = Neumann::new(NeumannSetup { solid, ..setup(3.0, 0.4) });
    close(slow.at(at(slow.front(1.0) + 1e-11), 1.0), 1.0, 1e-2);
    assert_eq!(slow.at(at(slow.front(1.0) + 0.1), 1.0), 0.4);
    // What such a phase takes up to melt counts as latent heat.
    let latent_heat = 2.0 + 1e3 * 0.6;
    let heavier = Neumann::new(NeumannSetup { latent_heat, ..setup(3.0, 1.0) });
    close(slow.lambda() / heavier.lambda(), 1.0, 1e-6);
}

/// The phase changes across the front, also where the temperature beyond it is the melting point.
#[test]
fn the_phase_changes_across_the_front_alone() {
    for setup in setups() {
        let melts = setup.wall > setup.melting;
        let neumann = Neumann::new(setup);
        let t = 2.0;
        let front = neumann.front(t);
        for share in [-0.1, 0.0, 0.5, 0.999] {
            assert_eq!(neumann.is_liquid(at(share * front), t), melts, "{neumann:?} {share}");
        }
        for share in [1.001, 2.0, 50.0] {
            assert_eq!(neumann.is_liquid(at(share * front), t), !melts, "{neumann:?} {share}");
        }
        assert_eq!(neumann.is_liquid(at(0.5 * front), 0.0), !melts, "before it starts");
    }
}
