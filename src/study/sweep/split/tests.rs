use super::*;
use crate::case::{self, Override};

fn scene(set: &[&str]) -> Scene {
    let overrides: Vec<Override> =
        set.iter().map(|text| Override::parse(text).expect("an override")).collect();
    case::load("gaussian", &overrides).expect("a case")
}

/// The parts at the centre, with what the run is said to have read there.
fn parts(space: &Space, value: f64) -> Vec<(String, f64)> {
    let probe = ProbeReport {
        name: "centre".to_owned(),
        at: vec![25.25; 3],
        time: 0.0,
        value,
        exact: None,
    };
    let split = space.with(&[probe]);
    split.probes[0].parts.iter().map(|part| (part.name.clone(), part.value)).collect()
}

/// The same, each over the value before it.
fn relative_parts(space: &Space, value: f64) -> Vec<(String, f64)> {
    let mut before = SOURCE;
    let relative = |(name, value): (String, f64)| {
        let part = value / before;
        before += value;
        (name, part)
    };
    parts(space, value).into_iter().map(relative).collect()
}

fn part(parts: &[(String, f64)], name: &str) -> f64 {
    parts.iter().find(|part| part.0 == name).expect(name).1
}

/// The value at the centre of the report's case after 2160 steps, plain and corrected, and of the
/// same exact in time; the exact ones of a point source and of eight masses.
const PLAIN: f64 = 0.1324156431;
const PLAIN_IN_TIME: f64 = 0.1325305094;
const CORRECTED: f64 = 0.1364146245;
const CORRECTED_IN_TIME: f64 = 0.1365329579;
const SOURCE: f64 = 0.136_403_26;
const MASSES: f64 = 0.136_190_51;

#[test]
fn the_gap_at_the_centre_of_the_report_is_that_of_deff() {
    let plain = scene(&[]);
    let space = Space::of(&plain).expect("a split");
    assert!((space.probes[0].semi_discrete - PLAIN_IN_TIME).abs() < 1e-9);
    assert!((space.probes[0].exact - SOURCE).abs() < 1e-8);
    let found = parts(&space, PLAIN);
    assert!((part(&found, "source extent") - (MASSES - SOURCE)).abs() < 2e-8);
    let sum: f64 = found.iter().map(|part| part.1).sum();
    assert!((sum - (PLAIN - SOURCE)).abs() < 1e-8, "they add up");
    let relative = relative_parts(&space, PLAIN);
    let percent = |name: &str| (1e4 * part(&relative, name)).round() / 100.0;
    let names = ["source extent", "Deff", "dispersion", "step"];
    assert_eq!(names.map(percent), [-0.16, -2.93, 0.25, -0.09]);
    assert!(part(&found, "interpolation").abs() < 1e-12, "the probe is at a particle");
    assert_eq!(space.remarks.len(), 1, "the edges are free: {:?}", space.remarks);

    // A kernel whose weights are 1 % off has another Deff, which the split must not hide.
    let mut wrong = LatticeScene::of(&plain.problem).expect("a lattice");
    wrong.classes.iter_mut().flat_map(|of| &mut of.weights).for_each(|weight| *weight *= 1.01);
    let exact = plain.exact.as_ref().expect("it has one");
    let wrong = Space::on(&plain, &wrong, exact).expect("a split");
    assert!((wrong.probes[0].semi_discrete / PLAIN_IN_TIME - 1.0).abs() > 0.01);
    let found = parts(&wrong, PLAIN);
    let step = part(&found, "step") / SOURCE;
    assert!(step > 0.01, "it is then the steps that do not fit: {step}");
}

#[test]
fn the_correction_leaves_no_part_to_deff() {
    let space = Space::of(&scene(&["operator.correction=moment"])).expect("a split");
    assert!((space.probes[0].semi_discrete - CORRECTED_IN_TIME).abs() < 1e-9);
    let found = parts(&space, CORRECTED);
    assert!(part(&found, "Deff").abs() < 1e-14, "{found:?}");
    assert!((part(&found, "step") - (CORRECTED - CORRECTED_IN_TIME)).abs() < 1e-9);
    let norm = space.l2_relative.expect("there is one");
    assert!(norm > 1e-4 && norm < 2e-3, "{norm}");
}

#[test]
fn a_probe_between_particles_has_a_part_for_interpolation() {
    let set = ["particles.spacing=1", "time.step=116800"];
    let space = Space::of(&scene(&set)).expect("a split");
    let found = parts(&space, 0.13);
    assert!(part(&found, "interpolation").abs() > 1e-6, "{found:?}");
    let sum: f64 = found.iter().map(|part| part.1).sum();
    assert!((sum - (0.13 - SOURCE)).abs() < 1e-8, "they add up");
}

#[test]
fn scenes_without_known_modes_say_why() {
    for (case, why) in [
        ("constant_column", "holds the values"),
        ("flux_plate", "imposes something"),
        ("sphere_cooling", "do not fill the box"),
        ("density", "no time passes"),
    ] {
        let scene = case::load(case, &[]).expect("a case");
        let found = Space::of(&scene).err().unwrap_or_default();
        assert!(found.contains(why), "{case}: {found}");
    }
    let source = "sources=[{\"rate\":1e-9}]";
    let fed = scene(&["particles.spacing=1", "time.step=116800", "exact=null", source]);
    assert!(Space::of(&fed).err().is_some_and(|why| why.contains("a source of the case")));
}
