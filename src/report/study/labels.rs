//! What points and series are called.

use super::{Point, Setting, StudyReport};
use crate::report::format::significant;

/// What `settings` are called, in short: values alone where they say what they are.
pub fn label(settings: &[Setting], spacing: f64) -> String {
    let parts: Vec<String> = settings.iter().map(|setting| short(setting, spacing)).collect();
    if parts.is_empty() { "as it is".to_owned() } else { parts.join(", ") }
}

fn short(Setting { name, value }: &Setting, spacing: f64) -> String {
    match (name.as_str(), value.as_str()) {
        ("spacing", _) => format!("dx {}", significant(spacing, 4)),
        ("correction", "none") => "plain".to_owned(),
        ("correction", "moment") => "corrected".to_owned(),
        ("sweep" | "method" | "kernel" | "backend" | "precision" | "path", _) => value.clone(),
        ("support_ratio", _) => format!("H/dx {value}"),
        ("step", _) if value.parse::<f64>().is_ok() => format!("step {value} s"),
        _ => format!("{name} {value}"),
    }
}

impl Point {
    /// What it shares with points that differ from it in `varies` alone.
    pub fn series(&self, varies: &str) -> String {
        self.beside(&[varies])
    }

    /// What it shares with points that differ from it in how fine they are: in space or in time.
    pub(super) fn kind(&self) -> String {
        self.beside(&["spacing", "step", "tolerance"])
    }

    fn beside(&self, varied: &[&str]) -> String {
        let same = |setting: &&Setting| !varied.contains(&&*setting.name);
        let settings: Vec<Setting> = self.settings.iter().filter(same).cloned().collect();
        label(&settings, self.spacing)
    }
}

impl StudyReport {
    /// What `name` calls the points, in their order.
    pub(super) fn names(&self, name: impl Fn(&Point) -> String) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for (point, _) in self.measured() {
            let name = name(point);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}
