//! Cases that must be refused, with a message that starts with the path.

use serde_json::json;

use super::{base, with};
use crate::case::{from_json, from_text};

/// Overrides of the base case, and how the message must start.
const BAD: &[(&[&str], &str)] = &[
    // Keys.
    (
        &["materials.rock.diffusivty=1"],
        "materials.rock.diffusivty: unknown key; did you mean \"diffusivity\"? \
         (known: diffusivity, conductivity, density, heat_capacity, melting_temperature, latent_heat, \
         liquid)",
    ),
    (&["titel=a"], "titel: unknown key; did you mean \"title\"?"),
    (&["title=null"], "title: "),
    (&["particles.fill.0.shap=1"], "particles.fill[0].shap: unknown key; did you mean \"shape\"?"),
    (&["kernel={\"name\":\"lucy\"}"], "kernel.support_ratio: missing key"),
    (&["kernel=5"], "kernel: "),
    (&["dimension=4"], "dimension: is 4, must be 1, 2 or 3"),
    (&["dimension=two"], "dimension: "),
    (&["boundaries.0.held.vale=1"], "boundaries[0].held.vale: unknown key"),
    (&["boundaries=[{\"hold\":{}}]"], "boundaries[0].hold: unknown key; did you mean \"held\"?"),
    (
        &["particles.fill.0.shape={\"bx\":{}}"],
        "particles.fill[0].shape.bx: unknown key; did you mean \"box\"?",
    ),
    (&["exact.name=unifrm"], "exact.name: unknown name \"unifrm\"; did you mean \"uniform\"?"),
    (&["exact.valu=5"], "exact.valu: unknown key; did you mean \"value\"?"),
    (&["exact={\"name\":\"uniform\"}"], "exact.value: missing key"),
    (&["exact={\"value\":5}"], "exact.name: missing key"),
    (&["exact.value=true"], "exact.value: expected a number or an expression, found true"),
    (&["kernel.name=cubic"], "kernel.name: unknown name \"cubic\"; did you mean \"cubic_spline\"?"),
    (&["operator.correction=nne"], "operator.correction: unknown name \"nne\""),
    (&["operator.pair_mean=mean"], "operator.pair_mean: unknown name \"mean\""),
    (&["time.method=eular"], "time.method: unknown name \"eular\"; did you mean \"euler\"?"),
    (&["output.fields=[\"valu\"]"], "output.fields[0]: unknown name \"valu\""),
    (&["particles.fill.0.material=rok"], "materials.rock: not used: no fill is made of it"),
    (
        &["materials.iron.diffusivity=1", "particles.fill.0.material=irn"],
        "materials.iron: not used",
    ),
    // Unused.
    (&["materials.iron.diffusivity=1"], "materials.iron: not used: no fill is made of it"),
    (&["exact=null", "output.fields=[\"error\"]"], "output.fields: not used:"),
    (&["probes=[]", "output.probe_every=1"], "output.probe_every: not used:"),
    (&["time.end=0", "time.step=1"], "time.step: not used:"),
    (&["initial.0.at=[1,1]"], "initial[0].at: not used:"),
    (&["initial.0.amount=1"], "initial[0].amount: not used:"),
    (
        &["initial=[{\"amount\":1,\"at\":[1,1],\"where\":{\"union\":[]}}]"],
        "initial[0].where: not used:",
    ),
    (&["initial=[{\"amount\":1}]"], "initial[0].at: missing key"),
    (&["initial=[{}]"], "initial[0].value: missing key"),
    // Numbers and expressions.
    (
        &["materials.rock.diffusivity=15/yaer"],
        "materials.rock.diffusivity: \"15/yaer\": unknown name \"yaer\" (allowed: pi year day",
    ),
    (&["materials.rock.diffusivity=2*x"], "materials.rock.diffusivity: \"2*x\": \"x\" has no"),
    (&["initial.0.value=z"], "initial[0].value: \"z\": \"z\" has no meaning here (allowed: pi"),
    (&["initial.0.value=t"], "initial[0].value: \"t\": \"t\" has no meaning here"),
    (&["initial.0.value=1+"], "initial[0].value: \"1+\": expected a number, a name"),
    (&["initial.0.value=1/(x-0.25)"], "initial[0].value: \"1/(x-0.25)\": gives inf at [0.25, "),
    (&["boundaries.0.held.value=ln(-x)"], "boundaries[0].held.value: \"ln(-x)\": gives NaN at "),
    (
        &["exact={\"name\":\"expression\",\"value\":\"sqrt(-t)\"}"],
        "exact.value: \"sqrt(-t)\": gives NaN at [0.25, 0.25], t = 172800 s",
    ),
    (&["particles.spacing=spacing"], "particles.spacing: \"spacing\": \"spacing\" has no"),
    (&["time.end=0/0"], "time.end: \"0/0\": gives NaN"),
    (&["probes.0.at=[1]"], "probes[0].at: has 1 components, must have 2"),
    (&["probes.0.at=[1,true]"], "probes[0].at[1]: expected a number"),
    (&["probes.0.at=7"], "probes[0].at: expected a list of numbers, found 7"),
    // Ranges.
    (&["materials.rock.diffusivity=0"], "materials.rock.diffusivity: is 0, must be positive"),
    (&["materials.rock.density=-1"], "materials.rock.density: is -1, must be positive"),
    (&["particles.spacing=0"], "particles.spacing: is 0, must be positive"),
    (&["kernel.support_ratio=1"], "kernel.support_ratio: is 1, must be above 1"),
    (&["kernel.support_ratio=-2"], "kernel.support_ratio: is -2, must be above 1"),
    (&["kernel.name=hat"], "kernel.name: hat is not defined in 2 dimensions"),
    (&["time.end=-1"], "time.end: is -1, must be zero or positive"),
    (&["time.step=0"], "time.step: is 0, must be positive"),
    (&["time.step=3*day"], "time.step: is 259200, must be at most time.end, 172800"),
    (&["output.every=0"], "output.every: is 0, must be positive"),
    (&["particles.spacing=1e-6"], "particles: 8000000000000 particles, at most 4294967293"),
    // Particles.
    (&["particles.fill=[]"], "particles.fill"),
    (&["particles.fill.0.shape.box.max=[0.1,0.1]"], "particles.fill[0]: holds no particle"),
    (&["particles.fill.0.shape.box.max=[-1,2]"], "particles.fill[0].shape: box.min must not"),
    (
        &["particles.fill.0.shape={\"half_space\":{\"point\":[0,0],\"normal\":[1,0]}}"],
        "particles.fill[0].shape: has no bounds",
    ),
    (
        &["particles.fill.0.shape={\"cylinder\":{\"from\":[0,0],\"to\":[1,0],\"radius\":1}}"],
        "particles.fill[0].shape: a cylinder needs dimension 3; use sphere",
    ),
    // Boundaries and probes.
    (
        &["boundaries.0.held.where.box={\"min\":[0.3,0],\"max\":[0.4,2]}"],
        "boundaries[0].held.where: selects no particle",
    ),
    (
        &["initial.0.where.sphere={\"center\":[9,9],\"radius\":1}"],
        "initial[0].where: selects no particle",
    ),
    (&["boundaries=[{\"periodic\":{\"axes\":[\"z\"]}}]"], "boundaries[0].periodic.axes[0]: unkn"),
    (&["boundaries=[{\"periodic\":{\"axes\":[\"w\"]}}]"], "boundaries[0].periodic.axes[0]: unkn"),
    (
        &["boundaries=[{\"periodic\":{\"axes\":[\"x\",\"x\"]}}]"],
        "boundaries[0].periodic.axes[1]: \"x\" is given twice",
    ),
    (
        &["boundaries=[{\"periodic\":{\"axes\":[\"y\"]}}]", "particles.spacing=0.45"],
        "particles.spacing: 0.45 m does not divide the periodic axis y of 2 m; 0.5 m does",
    ),
    (
        &["boundaries=[{\"periodic\":{\"axes\":[\"y\"]}}]", "kernel.support_ratio=2.1"],
        "kernel.support_ratio: the support radius of 1.05 m is more than half of the periodic",
    ),
    (
        &["probes=[{\"name\":\"p\",\"at\":[1,1]},{\"name\":\"p\",\"at\":[2,1]}]"],
        "probes[1].name: \"p\" is given twice",
    ),
    (&["probes.0.at=[1,3]"], "probes[0].at: [1, 3] lies outside the domain, [0, 0] to [4, 2]"),
    (&["initial=[{\"amount\":1,\"at\":[9,9]}]"], "initial[0].at: [9, 9] lies outside the domain"),
    (&["output.fields=[\"value\",\"value\"]"], "output.fields[1]: \"value\" is given twice"),
    // Exact solutions.
    (&["exact={\"name\":\"point_source\"}"], "exact.amount: missing key: the case has 0 deposits"),
    (
        &["exact={\"name\":\"point_source\",\"amount\":1}"],
        "exact.at: missing key: the case has 0 deposits",
    ),
    (&["exact={\"name\":\"slab\",\"axis\":\"z\",\"initial\":0}"], "exact.axis: unknown name \"z\""),
    (
        &["exact={\"name\":\"slab\",\"axis\":\"x\",\"initial\":0}"],
        "exact.left: missing key: the face x_min has no wall",
    ),
    (
        &["exact={\"name\":\"slab\",\"axis\":\"x\",\"left\":{\"convection\":{\"coefficient\":-1,\
           \"ambient\":0}},\"right\":\"insulated\",\"initial\":0}"],
        "exact.left.convection.coefficient: is -1, must be zero or positive",
    ),
    (
        &["exact={\"name\":\"sphere\",\"center\":[0,0],\"radius\":1,\
           \"surface\":\"insulated\",\"initial\":0}"],
        "dimension: is 2, must be 3 for a sphere",
    ),
    (
        &["exact={\"name\":\"annulus\",\"center\":[0,0],\"inner_radius\":2,\
           \"outer_radius\":1,\"inner\":0,\"outer\":0,\"initial\":0}"],
        "exact.inner_radius: is 2, must be below the outer radius",
    ),
    (
        &["exact={\"name\":\"slab\",\"axis\":\"x\",\"left\":\"insulated\",\
           \"right\":\"insulated\",\"initial\":0,\"to\":-1}"],
        "exact.to: is -1, must be above exact.from",
    ),
];

