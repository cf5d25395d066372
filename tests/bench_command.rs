//! The benchmark as a command: what it reports, what it leaves out, and bad flags. Nothing here
//! asserts a speed.

use std::process::{Command, Output};

use serde_json::Value;

/// Few particles and short measurements.
const QUICK: [&str; 6] = ["--sizes", "1e3,8e3", "--seconds", "0.02", "--dimension", "2,3"];

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffusph"))
        .arg("bench")
        .args(arguments)
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .expect("the binary starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("output is UTF-8")
}

/// The report of a benchmark that must succeed, having said nothing else.
fn report(arguments: &[&str]) -> Value {
    let output = bench(&[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "no progress but to a terminal: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("standard output is the report alone")
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap_or_else(|| panic!("no list {key} in {value}"))
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {value}"))
}

/// What a series is, in words.
fn name(series: &Value) -> String {
    let part = |key: &str| series[key].to_string().replace('"', "");
    ["path", "precision", "dimension", "support_ratio"].map(part).join(" ")
}

/// Faults in what a report says of its measurements.
fn faults(report: &Value) -> Vec<String> {
    let mut found = Vec::new();
    let mut expect = |holds: bool, what: String| {
        if !holds {
            found.push(what);
        }
    };
    for series in list(report, "series") {
        let limit = list(report, "limits").iter().find(|l| l["precision"] == series["precision"]);
        let limit = limit.unwrap_or_else(|| panic!("no limit for {}", name(series)));
        for of in list(series, "measurements") {
            let at = |what: &str| format!("{} at {}: {what}", name(series), of["size"]);
            let value = |key: &str| number(of, key);
            let rate = value("updates_per_s");
            let range = value("slowest_updates_per_s")..=value("fastest_updates_per_s");
            expect(rate > 0.0 && range.contains(&rate), at("rate"));
            let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
            for (each, all, fraction, most) in [
                ("bytes_per_update", "bytes_per_s", "copy_fraction", "copy_bytes_per_s"),
                (
                    "operations_per_update",
                    "operations_per_s",
                    "arithmetic_fraction",
                    "operations_per_s",
                ),
            ] {
                expect(same(value(all), rate * value(each)), at(all));
                expect(same(value(fraction), value(all) / number(limit, most)), at(fraction));
                // Small states lie in caches, which are faster than memory, but not that much.
                expect(value(fraction) > 0.0 && value(fraction) < 100.0, at("no such fraction"));
            }
            let binding = of["bound_by"].as_str().unwrap_or_default();
            let key = format!("{binding}_fraction");
            let read = of["read_fraction"].as_f64();
            let most = limit["read_bytes_per_s"].as_f64();
            let expected = most.map(|most| rate * value("read_bytes_per_update") / most);
            let agrees = read.is_some() == expected.is_some()
                && read.zip(expected).is_none_or(|(a, b)| same(a, b));
            expect(agrees, at("read_fraction"));
            let largest = value("copy_fraction").max(value("arithmetic_fraction"));
            let largest = largest.max(read.unwrap_or_default());
            expect(value(&key) == largest && value("limit_fraction") == largest, at("limit"));
            // Two states at least, in f32 at least.
            expect(value("memory_bytes") >= 8.0 * value("particles"), at("memory"));
            expect(value("setup_s") > 0.0 && value("steps") >= 1.0, at("set-up or steps"));
        }
    }
    found
}

#[test]
fn the_cpu_is_measured_on_both_paths_at_every_size() {
    let report = report(&[&["--backend", "cpu"], &QUICK[..]].concat());
    assert_eq!((&report["bench_version"], &report["backend"]), (&2.into(), &"cpu".into()));
    assert_eq!((&report["threads"], &report["adapter"]), (&2.into(), &Value::Null));
    let names: Vec<String> = list(&report, "series").iter().map(name).collect();
    let expected = ["2 2.0", "2 3.0", "3 2.0", "3 3.0"];
    let expected =
        expected.iter().flat_map(|of| [format!("lattice f64 {of}"), format!("list f64 {of}")]);
    assert_eq!(names, expected.collect::<Vec<_>>());
    assert_eq!(list(&report, "left_out").len(), 0, "{report}");
    assert_eq!(list(&report, "warnings").len(), 0, "{report}");
    for series in list(&report, "series") {
        let particles = list(series, "measurements").iter().map(|of| number(of, "particles"));
        let expected = if series["dimension"] == 2 { [1024.0, 7921.0] } else { [1000.0, 8000.0] };
        assert_eq!(particles.collect::<Vec<_>>(), expected, "{}", name(series));
        assert_eq!(series["growth"]["exponent"], Value::Null, "both sizes are small");
        let bytes = number(&series["measurements"][1], "bytes_per_update");
        assert_eq!(series["path"] == "lattice", bytes == 16.0, "{bytes}");
    }
    assert_eq!(faults(&report), Vec::<String>::new());
    // Beside what a wrong fraction is, it may be the one that binds.
    for (key, least) in [("copy_fraction", 2), ("read_fraction", 1), ("limit_fraction", 1)] {
        let mut wrong = report.clone();
        wrong["series"][3]["measurements"][1][key] = 0.0.into();
        let found = faults(&wrong);
        assert!((least..=3).contains(&found.len()), "the check notices {key}: {found:?}");
    }
}

#[test]
fn a_gpu_is_measured_in_each_precision_that_it_has() {
    let flags = ["--backend", "gpu", "--sizes", "1e3", "--dimension", "3", "--seconds", "0.02"];
    let found = report(&[&flags[..], &["--support-ratio", "2"]].concat());
    assert_eq!(found["backend"], "gpu");
    assert!(found["adapter"].is_string());
    assert_eq!(faults(&found), Vec::<String>::new());
    let precisions: Vec<&Value> =
        list(&found, "limits").iter().map(|limit| &limit["precision"]).collect();
    assert!(precisions.contains(&&"f32".into()), "{precisions:?}");
    for precision in precisions {
        let of = |entries: &str, path: &str| {
            let is = |of: &&Value| of["path"] == path && of["precision"] == *precision;
            list(&found, entries).iter().find(is)
        };
        assert!(of("series", "list").is_some(), "no list in {precision}");
        // What is not measured is named, with the reason.
        let why = of("left_out", "lattice").and_then(|left| left["why"].as_str());
        let measured = of("series", "lattice").is_some();
        assert!(measured != why.is_some(), "lattice in {precision}: {why:?}");
    }
    let one = report(&[&flags[..], &["--precision", "f32", "--path", "list"]].concat());
    assert!(list(&one, "series").iter().all(|series| series["precision"] == "f32"));
    assert_eq!(list(&one, "left_out").len(), 0, "what was not asked for is not left out");
}

#[test]
fn what_does_not_fit_is_left_out_and_said_so() {
    let flags = ["--backend", "cpu", "--seconds", "0.02", "--dimension", "2"];
    let sizes = ["--support-ratio", "2", "--sizes", "1e3,4e9,1e12"];
    let found = report(&[&flags[..], &sizes].concat());
    assert!(list(&found, "series").iter().all(|of| list(of, "measurements").len() == 1));
    let left_out = list(&found, "left_out");
    assert_eq!(left_out.len(), 4, "{left_out:?}");
    for left in left_out {
        let why = left["why"].as_str().expect("a reason");
        let reason = if left["size"] == 4_000_000_000_u64 { "of memory" } else { "32 bits" };
        assert!(why.contains(reason), "{why}");
    }
    // No set-up is as short as that, so that the second size is left out for the first one's.
    let slow = ["--support-ratio", "2", "--sizes", "1e3,1e4", "--setup-seconds", "1e-9"];
    let found = report(&[&flags[..], &slow].concat());
    let left_out = list(&found, "left_out");
    assert_eq!(left_out.len(), 2, "{left_out:?}");
    for left in left_out {
        let why = left["why"].as_str().expect("a reason");
        assert!(left["size"] == 10_000 && why.contains("--setup-seconds"), "{left}");
    }
}

#[test]
fn the_tables_hold_what_the_report_holds() {
    let flags = ["--backend", "cpu", "--seconds", "0.02", "--dimension", "3", "--path", "lattice"];
    let output = bench(&[&flags[..], &["--sizes", "1e3,1e12", "--support-ratio", "2"]].concat());
    let table = text(&output.stdout);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    for part in [
        "cpu, 2 threads",
        "limits in f64: copy",
        "on one thread",
        "lattice, f64, 3-D, H/dx 2\n",
        "1 000",
        "of the limit",
        "left out\n  lattice, f64, 3-D, H/dx 2, 1e12: ",
    ] {
        assert!(table.contains(part), "no `{part}` in\n{table}");
    }
}

#[test]
fn bad_flags_are_refused_with_what_is_wrong() {
    for (flags, named) in [
        (&["--sizes", "12"][..], &["--sizes", "1000 at least"][..]),
        (&["--sizes", "1e4,many"], &["--sizes", "many", "not a number"]),
        (&["--sizes", "-1e4"], &["-1"]),
        (&["--sizes", "1000.5"], &["--sizes", "whole"]),
        (&["--dimension", "1"], &["--dimension", "2..=3"]),
        (&["--support-ratio", "1"], &["--support-ratio", "above 1"]),
        (&["--support-ratio", "nan"], &["--support-ratio", "above 1"]),
        (&["--seconds", "0"], &["--seconds", "above 0"]),
        (&["--path", "mesh"], &["--path", "lattice"]),
        (&["--backend", "cpu", "--precision", "f32"], &["--precision f32", "f64 only"]),
        (&["--adapter", "no such thing"], &["no such thing"]),
    ] {
        let output = bench(flags);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {message}");
        assert!(output.stdout.is_empty(), "{flags:?}: {}", text(&output.stdout));
        for part in named {
            assert!(message.contains(part), "{flags:?}: no `{part}` in {message}");
        }
    }
}
