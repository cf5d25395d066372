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
    depends_on_position: bool,
    depends_on_time: bool,
}

impl ScalarField {
    /// A field from a function; `text` is what messages and reports call it.
    pub fn new(
        text: impl Into<Arc<str>>,
        function: impl Fn(DVec3, f64) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self {
            text: text.into(),
            function: Arc::new(function),
            depends_on_position: true,
            depends_on_time: true,
        }
    }

    /// The same number everywhere and always.
    pub fn constant(value: f64) -> Self {
        Self::new(value.to_string(), move |_, _| value).depending_on(false, false)
    }

    /// The same field, known to depend on position or time only where said so. Who evaluates it
    /// saves what does not change.
    pub fn depending_on(mut self, position: bool, time: bool) -> Self {
        self.depends_on_position = position;
        self.depends_on_time = time;
        self
    }

    /// The value at position `x` (m) and time `t` (s).
    pub fn at(&self, x: DVec3, t: f64) -> f64 {
        (self.function)(x, t)
    }

    /// The number that it is everywhere and always; `None` if it is not.
    pub fn as_constant(&self) -> Option<f64> {
        let is_constant = !(self.depends_on_position || self.depends_on_time);
        is_constant.then(|| self.at(DVec3::ZERO, 0.0))
    }

    /// How the user wrote it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether the value may differ from place to place.
    pub fn depends_on_position(&self) -> bool {
        self.depends_on_position
    }

    /// Whether the value may change in time.
    pub fn depends_on_time(&self) -> bool {
        self.depends_on_time
    }
}

impl fmt::Debug for ScalarField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ScalarField({:?})", self.text)
    }
}
