//! The progress bar, and Ctrl-C.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::CliError;
use crate::solver::Progress;

/// Shows where a run is, on standard error and only to a terminal, and stops it on Ctrl-C.
pub(super) struct Monitor {
    bar: ProgressBar,
    interrupted: Arc<AtomicBool>,
}

impl Monitor {
    /// A monitor; a `quiet` one only listens for Ctrl-C.
    pub(super) fn new(quiet: bool) -> Result<Self, CliError> {
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        ctrlc::set_handler(move || {
            // The first asks the run to stop at a step; a second does not wait for one.
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(1);
            }
        })?;
        // Drawn to standard error, and hidden by the library where that is no terminal.
        let target =
            if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(None, target).with_style(style(STEPS));
        Ok(Self { bar, interrupted })
    }

    /// Takes note of where the run is.
    pub(super) fn update(&self, progress: Progress) -> ControlFlow<()> {
        self.bar.set_length(progress.steps);
        self.bar.set_position(progress.step);
        self.flow()
    }

    /// Takes note that `done` of `all` parts are done, and of what comes next.
    pub(super) fn at(&self, done: u64, all: u64, next: String) -> ControlFlow<()> {
        if self.bar.length().is_none() {
            self.bar.set_style(style(PARTS));
        }
        self.bar.set_length(all);
        self.bar.set_position(done);
        self.bar.set_message(next);
        self.bar.tick();
        self.flow()
    }

    /// Whether the user has asked to stop.
    pub(super) fn flow(&self) -> ControlFlow<()> {
        match self.interrupted.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// A bar over the steps of a run.
const STEPS: &str =
    "{bar:32} {percent:>3} %  step {human_pos} of {human_len}  {per_sec}  ETA {eta}";

/// A bar over parts that have names and differ in length.
const PARTS: &str = "{bar:32} {human_pos} of {human_len}  {elapsed}  {msg}";

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
