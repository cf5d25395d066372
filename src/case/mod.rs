//! Case files: JSON to a validated scene.

use crate::exact::Solution;
use crate::model::Problem;

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
    /// The case with every override applied, for `case.json`.
    pub resolved: serde_json::Value,
    /// What the user should know about the case as resolved.
    pub warnings: Vec<String>,
}

/// A field of the output files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputField {
    /// The solution.
    Value,
    /// The exact solution.
    Exact,
    /// Numerical minus exact.
    Error,
    /// Summation density (18).
    Density,
}
