//! Sizes, counts and edges: what is just allowed, and what is refused.

use glam::DVec3;
use serde_json::json;

use super::{base, with};
use crate::case::{CaseError, Scene, from_json};

fn refused(overrides: &[&str], expected: &str) {
    let error = with(overrides).expect_err(expected).to_string();
    assert!(error.starts_with(expected), "{overrides:?}\n  {error}\n  {expected}");
    assert!(!error.contains('\n'), "{error}");
}

/// The base case's box in two parts that meet at x = `seam`, which moves the lattice there.
fn seamed(seam: f64, periodic: bool) -> Result<Scene, CaseError> {
    let mut case = base();
    case["particles"]["fill"] = json!([
        { "shape": { "box": { "min": [seam, 0], "max": [4, 2] } }, "material": "rock" },
        { "shape": { "box": { "min": [0, 0], "max": [seam, 2] } }, "material": "rock" }
    ]);
    case["boundaries"] = json!([]);
    if periodic {
        case["boundaries"] = json!([{ "periodic": { "axes": ["x"] } }]);
    }
    from_json("seamed", case, &[])
}

#[test]
fn the_edges_of_a_periodic_axis_are_one() {
    let free = seamed(0.25, false).expect("good").problem.particles;
    assert_eq!(free.len(), 36);
    let problem = seamed(0.25, true).expect("good").problem;
    let position = &problem.particles.position;
    assert_eq!((position.len(), problem.particles.volume.len()), (32, 32));
    assert!(position.iter().all(|x| x.x < 4.0), "{position:?}");
    assert_eq!(position.iter().filter(|x| x.x == 0.0).count(), 4);
    for (a, &x) in position.iter().enumerate() {
        let apart = |&y: &DVec3| problem.domain.nearest_image(y - x).length() > 0.4;
        assert!(position[..a].iter().all(apart), "{x}");
    }
    // Where no site falls on the edge, none is lost.
    assert_eq!(seamed(0.5, true).expect("good").problem.particles.len(), 32);
}

#[test]
fn fills_that_touch_on_a_site_name_it() {
    let mut case = base();
    case["particles"]["fill"] = json!([
        { "shape": { "box": { "min": [0, 0], "max": [0.75, 2] } }, "material": "rock" },
        { "shape": { "box": { "min": [0.75, 0], "max": [4, 2] } }, "material": "rock" }
    ]);
    let error = from_json("touching", case, &[]).expect_err("touching").to_string();
    let expected = "particles.fill[1]: overlaps particles.fill[0]: both contain the lattice site \
                    at [0.75, 0.25]";
    assert_eq!(error, expected);
}

#[test]
fn a_thin_axis_does_not_hide_the_others() {
    refused(
        &["particles.spacing=1e-10", "particles.fill.0.shape.box.max=[4,1e-11]"],
        "particles: 40000000000 particles, at most 4294967293",
    );
}

#[test]
fn supports_have_a_widest() {
    let range = "must be above 1 and at most 50";
    refused(&["kernel.support_ratio=1e4"], &format!("kernel.support_ratio: is 10000, {range}"));
    refused(&["kernel.support_ratio=50.1"], &format!("kernel.support_ratio: is 50.1, {range}"));
    assert!(with(&["kernel.support_ratio=50"]).is_ok());
    let periodic = "boundaries=[{\"periodic\":{\"axes\":[\"x\",\"y\"]}}]";
    refused(
        &[periodic, "kernel.support_ratio=5"],
        "kernel.support_ratio: the support radius of 2.5 m is more than half of the periodic axis \
         y of 2 m; the largest support_ratio allowed is 2",
    );
    assert!(with(&[periodic, "kernel.support_ratio=2"]).is_ok());
    refused(
        &[periodic, "particles.spacing=1"],
        "kernel.support_ratio: the support radius of 2 m is more than half of the periodic axis \
         y of 2 m; no support_ratio fits an axis of at most 2 spacings",
    );
}

#[test]
fn outputs_and_steps_are_counted() {
    refused(
        &["output.every=1e-3"],
        "output.every: is 0.001, must be at least 1.728 (there would be 1.728e8 outputs, at most \
         100000 are allowed)",
    );
    refused(
        &["output.probe_every=1e-3"],
        "output.probe_every: is 0.001, must be at least 0.01728 (there would be 1.728e8 outputs, \
         at most 10000000 are allowed)",
    );
    refused(
        &["time.step=1e-11"],
        "time.step: is 0.00000000001, must be at least 0.0000000001728 (",
    );
    refused(&["time.step=5e-324"], "time.step: is 0.0000");
    for good in ["output.every=2*day/1e5", "output.probe_every=2*day/1e7", "time.step=2*day/1e15"] {
        assert!(with(&[good]).is_ok(), "{good}");
    }
}

#[test]
fn porosities_are_shares() {
    for name in ["point_source", "point_source_in_box"] {
        let exact = |porosity: &str| {
            format!(r#"exact={{"name":"{name}","amount":1,"at":[2,1],"porosity":{porosity}}}"#)
        };
        for wrong in ["0", "1.5", "-1"] {
            let expected = format!("exact.porosity: is {wrong}, must be above 0 and at most 1");
            refused(&[&exact(wrong)], &expected);
        }
        for good in ["1", "1e-3", "null"] {
            assert!(with(&[&exact(good)]).is_ok(), "{name} {good}");
        }
    }
}

#[test]
fn null_leaves_out_what_has_no_value_then() {
    for good in ["exact", "time.step", "output.every", "output.probe_every", "output.fields"] {
        assert!(with(&[&format!("{good}=null")]).is_ok(), "{good}");
    }
    assert!(with(&["initial.0.where=null"]).is_ok());
    assert!(with(&["materials.rock.density=null"]).is_ok());
    for wrong in ["probes", "time.method", "materials.rock", "boundaries", "operator"] {
        refused(&[&format!("{wrong}=null")], &format!("{wrong}: "));
    }
}
