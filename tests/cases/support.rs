//! Scenes from cases, for tests that run them.

use diffusph::case::{self, Override, Scene};
use serde_json::Value;

/// The shipped case `name` without outputs and probes on the way, and with these overrides.
pub(crate) fn shipped(name: &str, overrides: &[&str]) -> Scene {
    let own = ["output={}", "probes=[]"].iter().chain(overrides);
    let overrides: Vec<Override> =
        own.map(|text| Override::parse(text).expect("it is an override")).collect();
    case::load(name, &overrides).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The scene of `case`, or what is wrong with it.
pub(crate) fn load(case: &Value) -> Result<Scene, String> {
    case::from_json("test", case.clone(), &[]).map_err(|error| error.to_string())
}
