//! The settings of a study: every combination of what is varied.

use serde::Deserialize;

use super::vary::{Target, Vary};
use super::{StudyError, StudyOptions};
use crate::case::{self, CaseError, Override, Scene};
use crate::report::study::{ReferenceLaw, Setting};

/// A part of a study: every combination of what it varies, with what it sets.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Sweep {
    /// What it is called in reports, where there are several.
    pub(super) name: Option<String>,
    /// What it changes in the case, as `--set` has it.
    pub(super) set: Vec<String>,
    /// What it varies, as `--vary` has it.
    pub(super) vary: Vec<Vary>,
    /// What is known elsewhere of the error of what it runs.
    pub(super) reference_laws: Vec<ReferenceLaw>,
}

/// A setting before it runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Candidate {
    pub(super) settings: Vec<Setting>,
    /// `path=value` for every change of the case.
    pub(super) set: Vec<String>,
    /// Flags of the run and their values.
    pub(super) flags: Vec<(String, String)>,
}

impl Candidate {
    /// The arguments of the run.
    pub(super) fn arguments(&self, case: &str) -> Vec<String> {
        let mut arguments = vec!["run".to_owned(), case.to_owned()];
        for change in &self.set {
            arguments.extend(["--set".to_owned(), change.clone()]);
        }
        for (flag, value) in &self.flags {
            arguments.extend([format!("--{flag}"), value.clone()]);
        }
        arguments.push("--no-output".to_owned());
        arguments
    }

    /// The command as one would type it.
    pub(super) fn command(&self, case: &str) -> String {
        let arguments = self.arguments(case);
        let quoted = arguments.iter().map(|argument| quoted(argument));
        format!("diffusph {}", quoted.collect::<Vec<_>>().join(" "))
    }

    /// The scene that it runs.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn load(&self, case: &str) -> Result<Scene, CaseError> {
        let overrides = self.set.iter().map(|text| Override::parse(text));
        case::load(case, &overrides.collect::<Result<Vec<_>, _>>()?)
    }

    /// The value of a flag of the run.
    pub(super) fn flag(&self, name: &str) -> Option<&str> {
        self.flags.iter().find(|(flag, _)| flag == name).map(|(_, value)| &**value)
    }
}

/// `text` as a POSIX shell takes it for one word.
fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-+=./:,@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// Every combination of what the sweeps vary, each once.
pub(super) fn candidates(sweeps: &[Sweep], options: &StudyOptions<'_>) -> Vec<Candidate> {
    let mut all: Vec<Candidate> = Vec::new();
    for sweep in sweeps {
        let named = sweep.name.iter();
        let settings =
            named.map(|name| Setting { name: "sweep".to_owned(), value: name.clone() }).collect();
        let mut set = options.set.clone();
        set.extend(sweep.set.iter().cloned());
        let flags = options.flags.clone();
        let mut combined = vec![Candidate { settings, set, flags }];
        for vary in &sweep.vary {
            combined = combined.iter().flat_map(|of| with_each(of, vary)).collect();
        }
        for candidate in combined {
            let is_same =
                |of: &Candidate| (&of.set, &of.flags) == (&candidate.set, &candidate.flags);
            if !all.iter().any(is_same) {
                all.push(candidate);
            }
        }
    }
    all
}

/// `candidate` with each value of `vary`.
fn with_each(candidate: &Candidate, vary: &Vary) -> Vec<Candidate> {
    let with = |value: &String| {
        let mut one = candidate.clone();
        one.settings.push(vary.setting(value));
        match &vary.target {
            Target::Case(path) => one.set.push(format!("{path}={value}")),
            Target::Flag(flag) => {
                one.flags.retain(|(name, _)| name != flag);
                one.flags.push(((*flag).to_owned(), value.clone()));
            }
        }
        one
    };
    vary.values.iter().map(with).collect()
}

/// Refuses a study in which some value of what is varied works with nothing else: it is misspelt, or
/// not for this case. `loaded` says what was wrong with each candidate.
///
/// # Errors
/// The first one's fault.
pub(super) fn check(
    candidates: &[Candidate],
    loaded: Vec<Result<(), CaseError>>,
) -> Result<Vec<Option<String>>, StudyError> {
    let is_ok: Vec<bool> = loaded.iter().map(Result::is_ok).collect();
    let works = |setting: &Setting| {
        let with = candidates.iter().zip(&is_ok).filter(|(of, _)| of.settings.contains(setting));
        with.into_iter().any(|(_, ok)| *ok)
    };
    let mut faults = Vec::new();
    for (candidate, result) in candidates.iter().zip(loaded) {
        match result {
            Ok(()) => faults.push(None),
            Err(error) if candidate.settings.iter().all(works) => {
                faults.push(Some(error.to_string()));
            }
            Err(error) => return Err(error.into()),
        }
    }
    if !is_ok.contains(&true) {
        return Err(StudyError::Nothing);
    }
    Ok(faults)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_quoted_for_a_shell() {
        let candidate = Candidate {
            settings: Vec::new(),
            set: vec!["time.step=2*year".to_owned(), "exact={\"name\":\"it's\"}".to_owned()],
            flags: vec![("path".to_owned(), "list".to_owned())],
        };
        assert_eq!(
            candidate.command("my case.json"),
            r#"diffusph run 'my case.json' --set 'time.step=2*year' --set 'exact={"name":"it'\''s"}' --path list --no-output"#
        );
    }
}
