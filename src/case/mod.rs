//! Case files: JSON to a validated scene.
//!
//! The way of a case: text to JSON without duplicate keys, overrides, the typed case
//! ([`schema()`] describes it), keys that nothing uses, then numbers, shapes and particles.

mod boundary;
mod build;
mod error;
mod exact;
mod expression;
mod fill;
mod geometry;
mod initial;
mod material;
mod number;
mod overrides;
mod parse;
mod plan;
mod schema;
mod shape;
mod shipped;
mod source;
mod thermal;
mod unused;
mod wall;

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::exact::Solution;
use crate::model::Problem;

pub use error::CaseError;
pub use overrides::Override;
pub use schema::schema;
pub use shipped::{shipped, shipped_text};
pub use wall::WallError;

/// A case ready to run.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The shipped case's name, or the file's stem.
    pub name: String,
    /// The case's title.
    pub title: String,
    /// What is solved.
    pub problem: Problem,
    /// What the result is compared with.
    pub exact: Option<Solution>,
    /// Fields to write, e.g. `value`.
    pub fields: Vec<OutputField>,
    /// The case with every override applied and every default filled in, for `case.json`: running
    /// it repeats the run.
    pub resolved: serde_json::Value,
    /// What the user should know about the case as resolved.
    pub warnings: Vec<String>,
}

/// A field of the output files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OutputField {
    /// The solution.
    Value,
    /// The exact solution.
    Exact,
    /// Numerical minus exact.
    Error,
    /// Summation density (18).
    Density,
    /// Enthalpy of a unit volume, J/m3: capacity x value where neither changes.
    Enthalpy,
    /// How much is liquid, 0 to 1.
    LiquidFraction,
}

/// Loads a case: `source` is a file if it has a path separator or ends with `.json`, else the name
/// of a shipped case, else a file.
pub fn load(source: &str, overrides: &[Override]) -> Result<Scene, CaseError> {
    let is_path = source.contains(['/', std::path::MAIN_SEPARATOR]) || source.ends_with(".json");
    if !is_path {
        if let Some(text) = shipped::text(source) {
            return from_text(source, text, overrides);
        }
        if !Path::new(source).is_file() {
            return Err(shipped::not_found(source));
        }
    }
    let file = Path::new(source);
    let text = std::fs::read_to_string(file)
        .map_err(|source| CaseError::Unreadable { file: file.to_owned(), source })?;
    let name = file.file_stem().map_or(source.into(), |stem| stem.to_string_lossy());
    from_text(&name, &text, overrides)
}

/// Reads a case from its text; `name` is what reports call it.
pub fn from_text(name: &str, text: &str, overrides: &[Override]) -> Result<Scene, CaseError> {
    from_json(name, parse::parse(text)?, overrides)
}

/// Reads a case from JSON; `name` is what reports call it.
pub fn from_json(
    name: &str,
    json: serde_json::Value,
    overrides: &[Override],
) -> Result<Scene, CaseError> {
    let mut changed = json.clone();
    for entry in overrides {
        entry.apply(&mut changed)?;
    }
    let mut case = parse::read(&changed)?;
    let warnings = unused::remove(&mut case, &json, overrides)?;
    build::build(name, case, warnings)
}

#[cfg(test)]
mod tests;
