//! The command itself: shipped cases end to end, what it prints and writes, and bad input.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Names that every report carries.
const REPORT_KEYS: [&str; 26] = [
    "report_version",
    "case",
    "title",
    "diffusph_version",
    "backend",
    "adapter",
    "precision",
    "dimension",
    "particles",
    "path",
    "method",
    "steps",
    "operator_applications",
    "dt",
    "dt_limit",
    "simulated_s",
    "wall_s",
    "updates_per_s",
    "memory_bytes",
    "field",
    "conserved",
    "density",
    "error",
    "probes",
    "left_out",
    "warnings",
];

fn diffusph(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffusph"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the binary starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("output is UTF-8")
}

/// The report of a run that must succeed.
fn report(folder: &Path, arguments: &[&str]) -> Value {
    let output = diffusph(folder, &[&["run"], arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("standard output is the report alone")
}

fn number(report: &Value, pointer: &str) -> f64 {
    report.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {pointer}"))
}

/// The one message of a command that must fail with `code`, having left nothing behind.
fn refusal(code: i32, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = diffusph(folder.path(), arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}: {}", text(&output.stdout));
    let lines: Vec<&str> = message.lines().filter(|line| line.starts_with("diffusph: ")).collect();
    assert_eq!(lines.len(), 1, "one message: {message}");
    let left: Vec<_> = fs::read_dir(folder.path()).expect("readable").collect();
    assert!(left.is_empty(), "{arguments:?} left {left:?}");
    lines[0].to_owned()
}

#[test]
fn small_gaussian_is_right_on_both_backends_and_paths_and_in_both_precisions() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cpu = report(folder.path(), &["gaussian_small", "--backend", "cpu", "--out", "cpu"]);
    for key in REPORT_KEYS {
        assert!(cpu.get(key).is_some(), "no {key} in the report");
    }
    assert_eq!(cpu["steps"], 135);
    assert_eq!(cpu["particles"], 13_824);
    assert!((number(&cpu, "/conserved/final") - 1000.0).abs() < 1e-9);
    assert!(number(&cpu, "/conserved/relative_drift").abs() < 1e-12);
    let centre = number(&cpu, "/probes/0/value");
    for (precision, bound) in [("f32", 1e-5), ("f64", 1e-13)] {
        for path in ["lattice", "list"] {
            let flags = ["gaussian_small", "--backend", "gpu", "--precision", precision];
            let way = ["--path", path, "--out", "gpu"];
            let gpu = report(folder.path(), &[&flags[..], &way].concat());
            assert_eq!((&gpu["backend"], &gpu["precision"]), (&"gpu".into(), &precision.into()));
            assert_eq!(gpu["path"], path);
            assert!(gpu["adapter"].is_string());
            let off = (number(&gpu, "/probes/0/value") / centre - 1.0).abs();
            assert!(off < bound, "{precision} {path}: centre off by {off:e}");
        }
    }
}

#[test]
fn the_moment_correction_cures_the_gaussian() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let error = |correction: &str| {
        let set = format!("operator.correction={correction}");
        // Fine enough for the operator's bias to stand out from the error of the spacing.
        let fine = ["--set", "particles.spacing=1", "--set", "time.step=116800"];
        let flags = ["gaussian_small", "--backend", "cpu", "--no-output", "--set", &set];
        number(&report(folder.path(), &[&flags[..], &fine].concat()), "/error/l2_relative")
    };
    let (plain, corrected) = (error("none"), error("moment"));
    assert!(corrected < 0.25 * plain, "plain {plain:e}, corrected {corrected:e}");
    assert!(!folder.path().join("out").exists(), "--no-output writes nothing");
}

#[test]
fn columns_run_on_the_gpu_with_their_held_layers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for case in ["constant_column", "affine_column"] {
        let cut = ["--set", "time.end=225*2000", "--set", "output={}", "--no-output"];
        let of = |backend: &str, precision: &str| {
            let flags = [case, "--backend", backend, "--precision", precision];
            report(folder.path(), &[&flags[..], &cut].concat())
        };
        let cpu = of("cpu", "auto");
        for (precision, bound) in [("f32", 2e-5), ("f64", 1e-12)] {
            let gpu = of("gpu", precision);
            for pointer in ["/probes/0/value", "/conserved/final", "/conserved/boundary_exchange"] {
                let (a, b) = (number(&cpu, pointer), number(&gpu, pointer));
                assert!((a / b - 1.0).abs() < bound, "{case} {precision} {pointer}: {a} and {b}");
            }
            assert!(number(&gpu, "/conserved/relative_drift").abs() < bound);
        }
    }
}

