//! The arrows between modules run downward only.

use std::fs;
use std::path::{Path, PathBuf};

/// What each module may name of the crate; see the table in `src/lib.rs`.
const MAY_USE: [(&str, &[&str]); 8] = [
    ("cli", &["study", "case", "solver", "report", "gpu", "model"]),
    ("study", &["case", "solver", "exact", "report", "model"]),
    ("case", &["exact", "model"]),
    ("solver", &["gpu", "model"]),
    ("report", &["model"]),
    ("exact", &["model"]),
    ("gpu", &[]),
    ("model", &[]),
];

/// Crates that only some modules may name: no GPU in the physics, no printing layer below the
/// command line.
const ONLY_IN: [(&str, &[&str]); 5] = [
    ("wgpu", &["gpu"]),
    ("clap", &["cli"]),
    ("indicatif", &["cli"]),
    ("plotters", &["report"]),
    ("rustdct", &["study"]),
];

/// The modules that a line of `module` names against the rules.
fn forbidden<'a>(module: &str, may_use: &[&str], line: &'a str) -> Vec<&'a str> {
    let code = line.split("//").next().unwrap_or("");
    let of_crate = code.split("crate::").skip(1).map(first_name);
    let inside = of_crate.filter(|name| *name != module && !may_use.contains(name));
    let outside = ONLY_IN.iter().filter(|(_, modules)| !modules.contains(&module));
    let named = outside.filter(|(name, _)| code.contains(&format!("{name}::")));
    inside.chain(named.map(|(name, _)| *name)).collect()
}

/// The name that `text` starts with.
fn first_name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("source folder is readable") {
        let path = entry.expect("entry is readable").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

fn is_test(path: &Path) -> bool {
    path.components().any(|c| c.as_os_str().to_string_lossy().contains("tests"))
}

#[test]
fn modules_use_only_what_is_below_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut broken = Vec::new();
    for (module, may_use) in MAY_USE {
        let mut files = Vec::new();
        sources(&root.join(module), &mut files);
        assert!(!files.is_empty(), "{module} has no files");
        for path in files.iter().filter(|path| !is_test(path)) {
            let text = fs::read_to_string(path).expect("source is readable");
            for (number, line) in text.lines().enumerate() {
                for name in forbidden(module, may_use, line) {
                    broken.push(format!("{}:{}: {name}", path.display(), number + 1));
                }
            }
        }
    }
    assert!(broken.is_empty(), "forbidden arrows:\n{}", broken.join("\n"));
}

#[test]
fn every_module_of_the_crate_has_its_rules() {
    let lib = include_str!("../src/lib.rs");
    let modules = lib.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    let ruled: Vec<&str> = MAY_USE.iter().map(|(module, _)| *module).collect();
    let unruled: Vec<&str> = modules.filter(|module| !ruled.contains(module)).collect();
    assert!(unruled.is_empty(), "no rules for {unruled:?}");
}

#[test]
fn a_forbidden_line_is_noticed() {
    assert_eq!(forbidden("gpu", &[], "use crate::model::Problem;"), ["model"]);
    assert_eq!(forbidden("model", &[], "    let buffer: wgpu::Buffer;"), ["wgpu"]);
    assert_eq!(forbidden("report", &["model"], "use crate::solver::Backend;"), ["solver"]);
    assert!(
        forbidden("report", &["model"], "use crate::model::Problem; // crate::solver").is_empty()
    );
    assert!(forbidden("gpu", &[], "use crate::gpu::Device;").is_empty());
}
