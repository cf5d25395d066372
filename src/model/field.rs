//! A scalar function of position and time.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

type Function = dyn Fn(DVec3, f64) -> f64 + Send + Sync;

/// A scalar function of position (m) and time (s), cheap to clone and shared between threads.
///
/// The case file's expressions become one of these, so that nothing below the case module knows
/// which library parses them.
#[derive(Clone)]
pub struct ScalarField {
    text: Arc<str>,
    function: Arc<Function>,
}

impl ScalarField {
    /// A field from a function; `text` is what messages and reports call it.
    pub fn new(
        text: impl Into<Arc<str>>,
        function: impl Fn(DVec3, f64) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self { text: text.into(), function: Arc::new(function) }
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        (self.function)(x, t)
    }

    /// How the user wrote it.
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl fmt::Debug for ScalarField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ScalarField({:?})", self.text)
    }
}
