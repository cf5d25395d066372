//! Numerical stability: the limits of the step, extreme scenes, and the command.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Output};

use diffusph::case;
use diffusph::model::KernelKind;
use diffusph::report::StabilityReport;
use diffusph::report::stability::{StepScan, Verdict};
use diffusph::study::{StabilityOptions, StabilityOutcome, Tampering, stability};

/// Lattices of the cubic spline at H / dx = 2 in these dimensions; no GPU.
fn options(dimensions: &[usize]) -> StabilityOptions<'static> {
    StabilityOptions {
        scene: None,
        machines: Vec::new(),
        kernels: vec![KernelKind::CubicSpline],
        support_ratios: vec![2.0],
        dimensions: dimensions.to_vec(),
        quick: true,
        tampering: Tampering::NONE,
        command: "a test".to_owned(),
    }
}

/// What comes of the options up to the first part whose name is `until`.
fn study(options: &StabilityOptions<'_>, until: Option<&str>) -> StabilityOutcome {
    let mut progress = |at: diffusph::study::StabilityProgress| match until {
        Some(until) if at.what.starts_with(until) => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    stability(options, &mut progress).unwrap_or_else(|error| panic!("{error}"))
}

/// The first of the extreme scenes.
const FIRST: &str = "one material";

/// Scans of lattices alone.
fn lattices(options: &StabilityOptions<'_>) -> StabilityReport {
    study(options, Some(FIRST)).report
}

/// The measured limit over dx^2 / D.
fn limit(scan: &StepScan) -> f64 {
    scan.measured_limit_s.expect("it has a limit") / scan.unit_s
}

#[test]
fn the_run_itself_has_the_published_limits() {
    let report = lattices(&options(&[1, 2, 3]));
    assert_eq!(report.broken, Vec::<String>::new());
    let published = [(1, 0.5, 0.5), (2, 0.3665, 0.3713), (3, 0.3308, 0.3374)];
    for (dimension, plain, corrected) in published {
        for (correction, expected) in [("none", plain), ("moment", corrected)] {
            let scan = report
                .scans
                .iter()
                .find(|scan| scan.dimension == dimension && scan.correction == correction);
            let scan = scan.expect("it is scanned");
            let off = limit(scan) / expected - 1.0;
            assert!(off.abs() < 5e-3, "{}: {} {off:e}", scan.scene, limit(scan));
        }
    }
}

#[test]
fn every_kernel_has_the_limit_of_its_plane_waves_and_a_safe_bound_below() {
    let kernels = KernelKind::ALL.to_vec();
    let asked = StabilityOptions { kernels, support_ratios: vec![2.0, 3.0], ..options(&[1, 2]) };
    let report = lattices(&asked);
    // The hat is defined in 1-D alone.
    assert_eq!(report.scans.len(), 2 * 2 * (7 + 6));
    assert_eq!(report.broken, Vec::<String>::new());
    for scan in &report.scans {
        let waves = scan.wave_limit_s.expect("a lattice has waves") / scan.unit_s;
        assert!((limit(scan) / waves - 1.0).abs() < 1e-3, "{}", scan.scene);
        let safe = scan.safe_s.expect("it has pairs");
        assert!(safe <= scan.limit_s.expect("it has a limit") * (1.0 + 1e-9), "{}", scan.scene);
    }
}

#[test]
fn a_run_grows_above_its_limit_and_only_there() {
    let report = lattices(&options(&[2]));
    for scan in &report.scans {
        assert!(scan.points.first().is_some_and(|point| point.ratio == 0.2));
        assert!(scan.points.last().is_some_and(|point| (point.ratio - 3.0).abs() < 1e-12));
        for point in &scan.points {
            let grows = point.growth > 1.0 + 1e-6;
            assert_eq!(grows, point.ratio > 1.0 + 1e-9, "{} {point:?}", scan.scene);
            if point.ratio > 0.8 {
                assert!((point.growth / point.expected - 1.0).abs() < 1e-3, "{point:?}");
            }
        }
    }
}

#[test]
fn a_wrong_kernel_constant_is_noticed_by_every_lattice_of_the_plain_operator() {
    let tampering = Tampering { kernel_factor: 1.02 };
    let report = lattices(&StabilityOptions { tampering, ..options(&[1, 2, 3]) });
    let broken = |scan: &StepScan| scan.checks.iter().any(|check| check.is_broken());
    for scan in &report.scans {
        // The moment correction divides it out.
        assert_eq!(broken(scan), scan.correction == "none", "{}", scan.scene);
    }
    assert!(report.broken.len() >= 3 && !report.keeps_its_promises());
}

/// The verdict of explicit Euler at the safe bound in `case`.
fn at_safe_bound(case: &str, kernel_factor: f64) -> (Verdict, String) {
    let scene = case::load(case, &[]).unwrap_or_else(|error| panic!("{error}"));
    let tampering = Tampering { kernel_factor };
    let asked = StabilityOptions { scene: Some(&scene), tampering, ..options(&[]) };
    let report = study(&asked, Some(&format!("{case}, euler, 0.99 limit"))).report;
    let trial = report.trials.first().expect("it was run");
    assert_eq!(trial.way, "euler, safe bound");
    (trial.verdict, trial.reason.clone())
}

#[test]
fn a_wrong_kernel_constant_flips_the_verdict_on_a_case() {
    let (right, reason) = at_safe_bound("gaussian_small", 1.0);
    assert_eq!(right, Verdict::Pass, "{reason}");
    let (wrong, reason) = at_safe_bound("gaussian_small", 2.5);
    assert_eq!(wrong, Verdict::Fail, "{reason}");
}

#[test]
fn a_study_that_is_stopped_has_what_there_is() {
    let outcome = study(&options(&[1]), Some(FIRST));
    assert!(outcome.interrupted && outcome.report.scans.len() == 2);
    assert!(outcome.report.trials.is_empty());
}

fn diffusph(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffusph"))
        .args(arguments)
        .output()
        .expect("the binary starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("output is UTF-8")
}

/// What a page would fetch.
fn fetched(page: &str) -> Vec<&'static str> {
    let signs = ["http:", "https:", "src=", "url(", "@import", "<script", "<link"];
    signs.into_iter().filter(|sign| page.contains(sign)).collect()
}

#[test]
fn the_quick_study_keeps_every_promise_and_writes_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("study");
    let arguments = ["stability", "--quick", "--backend", "cpu", "--json", "--out"];
    let output = diffusph(&[&arguments[..], &[out.to_str().expect("UTF-8")]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "no progress but to a terminal");
    let report: StabilityReport = serde_json::from_slice(&output.stdout).expect("the report alone");
    assert_eq!(report.broken, Vec::<String>::new());
    assert_eq!(report.stability_version, diffusph::report::stability::STABILITY_VERSION);
    let read = |name: &str| fs::read_to_string(Path::new(&out).join(name)).expect("it is written");
    let back: StabilityReport = serde_json::from_str(&read("stability.json")).expect("JSON");
    assert_eq!(back, report);
    for scan in report.scans.iter().filter(|scan| scan.limit_s.is_some()) {
        let [safe, limit] = [scan.safe_s, scan.limit_s].map(|step| step.expect("a bound"));
        assert!(safe <= limit * (1.0 + 1e-9), "{}", scan.scene);
    }
    let [pass, _, _, fail] = report.counts();
    assert!(fail == 0 && 2 * pass > report.trials.len(), "{:?}", report.counts());
    // The extreme scenes are there, in every way.
    for scene in ["layers 1e9", "jitter 40 %", "a single particle", "values of 1e30", "1e6 steps"] {
        assert!(report.trials.iter().any(|trial| trial.scene == scene), "{scene}");
    }
    for way in ["euler, safe bound", "heun", "rkl2", "tr_bdf2", "steady", "auto, slow time"] {
        assert!(report.trials.iter().any(|trial| trial.way == way), "{way}");
    }
    assert!(report.left_out.iter().any(|left| left.why.contains("no GPU was asked for")));
    let page = read("stability.html");
    assert_eq!(fetched(&page), Vec::<&str>::new());
    assert_eq!(fetched(&page.replacen("<p>", "<script src=x>", 1)), ["src=", "<script"]);
    for part in ["<svg", "layers 1e9", "measured limit", "euler, 1.5 limit", "&lt;"] {
        assert!(page.contains(part) || part == "&lt;", "no {part}");
    }
}

#[test]
fn bad_flags_are_usage_errors() {
    for arguments in [
        &["stability", "--kernel", "cubic"][..],
        &["stability", "--support-ratio", "1"],
        &["stability", "--dimension", "4"],
        &["stability", "no_such_case"],
        &["stability", "--set", "time.end=1"],
        &["stability", "--backend", "cpu", "--precision", "f32"],
    ] {
        let output = diffusph(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
    }
    let help = text(&diffusph(&["stability", "--help"]).stdout);
    assert!(help.contains("diffusph stability --quick"), "{help}");
}
