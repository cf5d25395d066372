//! One run in a process of its own.

use std::io::Read;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::report::RunReport;

/// How often a running process is looked at.
const LOOK: Duration = Duration::from_millis(4);

/// How a run ended.
#[derive(Debug)]
pub(super) enum Ended {
    /// With its report, after so long.
    Done(Box<RunReport>, Duration),
    /// With a message.
    Failed(String),
    /// It was stopped, since its time was over.
    OutOfTime,
    /// It was stopped, since the user asked for that.
    Interrupted,
}

/// Runs `program` with `arguments`, until `deadline` at most; `tick` is asked whether to go on.
///
/// # Errors
/// Where no process can be started.
pub(super) fn run(
    program: &Path,
    arguments: &[String],
    deadline: Instant,
    tick: &mut dyn FnMut() -> ControlFlow<()>,
) -> std::io::Result<Ended> {
    let started = Instant::now();
    let mut child = Command::new(program)
        .args(arguments)
        .arg("--json")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    // Both pipes are read while it runs: a full one would stop it.
    let out = reader(child.stdout.take());
    let messages = reader(child.stderr.take());
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if tick().is_break() {
            return stop(&mut child).map(|()| Ended::Interrupted);
        }
        if Instant::now() > deadline {
            return stop(&mut child).map(|()| Ended::OutOfTime);
        }
        thread::sleep(LOOK);
    };
    let took = started.elapsed();
    let text = |handle: thread::JoinHandle<Vec<u8>>| {
        String::from_utf8_lossy(&handle.join().unwrap_or_default()).into_owned()
    };
    let (out, messages) = (text(out), text(messages));
    if !status.success() {
        return Ok(Ended::Failed(message(&messages, &status.to_string())));
    }
    Ok(match serde_json::from_str(&out) {
        Ok(report) => Ended::Done(Box::new(report), took),
        Err(error) => Ended::Failed(format!("its report cannot be read: {error}")),
    })
}

fn stop(child: &mut Child) -> std::io::Result<()> {
    // It may have ended by itself in the meantime.
    let _ = child.kill();
    child.wait().map(|_| ())
}

fn reader(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // What could be read before a failure is the best there is.
            let _ = pipe.read_to_end(&mut bytes);
        }
        bytes
    })
}

/// The error among what a run printed.
fn message(printed: &str, status: &str) -> String {
    let errors = printed.lines().filter_map(|line| line.strip_prefix("diffusph: "));
    let error = errors.rev().find(|line| !line.starts_with("warning: "));
    error.map_or_else(|| format!("it ended with {status}"), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_told_from_warnings() {
        let printed = "diffusph: warning: a\nother\ndiffusph: it broke\ndiffusph: warning: b\n";
        assert_eq!(message(printed, "x"), "it broke");
        assert_eq!(
            message("diffusph: warning: a\n", "exit status: 101"),
            "it ended with exit status: 101"
        );
    }

    #[test]
    #[cfg(unix)]
    fn a_process_is_stopped_at_its_deadline_and_when_asked() {
        let sleep = ["-c", "sleep 20"].map(str::to_owned);
        let shell = Path::new("/bin/sh");
        let started = Instant::now();
        let soon = started + Duration::from_millis(50);
        let ended = run(shell, &sleep, soon, &mut || ControlFlow::Continue(())).expect("it starts");
        assert!(matches!(ended, Ended::OutOfTime), "{ended:?}");
        let late = started + Duration::from_secs(60);
        let ended = run(shell, &sleep, late, &mut || ControlFlow::Break(())).expect("it starts");
        assert!(matches!(ended, Ended::Interrupted), "{ended:?}");
        assert!(started.elapsed() < Duration::from_secs(10));
        let fails = ["-c", "echo 'diffusph: no' >&2; exit 3"].map(str::to_owned);
        let ended = run(shell, &fails, late, &mut || ControlFlow::Continue(())).expect("it starts");
        assert!(matches!(&ended, Ended::Failed(why) if why == "no"), "{ended:?}");
    }
}
