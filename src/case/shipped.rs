//! The cases that come with the program, embedded in it.

use include_dir::{Dir, include_dir};

use super::CaseError;

static CASES: Dir = include_dir!("$CARGO_MANIFEST_DIR/cases");

/// Name and title of every shipped case, by name.
pub fn shipped() -> Vec<(String, String)> {
    let mut cases: Vec<(String, String)> = CASES
        .files()
        .filter_map(|file| file.path().to_str()?.strip_suffix(".json"))
        .map(|name| (name.to_owned(), title(name)))
        .collect();
    cases.sort();
    cases
}

/// The text of a shipped case.
pub(super) fn text(name: &str) -> Option<&'static str> {
    CASES.get_file(format!("{name}.json"))?.contents_utf8()
}

/// The text of the shipped case `name`.
///
/// # Errors
/// [`CaseError::NotFound`], with the names that look like it.
pub fn shipped_text(name: &str) -> Result<&'static str, CaseError> {
    text(name).ok_or_else(|| not_found(name))
}

/// What to say of a name that is no shipped case.
pub(super) fn not_found(name: &str) -> CaseError {
    let names: Vec<String> = shipped().into_iter().map(|(name, _)| name).collect();
    CaseError::NotFound { text: name.to_owned(), nearest: super::error::nearest(name, &names, 3) }
}

fn title(name: &str) -> String {
    let json = text(name).and_then(|text| super::parse::parse(text).ok()).unwrap_or_default();
    json["title"].as_str().unwrap_or_default().to_owned()
}
