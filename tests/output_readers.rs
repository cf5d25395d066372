//! What the library writes is what other programs read: pyvista and meshio, bit for bit.
//!
//! Needs a Python with the modules of `tests/readers/requirements.txt`, named by the environment
//! variable `DIFFUSPH_PYTHON` (default `python3`). Without it the tests fail: they do not skip.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

use diffusph::report::SeriesWriter;
use glam::DVec3;
use serde_json::{Value, json};

/// One output of a series.
#[derive(Clone)]
struct Output {
    time: f64,
    positions: Vec<DVec3>,
    fields: Vec<(&'static str, Vec<f64>)>,
}

/// Particles of the given dimension, with numbers that any rounding on the way would change.
fn output(time: f64, count: usize, dimension: usize) -> Output {
    let number = |i: usize, k: f64| (1.0 + i as f64 * k).ln() / 3.0 - 0.1;
    let position = |i: usize| {
        let on = |axis: usize, k: f64| if axis < dimension { number(i, k) } else { 0.0 };
        DVec3::new(on(0, 0.37), on(1, 1.7e-5), on(2, 1e9))
    };
    let mut value: Vec<f64> = (0..count).map(|i| number(i, 1e-3 * time + 0.2)).collect();
    // The numbers that a text format would be likely to lose.
    for (slot, odd) in value.iter_mut().skip(1).zip([-0.0, 5e-324, 1e300, f64::INFINITY]) {
        *slot = odd;
    }
    let density = (0..count).map(|i| 1000.0 * number(i, 0.011)).collect();
    let fields = vec![("value", value), ("density <kg/m3> & \"more\"", density)];
    Output { time, positions: (0..count).map(position).collect(), fields }
}

fn write(folder: &Path, outputs: &[Output]) {
    let mut series = SeriesWriter::new(folder);
    for output in outputs {
        let fields: Vec<(&str, &[f64])> =
            output.fields.iter().map(|(name, values)| (*name, values.as_slice())).collect();
        series.write(output.time, &output.positions, &fields).unwrap();
    }
}

/// What both readers find in `folder`.
fn read(folder: &Path) -> Value {
    let python = std::env::var("DIFFUSPH_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/readers/read_output.py");
    let ran = Command::new(&python).arg(script).arg(folder).output();
    let ran = ran.unwrap_or_else(|e| {
        panic!("cannot start {python} ({e}): run tests/run.sh, which installs them")
    });
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(
        !said.contains("ModuleNotFoundError"),
        "{python} lacks pyvista or meshio: run tests/run.sh, which installs them\n{said}"
    );
    assert!(ran.status.success(), "a reader failed on {}:\n{said}", folder.display());
    serde_json::from_slice(&ran.stdout).unwrap()
}

fn bits(values: impl IntoIterator<Item = f64>) -> Vec<String> {
    values.into_iter().map(|x| format!("{:016x}", x.to_bits())).collect()
}

/// What both readers must find in the outputs.
fn expected(outputs: &[Output]) -> Value {
    let content = |output: &Output| {
        let count = output.positions.len();
        let fields: serde_json::Map<String, Value> = output
            .fields
            .iter()
            .map(|(name, values)| ((*name).to_owned(), json!(bits(values.iter().copied()))))
            .collect();
        json!({
            "positions": bits(output.positions.iter().flat_map(|p| p.to_array())),
            "fields": fields,
            "cell_types": vec![1; count],
            "connectivity": (0..count).collect::<Vec<_>>(),
        })
    };
    let content: Vec<Value> = outputs.iter().map(content).collect();
    let files: Vec<String> = (0..outputs.len()).map(|i| format!("particles_{i:04}.vtu")).collect();
    json!({
        "times": bits(outputs.iter().map(|output| output.time)),
        "files": files,
        "pyvista": content,
        "meshio": content,
    })
}

/// Writes the outputs, and returns what was read and what should have been.
fn there_and_back(outputs: &[Output]) -> (Value, Value) {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), outputs);
    (read(folder.path()), expected(outputs))
}

#[test]
fn both_readers_find_every_number_and_notice_a_changed_one() {
    // More particles than the writer generates cells for at a time.
    let outputs = [output(0.0, 20_000, 3), output(0.1 + 0.2, 20_000, 3), output(6.3072e7, 7, 3)];
    let (found, wanted) = there_and_back(&outputs);
    assert!(found == wanted, "what was read differs from what was written");

    let differs = |change: fn(&mut [Output])| {
        let mut changed = outputs.clone();
        change(&mut changed);
        found != expected(&changed)
    };
    assert!(differs(|o| o[1].positions[777].y = o[1].positions[777].y.next_up()));
    assert!(differs(|o| o[0].fields[0].1[1] = 0.0), "-0.0 is not 0.0");
    assert!(differs(|o| o[2].fields[1].1[6] = o[2].fields[1].1[6].next_up()));
    assert!(differs(|o| o[1].time = 0.3));
}

#[test]
fn one_particle_and_fewer_dimensions_are_read_too() {
    for (count, dimension) in [(1, 3), (50, 1), (50, 2)] {
        let (found, wanted) = there_and_back(&[output(1.0, count, dimension)]);
        assert!(found == wanted, "{count} particles in {dimension}-D");
    }
}

#[test]
fn what_the_command_writes_is_read_alike_by_both() {
    let folder = tempfile::tempdir().unwrap();
    let ran = Command::new(env!("CARGO_BIN_EXE_diffusph"))
        .args(["run", "gaussian_small", "--backend", "cpu", "--json", "--out"])
        .arg(folder.path())
        .output()
        .unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let report: Value = serde_json::from_slice(&ran.stdout).unwrap();
    let found = read(folder.path());
    assert_eq!(found["times"], json!(bits([0.0, 63_072_000.0])));
    assert!(found["pyvista"] == found["meshio"], "the readers differ");
    // The probe sits on a particle, so its value is one of the field's.
    let probe = bits([report["probes"][0]["value"].as_f64().unwrap()]);
    let last = &found["pyvista"][1]["fields"]["value"];
    assert!(last.as_array().unwrap().contains(&json!(probe[0])), "the probe's value is missing");
}
