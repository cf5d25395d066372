use super::super::heated_slab::{brief, lasting};
use super::super::modes::SHORT;
use super::*;

const RATE: f64 = 0.8;

fn setup(rate: f64) -> HeatedSlabSetup {
    HeatedSlabSetup {
        axis: 1,
        from: 0.2,
        to: 1.1,
        left: 3.0,
        right: -1.0,
        initial: 1.0,
        rate,
        diffusivity: 0.3,
    }
}

fn at(place: f64) -> DVec3 {
    DVec3::new(0.4, 0.2 + 0.9 * place, -0.3)
}

/// C - rate t has no source left.
fn rest([left, right]: [f64; 2], rate: f64) -> Solution {
    let heated = HeatedSlab::new(HeatedSlabSetup { left, right, ..setup(RATE) });
    let rest = move |x: DVec3, t: f64| heated.at(x, t) - rate * t;
    Solution::Expression(ScalarField::new("the rest", rest))
}

#[test]
fn it_satisfies_the_equation_with_its_source() {
    let points = [0.03, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97].map(at);
    for t in [0.01, 0.02, 0.11, 0.9] {
        let check = |solution: &Solution, d| residual(solution, 2, d, &points, (t, 1e-2 * t));
        for faces in [[3.0, -1.0], [1.0, 1.0]] {
            let found = check(&rest(faces, RATE), 0.3);
            assert!(found < 1e-5, "{faces:?} t = {t}: {found}");
            assert!(check(&rest(faces, RATE), 0.33) > 1e-2, "{faces:?} t = {t}");
        }
        // Negative control: another source, where nothing but the source acts.
        assert!(check(&rest([1.0, 1.0], 1.2 * RATE), 0.3) > 1e-2, "t = {t}");
    }
}

#[test]
fn the_two_forms_agree() {
    for time in [0.9 * SHORT, SHORT] {
        for place in [0.01, 0.1, 0.3, 0.5, 0.93] {
            close(brief(place, time), lasting(place, time), 1e-15);
        }
    }
    // The middle warms as if there were no face.
    close(brief(0.5, 0.1 * SHORT), 0.1 * SHORT, 1e-18);
}

#[test]
fn without_a_source_it_is_the_slab() {
    let HeatedSlabSetup { axis, from, to, left, right, initial, diffusivity, .. } = setup(0.0);
    let (left, right) = (Side::Value(left), Side::Value(right));
    let slab = Slab::new(SlabSetup { axis, from, to, left, right, initial, diffusivity });
    for t in [-1.0, 0.0, 0.003, 0.4, 70.0] {
        for place in [-0.2, 0.0, 0.1, 0.5, 1.0, 1.4] {
            assert_eq!(HeatedSlab::new(setup(0.0)).at(at(place), t), slab.at(at(place), t));
        }
    }
}

#[test]
fn ends_of_time_and_space() {
    let heated = HeatedSlab::new(setup(RATE));
    for t in [0.0, 0.002, 0.4, 1e6] {
        assert_eq!([-0.2, 0.0].map(|place| heated.at(at(place), t)), [3.0; 2]);
        assert_eq!([1.0 + 1e-15, 1.3].map(|place| heated.at(at(place), t)), [-1.0; 2]);
        // Continuous at the faces.
        let near = if t > 0.0 { 1e-10 } else { 9.0 };
        close(heated.at(at(1e-13), t), 3.0, near);
        close(heated.at(at(1.0 - 1e-13), t), -1.0, near);
    }
    assert_eq!([-1.0, 0.0, 1e-320].map(|t| heated.at(at(0.4), t)), [1.0; 3]);
    close(heated.at(at(0.5), 2e-4), 1.0 + RATE * 2e-4, 1e-15);
    // In the end the line between the faces and rate / (2 D) times the product of the distances.
    for place in [0.1f64, 0.25, 0.5, 0.9] {
        let parabola = RATE / 0.6 * 0.81 * place * (1.0 - place);
        close(heated.at(at(place), 1e6), 3.0 - 4.0 * place + parabola, 1e-14);
    }
    assert!(Solution::HeatedSlab(heated).allows_sources());
}