#[test]
fn density_case_writes_the_summation_density() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let found = report(folder.path(), &["density", "--out", "here"]);
    assert!((number(&found, "/density/min") - 606.560_836_12).abs() < 1e-7);
    assert!((number(&found, "/density/max") - 999.972_466_09).abs() < 1e-7);
    let fields = fs::read_to_string(folder.path().join("here/particles_0000.vtu"));
    assert!(fields.expect("the fields are written").contains("Name=\"density\""));
}

#[test]
fn a_run_leaves_its_files_and_its_case_repeats_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let first = report(folder.path(), &["gaussian_small", "--backend", "cpu"]);
    let out = folder.path().join("out/gaussian_small");
    let files = ["report.json", "case.json", "probes.csv", "profile.svg", "series.pvd"];
    for name in files.into_iter().chain(["particles_0000.vtu", "particles_0001.vtu"]) {
        assert!(out.join(name).is_file(), "{name} is missing");
    }
    fs::write(out.join("particles_0007.vtu"), "stale").expect("writable");
    fs::copy(out.join("case.json"), folder.path().join("again.json")).expect("copied");
    let flags = ["again.json", "--backend", "cpu", "--out", "out/gaussian_small"];
    let second = report(folder.path(), &flags);
    assert_eq!(first["field"], second["field"]);
    assert_eq!(first["probes"], second["probes"]);
    assert!(!out.join("particles_0007.vtu").exists(), "stale output is removed");
    let probes = fs::read_to_string(out.join("probes.csv")).expect("probes are written");
    assert!(probes.starts_with("time_s,name,x,y,z,value,exact\n"), "{probes}");
    assert_eq!(probes.lines().count(), 1 + 6);
}

#[test]
fn the_case_of_the_readme_runs_and_is_right() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let readme = include_str!("../README.md");
    let case = readme.split("```json\n").nth(1).and_then(|rest| rest.split("```").next());
    fs::write(folder.path().join("spot.json"), case.expect("it shows a case")).expect("written");
    let found = report(folder.path(), &["spot.json", "--backend", "cpu", "--no-output"]);
    assert!(number(&found, "/error/l2_relative") < 1e-5, "{}", found["error"]);
}

#[test]
fn a_run_does_not_overwrite_the_case_it_reads() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let case = diffusph(folder.path(), &["cases", "density"]).stdout;
    fs::write(folder.path().join("case.json"), &case).expect("written");
    let output = diffusph(folder.path(), &["run", "case.json", "--out", "."]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("overwrite its own case"), "{}", text(&output.stderr));
    assert_eq!(fs::read(folder.path().join("case.json")).expect("still there"), case);
}

#[test]
fn scenes_without_pairs_or_without_free_particles_run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let one = r#"particles={"spacing":48,"fill":[{"shape":{"box":{"min":[0,0,0],"max":[48,48,48]}},"material":"rock"}]}"#;
    let held =
        r#"boundaries=[{"held":{"where":{"sphere":{"center":[24,24,24],"radius":99}},"value":7}}]"#;
    let base = ["gaussian_small", "--no-output", "--set", "exact=null", "--set", "initial=[]"];
    let rest = ["--set", "time={\"end\":10}", "--set", "output={}", "--set", "probes=[]"];
    for backend in ["cpu", "gpu"] {
        for scene in [one, held] {
            let flags = [&base[..], &rest, &["--backend", backend, "--set", scene]].concat();
            let found = report(folder.path(), &flags);
            assert_eq!(number(&found, "/simulated_s"), 10.0);
            assert!(found["dt_limit"].is_null(), "nothing limits the step");
            assert!(number(&found, "/field/max").is_finite());
        }
    }
}

#[test]
fn the_summary_says_what_a_user_needs() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = diffusph(folder.path(), &["run", "gaussian_small", "--backend", "cpu"]);
    let summary = text(&output.stdout);
    for part in ["13 824 particles", "cpu, f64", "masses_in_box", "L2 relative", "drift", "density"]
    {
        assert!(summary.contains(part), "no `{part}` in\n{summary}");
    }
    let quiet = diffusph(folder.path(), &["run", "gaussian_small", "--backend", "cpu", "--quiet"]);
    assert!(quiet.status.success() && quiet.stdout.is_empty());
}