#[test]
fn bad_cases_are_refused_by_path() {
    for (overrides, expected) in BAD {
        let error = with(overrides).expect_err(expected).to_string();
        assert!(error.starts_with(expected), "{overrides:?}\n  {error}\n  {expected}");
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn overlapping_fills_and_particles_held_twice() {
    let mut case = base();
    let second = json!({ "shape": { "sphere": { "center": [4, 1], "radius": 1 } },
        "material": "rock" });
    case["particles"]["fill"].as_array_mut().expect("list").push(second);
    let error = from_json("base", case, &[]).expect_err("overlap").to_string();
    assert_eq!(
        error,
        "particles.fill[1]: overlaps particles.fill[0]: both contain the lattice site at \
         [3.75, 0.25]"
    );
    let mut case = base();
    let second = json!({ "held": { "where": { "box": { "min": [0, 0], "max": [4, 0.5] } },
        "value": 3 } });
    case["boundaries"].as_array_mut().expect("list").push(second);
    let error = from_json("base", case, &[]).expect_err("held twice").to_string();
    let expected =
        "boundaries[1].held: holds the particle at [0.25, 0.25], which boundaries[0].held holds";
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn a_material_that_a_fill_names_must_exist() {
    let mut case = base();
    let second = json!({ "shape": { "box": { "min": [5, 0], "max": [6, 2] } }, "material": "rok" });
    case["particles"]["fill"].as_array_mut().expect("list").push(second);
    let error = from_json("base", case, &[]).expect_err("no such material").to_string();
    let expected = "particles.fill[1].material: unknown name \"rok\"; did you mean \"rock\"?";
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn the_diffusivity_of_two_materials_is_ambiguous() {
    let mut case = base();
    case["materials"]["iron"] = json!({ "diffusivity": 1 });
    let second =
        json!({ "shape": { "box": { "min": [5, 0], "max": [6, 2] } }, "material": "iron" });
    case["particles"]["fill"].as_array_mut().expect("list").push(second);
    case["initial"] = json!([{ "amount": 1, "at": [2, 1] }]);
    case["exact"] = json!({ "name": "masses_in_box" });
    let error = from_json("base", case, &[]).expect_err("ambiguous").to_string();
    assert_eq!(error, "exact.diffusivity: missing key: the case has 2 materials");
}

#[test]
fn text_must_be_strict_json() {
    let message = |text: &str| from_text("case", text, &[]).expect_err(text).to_string();
    let twice = r#"{ "materials": { "rock": 1, "rock": 2 } }"#;
    let error = message(twice);
    assert!(error.starts_with("materials"), "{error}");
    assert!(error.contains("the key \"rock\" is given twice"), "{error}");
    assert!(message("{ \"a\": 1, }").contains("line 1 column"), "{}", message("{ \"a\": 1, }"));
    assert!(message("{} {}").contains("not valid JSON: trailing characters"));
    assert!(message("[]").starts_with("case: "), "{}", message("[]"));
}
