//! What a run draws and tabulates besides fields: the profile, the front and the probes over time.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs a shipped case on the CPU into a folder and returns that.
fn run(root: &Path, case: &str, changes: &[&str]) -> PathBuf {
    let out = root.join("out");
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffusph"));
    command.args(["run", case, "--backend", "cpu", "--quiet", "--out"]).arg(&out);
    changes.iter().for_each(|change| {
        command.args(["--set", change]);
    });
    let output = command.output().expect("the binary starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The rows of a table below its header, as numbers; what is empty is no number.
fn rows(text: &str, header: &str) -> Vec<Vec<f64>> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header));
    let cells = |line: &str| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
    lines.map(cells).collect()
}

const FRONT: &str = "time_s,position,liquid_volume,exact";

#[test]
fn a_rod_that_melts_has_its_front_and_its_enthalpy() {
    let root = tempfile::tempdir().expect("a temporary folder");
    let out = run(root.path(), "melting_rod", &[]);
    let fronts = rows(&read(&out, "front.csv"), FRONT);
    // Every half second of 15 s; outputs are at some of the same times and add no row.
    assert_eq!(fronts.len(), 31);
    assert!(fronts.is_sorted_by(|a, b| a[0] < b[0]));
    assert_eq!(fronts[0], [0.0, 0.0, 0.0, 0.0]);
    let spacing = 0.002;
    for row in &fronts {
        let [time, position, volume, exact] = row[..] else { panic!("{row:?}") };
        assert_eq!(position, volume, "its section is 1");
        assert!((position - exact).abs() < 0.5 * spacing, "t = {time}: {position} and {exact}");
        let root_law = 0.019_779_090_3 * (time / 15.0).sqrt();
        assert!((exact - root_law).abs() < 1e-9, "t = {time}: {exact} and {root_law}");
    }
    let report: serde_json::Value =
        serde_json::from_str(&read(&out, "report.json")).expect("a report");
    let last = fronts[30][1];
    assert_eq!(report["front"]["position"].as_f64(), Some(last));
    let svg = read(&out, "front.svg");
    for part in ["front position (m)", "√t (√s)", "numerical (SPH)", "exact"] {
        assert!(svg.contains(part), "no {part}");
    }
    let profile = read(&out, "profile.svg");
    for part in ["temperature (K)", "enthalpy (J/m³)", "numerical − exact"] {
        assert!(profile.contains(part), "no {part}");
    }
    let probes = read(&out, "probes.svg");
    for part in ["melt", "solid", "exact", "temperature (K)", "time (s)"] {
        assert!(probes.contains(part), "no {part}");
    }
}

#[test]
fn what_does_not_melt_has_none_and_stale_ones_go() {
    let root = tempfile::tempdir().expect("a temporary folder");
    let out = run(root.path(), "melting_rod", &["time.end=1"]);
    for name in ["front.csv", "front.svg", "probes.svg"] {
        assert!(out.join(name).is_file(), "{name}");
    }
    // One step to the end: two records of each probe are no curve.
    run(root.path(), "rod", &["time.end=0.01", "output={}"]);
    for name in ["front.csv", "front.svg", "probes.svg"] {
        assert!(!out.join(name).exists(), "{name} is left of the run before");
    }
    let profile = read(&out, "profile.svg");
    assert!(
        !profile.contains("enthalpy") && !profile.contains("temperature"),
        "one panel of values"
    );
    run(root.path(), "rod", &["time.end=0.03", r#"output={"probe_every":0.01}"#]);
    assert!(read(&out, "probes.svg").contains("fifth"));
    assert!(!out.join("front.csv").exists());
}

#[test]
fn without_an_exact_solution_nothing_exact_is_drawn_and_cells_are_empty() {
    let root = tempfile::tempdir().expect("a temporary folder");
    let fields = r#"output.fields=["value"]"#;
    let out = run(root.path(), "melting_rod", &["time.end=2", "exact=null", fields]);
    let fronts = rows(&read(&out, "front.csv"), FRONT);
    assert!(fronts.len() == 5 && fronts.iter().all(|row| row[3].is_nan()));
    for name in ["front.svg", "probes.svg", "profile.svg"] {
        assert!(!read(&out, name).contains("exact"), "{name}");
    }
    assert!(read(&out, "profile.svg").contains("enthalpy"));
}

#[test]
fn eight_probes_are_drawn_at_most_and_the_title_says_so() {
    let root = tempfile::tempdir().expect("a temporary folder");
    let probes = |count: u32| {
        let all: Vec<String> = (1..=count)
            .map(|k| format!(r#"{{"name":"p{k}","at":[{}]}}"#, 0.01 * f64::from(k)))
            .collect();
        format!("probes=[{}]", all.join(","))
    };
    let of = |count: u32| {
        let changes = ["time.end=0.05", r#"output={"probe_every":0.01}"#, &probes(count)];
        read(&run(root.path(), "rod", &changes), "probes.svg")
    };
    let nine = of(9);
    assert!(nine.contains("the first 8 of 9 probes"));
    let has = |svg: &str, name: &str| svg.lines().any(|line| line.trim() == name);
    assert!(has(&nine, "p8") && !has(&nine, "p9"));
    let eight = of(8);
    assert!(has(&eight, "p8") && !eight.contains("the first"));
}

#[test]
fn a_steady_state_has_no_history() {
    let root = tempfile::tempdir().expect("a temporary folder");
    let out = run(root.path(), "rod", &["time.method=steady", "time.step=null"]);
    assert!(out.join("profile.svg").is_file() && !out.join("probes.svg").exists());
}
