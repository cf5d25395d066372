//! The shipped cases with walls and curved boundaries: their errors, orders and balances.

use std::ops::ControlFlow;

use diffusph::case::{self, Override};
use diffusph::report::observed_order;
use diffusph::report::run::RunReport;
use diffusph::solver::Machine;
use diffusph::study::{self, RunOptions};

/// The report of a shipped case with these changes.
fn report(name: &str, set: &[&str]) -> RunReport {
    let parse = |text: &&str| Override::parse(text).expect("an override");
    let overrides: Vec<Override> = set.iter().map(parse).collect();
    let scene = case::load(name, &overrides).unwrap_or_else(|error| panic!("{name}: {error}"));
    let options = RunOptions::new(&Machine::Cpu);
    let run = study::run(&scene, &options, &mut |_| ControlFlow::Continue(())).expect("it runs");
    assert!(run.stopped.is_none());
    let drift = run.report.conserved.relative_drift;
    // Half a unit in the last place of every value in every step, all in one direction at worst.
    let allowed = f64::EPSILON * run.report.steps.max(100) as f64;
    assert!(drift.abs() < allowed, "{name}: drift {drift:e}");
    run.report
}

fn error(report: &RunReport) -> f64 {
    report.error.as_ref().expect("the case has an exact solution").l2_relative
}

/// The orders seen between one spacing and the next, each half of the one before.
fn orders(name: &str, spacings: &[f64]) -> Vec<f64> {
    let of = |spacing: &f64| error(&report(name, &[&format!("particles.spacing={spacing}")]));
    let errors: Vec<f64> = spacings.iter().map(of).collect();
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

/// The order over all spacings.
fn slope(name: &str, spacings: &[f64]) -> f64 {
    let of = |&spacing: &f64| {
        (spacing, error(&report(name, &[&format!("particles.spacing={spacing}")])))
    };
    let (spacings, errors): (Vec<f64>, Vec<f64>) = spacings.iter().map(of).unzip();
    observed_order(&spacings, &errors).expect("four errors")
}

#[test]
fn walls_on_faces_are_second_order_in_every_shipped_case() {
    let plates = ["flux_plate", "heated_plate", "flux_half_space", "cooling_plate", "swinging_bar"];
    for name in plates {
        let found = orders(name, &[0.004, 0.002, 0.001, 0.0005]);
        assert!(found.iter().all(|order| (order - 2.0).abs() < 0.1), "{name}: {found:?}");
    }
    let found = orders("patches", &[1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0, 1.0 / 64.0]);
    assert!(found.iter().all(|order| (order - 2.0).abs() < 0.1), "patches: {found:?}");
}

#[test]
fn the_mean_of_an_insulated_plate_rises_with_the_flux() {
    let report = report("heated_plate", &[]);
    // q t / (rho c L) from 300.
    let expected = 300.0 + 400e3 * 20.0 / (19300.0 * 129.0 * 0.1);
    assert!((report.field.mean / expected - 1.0).abs() < 1e-13, "{}", report.field.mean);
    assert!((report.conserved.boundary_exchange / (0.1 * (expected - 300.0)) - 1.0).abs() < 1e-12);
}

#[test]
fn convection_on_a_curved_surface_is_second_order() {
    let found = slope("sphere_convection", &[0.2, 0.1, 1.0 / 15.0, 0.05]);
    assert!(found > 1.8, "{found}");
    // All of an imposed flux gets in, but for what the staircase of the lattice leaves.
    let kind = r#"boundaries.0.surface.kind={"flux":1}"#;
    let set = [kind, "particles.spacing=0.05", "time.end=0.1", "exact=null"];
    let entered = report("sphere_convection", &set).conserved.boundary_exchange;
    let expected = 4.0 * std::f64::consts::PI * 0.1;
    assert!((entered / expected - 1.0).abs() < 2e-3, "{}", entered / expected);
}

#[test]
fn held_layers_are_second_order_where_they_continue_the_profile_and_else_first() {
    let steady = slope("annulus_steady", &[0.1, 0.05, 0.025, 0.0125]);
    assert!((steady - 2.0).abs() < 0.1, "{steady}");
    // Held at one value, a layer acts where its particles are: within half a spacing of the circle
    // or sphere that it stands for.
    for (name, spacings) in [
        ("annulus", [0.05, 0.025, 0.0125, 0.00625]),
        ("sphere_cooling", [0.2, 0.1, 1.0 / 15.0, 0.05]),
    ] {
        let found = slope(name, &spacings);
        assert!((0.8..1.4).contains(&found), "{name}: {found}");
    }
}
