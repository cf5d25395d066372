//! Cases that must be read, and what they must become.

use glam::DVec3;
use serde_json::json;

use super::{base, with};
use crate::case::{OutputField, Override, from_json, from_text, load};
use crate::exact::Solution;
use crate::model::{Correction, PairMean, StepChoice};

#[test]
fn the_base_case_is_what_it_says() {
    let scene = with(&[]).expect("good");
    let problem = &scene.problem;
    assert_eq!(problem.particles.len(), 32);
    assert_eq!(problem.particles.position[1], DVec3::new(0.75, 0.25, 0.0));
    assert_eq!(problem.particles.position[8], DVec3::new(0.25, 0.75, 0.0));
    assert_eq!(problem.particles.volume[0], 0.25);
    assert_eq!(problem.held, [0, 8, 16, 24]);
    assert_eq!((problem.initial[8], problem.initial[9]), (3.0, 1.0));
    assert_eq!(problem.domain.max, DVec3::new(4.0, 2.0, 0.0));
    assert_eq!(problem.kernel.support_radius(), 1.0);
    assert_eq!(problem.materials[0].conductivity, 15.0 / 31_536_000.0);
    assert_eq!(problem.materials[0].density, 1000.0);
    assert_eq!(problem.pair_mean, PairMean::Harmonic);
    assert_eq!(problem.correction, Correction::Moment);
    assert_eq!(problem.time.end, 172_800.0);
    assert_eq!(problem.time.step, StepChoice::Automatic);
    assert_eq!((problem.time.output_every, problem.time.probe_every), (172_800.0, 172_800.0));
    assert_eq!(scene.fields, [OutputField::Value, OutputField::Exact, OutputField::Error]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn later_values_win_and_amounts_add() {
    let right = r#"{"half_space":{"point":[2,0],"normal":[-1,0]}}"#;
    let scene = with(&[
        &format!(
            r#"initial=[{{"value":"x+10*y"}},{{"value":7,"where":{right}}},
                {{"amount":4,"at":[3,1]}},{{"amount":"-1","at":[3,1]}}]"#
        ),
        "boundaries=[]",
    ])
    .expect("good");
    let initial = &scene.problem.initial;
    assert_eq!(initial[8], 0.25 + 7.5);
    assert_eq!(initial[15], 7.0);
    // Four particles of 0.25 m2 share 4 - 1.
    let near = |x: DVec3| x.distance(DVec3::new(3.0, 1.0, 0.0)) < 0.4;
    for (&x, &value) in scene.problem.particles.position.iter().zip(initial) {
        if x.x > 2.0 {
            assert_eq!(value, if near(x) { 10.0 } else { 7.0 }, "{x}");
        }
    }
    let total: f64 = initial.iter().sum::<f64>() * 0.25;
    let without = with(&[
        &format!(r#"initial=[{{"value":"x+10*y"}},{{"value":7,"where":{right}}}]"#),
        "boundaries=[]",
    ]);
    let before: f64 = without.expect("good").problem.initial.iter().sum::<f64>() * 0.25;
    assert!((total - before - 3.0).abs() < 1e-12);
}

#[test]
fn a_deposit_wraps_around_periodic_axes() {
    let scene = with(&[
        r#"boundaries=[{"periodic":{"axes":["x","y"]}}]"#,
        r#"initial=[{"amount":1,"at":[0,0]}]"#,
    ]);
    let initial = scene.expect("good").problem.initial;
    let given: Vec<usize> = (0..32).filter(|&a| initial[a] != 0.0).collect();
    assert_eq!(given, [0, 7, 24, 31]);
    assert_eq!(initial[7], 1.0);
}

#[test]
fn fills_share_one_lattice() {
    let disk = json!({ "sphere": { "center": [2, 1], "radius": 0.8 } });
    let mut case = base();
    case["materials"]["iron"] = json!({ "diffusivity": 1, "density": 7000 });
    case["particles"]["fill"] = json!([
        { "shape": { "difference": { "of": { "box": { "min": [0, 0], "max": [4, 2] } },
            "minus": [disk] } }, "material": "rock" },
        { "shape": disk, "material": "iron" }
    ]);
    let problem = from_json("two", case, &[]).expect("good").problem;
    assert_eq!(problem.particles.len(), 32);
    assert_eq!(problem.materials[0].name, "iron");
    let iron = problem.particles.material.iter().filter(|&&material| material == 0).count();
    assert_eq!(iron, 12);
    assert!(problem.particles.material.ends_with(&[0; 12]));
    // Disk and rest fill the box's lattice: the positions are the same set.
    let mut found: Vec<[f64; 3]> =
        problem.particles.position.iter().map(|x| [x.y, x.x, 0.0]).collect();
    found.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    let plain = with(&[]).expect("good").problem.particles.position;
    assert_eq!(found, plain.iter().map(|x| [x.y, x.x, 0.0]).collect::<Vec<_>>());
}

#[test]
fn exact_solutions_take_their_parameters_from_the_scene() {
    let deposit = r#"initial=[{"amount":5,"at":[2,1]}]"#;
    let exact = |name: &str| {
        let exact = format!(r#"exact={{"name":"{name}"}}"#);
        with(&[deposit, "boundaries=[]", &exact]).expect(name).exact.expect(name)
    };
    let Solution::MassesInBox(masses) = exact("masses_in_box") else { panic!("another one") };
    assert_eq!((masses.amount, masses.separation), (5.0, 0.5));
    assert_eq!(masses.at, DVec3::new(2.0, 1.0, 0.0));
    assert_eq!(masses.walls.max, DVec3::new(4.0, 2.0, 0.0));
    assert_eq!(masses.walls.diffusivity, 15.0 / 31_536_000.0);
    assert_eq!((masses.walls.dimension, exact("point_source").name()), (2, "point_source"));
    assert_eq!(exact("point_source_in_box").name(), "point_source_in_box");
    for json in [
        r#"{"name":"slab","axis":"y","left":{"value":1},"right":{"flux":2},"initial":0}"#,
        r#"{"name":"half_space","axis":"x","surface":{"value":1},"initial":0,"from":"spacing/2"}"#,
        r#"{"name":"annulus","center":[0,0],"inner_radius":1,"outer_radius":2,
            "inner":1,"outer":"2*pi","initial":0}"#,
        r#"{"name":"oscillating_slab","axis":"x","mean":1,"amplitude":2,
            "angular_frequency":"2*pi/day","right":0,"initial":0}"#,
        r#"{"name":"affine","offset":1,"gradient":[1,2]}"#,
        r#"{"name":"expression","value":"300+10*sin(pi*x)*exp(-t)"}"#,
    ] {
        let scene = with(&[&format!("exact={json}")]).expect(json);
        let solution = scene.exact.expect(json);
        assert!(json.contains(&format!("\"{}\"", solution.name())));
        assert!(solution.at(DVec3::ONE, 5.0).is_finite());
    }
}

#[test]
fn the_sides_of_a_slab_are_what_the_walls_of_the_scene_do() {
    let exact = r#"exact={"name":"slab","axis":"x","initial":4}"#;
    let solution = |left: &str, right: &str| {
        let wall = |face, kind| format!(r#"{{"wall":{{"faces":["{face}"],"kind":{kind}}}}}"#);
        let walls = format!("boundaries=[{},{}]", wall("x_min", left), wall("x_max", right));
        with(&[&walls, exact]).map(|scene| scene.exact.expect("a slab"))
    };
    let at = |x: f64| DVec3::new(x, 1.0, 0.0);
    let held = solution(r#"{"value":7}"#, r#"{"value":9}"#).expect("good");
    assert_eq!((held.at(at(0.0), 1.0), held.at(at(4.0), 1.0)), (7.0, 9.0));
    let heated = solution(r#"{"flux":"1e-3"}"#, r#""insulated""#).expect("good");
    assert!(heated.at(at(0.0), 9.0) > 4.0 && heated.at(at(4.0), 9.0) == 4.0);
    let cooled =
        solution(r#"{"convection":{"coefficient":1,"ambient":2}}"#, r#""free""#).expect("good");
    assert!((2.0..4.0).contains(&cooled.at(at(0.0), 9.0)));
    let varies = solution(r#"{"value":"t"}"#, r#"{"value":9}"#).expect_err("it varies");
    let expected = "exact.left: missing key: the face x_min has a wall whose values vary";
    assert_eq!(varies.to_string(), expected);
}

#[test]
fn warnings_say_what_overrides_leave_unused() {
    let load = |texts: &[&str]| {
        let overrides: Vec<_> =
            texts.iter().map(|text| Override::parse(text).expect("override")).collect();
        let mut case = base();
        case["output"] = json!({ "fields": ["value", "error"], "probe_every": 60 });
        case["time"]["step"] = json!(60);
        from_json("base", case, &overrides)
    };
    let scene = load(&["exact=null", "probes=[]"]).expect("good");
    assert_eq!(scene.fields, [OutputField::Value]);
    assert_eq!(scene.warnings.len(), 2);
    assert!(scene.warnings[0].starts_with("output.fields: not used:"), "{:?}", scene.warnings);
    from_json("again", scene.resolved, &[]).expect("the resolved case has no unused key");
    let scene = load(&["time.end=0"]).expect("good");
    assert_eq!(scene.problem.time.step, StepChoice::Automatic);
    assert_eq!(scene.warnings.len(), 2);
    from_json("again", scene.resolved, &[]).expect("the resolved case has no unused key");
    // An override that itself has no use is an error.
    let error = load(&["probes=[]", "output.probe_every=5"]).expect_err("unused").to_string();
    assert!(error.starts_with("output.probe_every: not used:"), "{error}");
}

#[test]
fn odd_boxes_and_lost_deposits_are_warnings() {
    let warnings = |overrides: &[&str]| with(overrides).expect("good").warnings;
    let found = warnings(&["particles.fill.0.shape.box.max=[4.1,2]"]);
    assert!(found[0].starts_with("particles.fill[0].shape.box: its 4.1 m along x"), "{found:?}");
    let found = warnings(&[r#"initial=[{"amount":1,"at":[0.25,0.25]}]"#]);
    assert!(found[0].starts_with("initial[0]: the particle at [0.25, 0.25] is held"), "{found:?}");
}

#[test]
fn files_and_names() {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("mine.json");
    std::fs::write(&file, base().to_string()).expect("written");
    let scene = load(file.to_str().expect("utf-8"), &[]).expect("good");
    assert_eq!((scene.name.as_str(), scene.title.as_str()), ("mine", "base"));
    assert_eq!(load("density", &[]).expect("shipped").name, "density");
    let error = load("gausian", &[]).expect_err("no such case").to_string();
    assert!(error.contains("gausian: no such file") && error.contains("\"gaussian\""), "{error}");
    let error = load("./gaussian", &[]).expect_err("no such file").to_string();
    assert!(error.starts_with("./gaussian: "), "{error}");
    assert!(from_text("base", &base().to_string(), &[]).is_ok());
}

#[test]
fn a_million_particles_are_lean() {
    let scene = load("gaussian", &[]).expect("good");
    let particles = &scene.problem.particles;
    assert_eq!(particles.len(), 1_000_000);
    assert_eq!(particles.position.capacity(), 1_000_000);
    assert_eq!(particles.material.capacity(), 1_000_000);
}