#[test]
fn bad_cases_are_refused_with_the_place_named() {
    let broken: [(&str, &str); 14] = [
        ("materials.rock.diffusivty=1", "materials.rock.diffusivty"),
        ("materials.rock.diffusivity=-1", "materials.rock.diffusivity"),
        ("materials.rock.diffusivity=0/0", "materials.rock.diffusivity"),
        ("materials.rock.diffusivity=1+", "materials.rock.diffusivity"),
        ("particles.spacing=0", "particles.spacing"),
        ("kernel.support_ratio=-2", "kernel.support_ratio"),
        ("kernel.name=gauss", "kernel.name"),
        ("dimension=\"three\"", "dimension"),
        ("particles.fill=[]", "particles.fill"),
        (
            "boundaries=[{\"held\":{\"where\":{\"sphere\":{\"center\":[99,0,0],\"radius\":1}},\"value\":1}}]",
            "boundaries[0].held.where",
        ),
        ("boundaries=[{\"periodic\":{\"axes\":[\"x\"]}}]", "support"),
        ("time.step=1e9", "time.step"),
        ("probes=[{\"name\":\"far\",\"at\":[999,0,0]}]", "probes[0].at"),
        ("time.end=-1", "time.end"),
    ];
    for (set, place) in broken {
        let case = if set.contains("periodic") { "particles.spacing=16" } else { "dimension=3" };
        let flags = ["run", "gaussian_small", "--backend", "cpu", "--set", case, "--set", set];
        let message = refusal(2, &flags);
        assert!(message.contains(place), "`{place}` is not named: {message}");
    }
    let message = refusal(2, &["run", "gausian_small"]);
    assert!(message.contains("gaussian_small"), "{message}");
}

#[test]
fn bad_flags_are_refused_with_the_flag_or_name() {
    let message = refusal(2, &["run", "gaussian_small", "--adapter", "no such thing"]);
    assert!(message.contains("no such thing"), "{message}");
    let message = refusal(2, &["run", "gaussian_small", "--backend", "cpu", "--precision", "f32"]);
    assert!(message.contains("--precision f32"), "{message}");
    let message = refusal(2, &["run", "gaussian_small", "--backend", "cpu", "--adapter", "llvm"]);
    assert!(message.contains("--adapter llvm"), "{message}");
    let message = refusal(2, &["run", "gaussian_small", "--backend", "cpu", "--out", "/proc/x"]);
    assert!(message.contains("--out") && message.contains("/proc/x"), "{message}");
}

#[test]
fn steps_above_the_limit_need_permission_and_divergence_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let base = ["run", "gaussian_small", "--backend", "cpu", "--set", "output={}"];
    // 1.2 times the safe bound: allowed, with a warning that gives the measured limit.
    let set = |step: &str| format!("time.step={step}");
    let between = set("2.2e6");
    let output = diffusph(folder.path(), &[&base[..], &["--set", &between]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("below the measured limit"), "{}", text(&output.stdout));
    let above = set("4e6");
    let message = refusal(2, &[&base[..], &["--set", &above]].concat());
    assert!(message.contains("above the stability limit"), "{message}");
    let long = ["--set", &above, "--set", "time.end=4e6*3000", "--allow-unstable", "--out", "x"];
    let output = diffusph(folder.path(), &[&base[..], &long].concat());
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("diverged at step") && message.contains("particle"), "{message}");
    let kept = fs::read(folder.path().join("x/report.json")).expect("the last good report is kept");
    let kept: Value = serde_json::from_slice(&kept).expect("JSON");
    assert!(number(&kept, "/field/max").is_finite());
    assert!(folder.path().join("x/particles_0001.vtu").is_file());
}

#[test]
fn lists_and_scripts_are_printed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let print = |arguments: &[&str]| {
        let output = diffusph(folder.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    assert!(print(&["cases"]).contains("gaussian_small"));
    assert!(print(&["cases", "gaussian"]).contains("\"15/year\""));
    assert!(print(&["devices"]).contains("--backend auto takes"));
    assert!(print(&["schema"]).contains("\"diffusivity\""));
    assert!(print(&["completions", "bash"]).contains("diffusph"));
    let check = print(&["check", "gaussian_small", "--backend", "cpu"]);
    for part in ["13 824", "(116)", "safe", "left out", "passes"] {
        assert!(check.contains(part), "no `{part}` in\n{check}");
    }
}
