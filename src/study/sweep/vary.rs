//! What a study varies: `spacing=2,1,0.5`, `operator.pair_mean=harmonic,arithmetic`.

use serde::Deserialize;

use super::StudyError;
use crate::report::study::Setting;

/// Short names of what is varied most, and where it lies in a case.
const SHORT: [(&str, &str); 8] = [
    ("spacing", "particles.spacing"),
    ("support_ratio", "kernel.support_ratio"),
    ("kernel", "kernel.name"),
    ("correction", "operator.correction"),
    ("pair_mean", "operator.pair_mean"),
    ("method", "time.method"),
    ("step", "time.step"),
    ("tolerance", "time.tolerance.relative"),
];

/// Flags of a run that can be varied, and what they may be.
const FLAGS: [(&str, &[&str]); 3] = [
    ("backend", &["auto", "cpu", "gpu"]),
    ("precision", &["auto", "f32", "compensated", "f64"]),
    ("path", &["auto", "list", "lattice", "matrix-free"]),
];

/// Something that takes several values in a study.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Vary {
    /// Its name as reports have it.
    pub(super) name: String,
    /// Where it is set.
    pub(super) target: Target,
    /// The values, as they were written.
    pub(super) values: Vec<String>,
}

/// Where a value goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// To a path in the case.
    Case(String),
    /// To a flag of the run.
    Flag(&'static str),
}

impl Vary {
    /// Reads `name=value,value,...`. Commas within brackets and quotes belong to a value.
    ///
    /// # Errors
    /// A name or a value that means nothing, with the nearest that does.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let syntax = || StudyError::VarySyntax { text: text.to_owned() };
        let (name, values) = text.split_once('=').ok_or_else(syntax)?;
        let (name, values) = (name.trim(), split(values));
        if name.is_empty() || values.iter().any(String::is_empty) {
            return Err(syntax());
        }
        let target = target(name)?;
        if let Target::Flag(flag) = target {
            let known = FLAGS.iter().find(|(name, _)| *name == flag).map_or(&[][..], |of| of.1);
            for value in &values {
                if !known.contains(&value.as_str()) {
                    return Err(unknown(format!("--vary {name}"), value, known, ""));
                }
            }
        }
        let short = SHORT.iter().find(|(_, path)| target == Target::Case((*path).to_owned()));
        let name = short.map_or(name, |(short, _)| short).to_owned();
        Ok(Self { name, target, values })
    }

    /// A value, as the setting that a report names.
    pub(super) fn setting(&self, value: &str) -> Setting {
        Setting { name: self.name.clone(), value: value.to_owned() }
    }
}

impl TryFrom<String> for Vary {
    type Error = StudyError;

    fn try_from(text: String) -> Result<Self, StudyError> {
        Self::parse(&text)
    }
}

fn target(name: &str) -> Result<Target, StudyError> {
    if let Some((flag, _)) = FLAGS.iter().find(|(flag, _)| *flag == name) {
        return Ok(Target::Flag(flag));
    }
    if let Some((_, path)) = SHORT.iter().find(|(short, _)| *short == name) {
        return Ok(Target::Case((*path).to_owned()));
    }
    // A path is checked where the case is read.
    let path = name.replace('[', ".").replace(']', "");
    if path.contains('.') && !path.split('.').any(str::is_empty) {
        return Ok(Target::Case(path));
    }
    let known: Vec<&str> = SHORT.iter().map(|of| of.0).chain(FLAGS.iter().map(|of| of.0)).collect();
    let or = ", or a path in the case such as time.linear_tolerance";
    Err(unknown("--vary".to_owned(), name, &known, or))
}

/// A name that is none of the `known` ones, with the nearest of these; `or` is what else it may be.
fn unknown(what: String, text: &str, known: &[&str], or: &str) -> StudyError {
    /// Below this similarity (0 to 1) a suggestion would confuse.
    const SIMILAR: f64 = 0.7;
    // One slip is similar in the shortest of names too, where the measure is not of much use.
    let similarity = |name: &&&str| match strsim::osa_distance(text, name) {
        0 | 1 => 1.0,
        _ => strsim::jaro_winkler(text, name),
    };
    let nearest = known.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    let nearest = nearest.filter(|name| similarity(name) >= SIMILAR).map(|name| (*name).to_owned());
    let known = known.join(", ") + or;
    StudyError::UnknownName { what, text: text.to_owned(), nearest, known }
}

/// The values between the commas that are in no bracket and no quotes.
fn split(text: &str) -> Vec<String> {
    let (mut depth, mut quoted, mut start) = (0_i32, false, 0);
    let mut values = Vec::new();
    for (at, c) in text.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '(' | '[' | '{' if !quoted => depth += 1,
            ')' | ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                values.push(text[start..at].trim().to_owned());
                start = at + 1;
            }
            _ => {}
        }
    }
    values.push(text[start..].trim().to_owned());
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_names_flags_and_paths_are_known() {
        let vary = Vary::parse("spacing=2, 1,0.5").expect("a sweep");
        assert_eq!(vary.target, Target::Case("particles.spacing".to_owned()));
        assert_eq!(vary.values, ["2", "1", "0.5"]);
        let same = Vary::parse("particles.spacing=2,1,0.5").expect("a sweep");
        assert_eq!(same, vary, "one name for one thing");
        assert_eq!(Vary::parse("path=list").expect("a flag").target, Target::Flag("path"));
        let other = Vary::parse("particles.fill[0].material=a,b").expect("a path");
        assert_eq!(other.target, Target::Case("particles.fill.0.material".to_owned()));
    }

    #[test]
    fn commas_in_brackets_belong_to_a_value() {
        let values = |text: &str| Vary::parse(text).expect(text).values;
        assert_eq!(values(r#"exact.at={"a":[1,2]},3"#), [r#"{"a":[1,2]}"#, "3"]);
        assert_eq!(values("step=max(1,2),3"), ["max(1,2)", "3"]);
        assert_eq!(values(r#"title.x="a,b",c"#), [r#""a,b""#, "c"]);
    }

    #[test]
    fn bad_names_are_refused_with_the_nearest() {
        let message = |text| Vary::parse(text).expect_err(text).to_string();
        assert!(message("spacng=1").contains("did you mean \"spacing\"?"));
        assert!(message("metod=euler").contains("did you mean \"method\"?"));
        assert!(message("precision=f23").contains("did you mean \"f32\"?"));
        assert!(!message("colour=red").contains("did you mean"));
        for text in ["spacing", "=1", "spacing=", "spacing=1,,2"] {
            assert!(message(text).contains("written name=value,value"), "{text}");
        }
    }
}
