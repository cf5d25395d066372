//! Overrides of single keys from the command line.

use serde_json::{Map, Value};

use super::error::CaseError;

/// One `path.to.key=value`, applied to the JSON before it is read as a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// Keys joined by dots; a number is an index into a list: `particles.fill.0.material`.
    pub path: String,
    /// The new value. null leaves a key out only where a key that is left out has no value:
    /// `exact`, `time.step`, `time.tolerance`, `time.linear_tolerance`, the keys of `output`, of the entries of `initial`, and those of
    /// `exact` that may be left out. Elsewhere null is refused, also for keys with a
    /// default, such as `probes`, `time.method` or a material's `density`.
    pub value: Value,
}

impl Override {
    /// Reads `path.to.key=value`; the value is JSON if it parses, else a string. `fill[0]` may
    /// stand for `fill.0`, as in messages.
    pub fn parse(text: &str) -> Result<Self, CaseError> {
        let syntax = || CaseError::OverrideSyntax { text: text.to_owned() };
        let (path, value) = text.split_once('=').ok_or_else(syntax)?;
        let path = path.trim().replace('[', ".").replace(']', "");
        if path.split('.').any(str::is_empty) {
            return Err(syntax());
        }
        let value = serde_json::from_str(value).unwrap_or_else(|_| Value::String(value.to_owned()));
        Ok(Self { path, value })
    }

    /// Sets the value in `json`; objects that are missing on the way are made.
    pub(super) fn apply(&self, json: &mut Value) -> Result<(), CaseError> {
        let mut target = json;
        for segment in self.path.split('.') {
            target = self.descend(target, segment)?;
        }
        *target = self.value.clone();
        Ok(())
    }

    fn descend<'a>(&self, from: &'a mut Value, key: &str) -> Result<&'a mut Value, CaseError> {
        if from.is_null() {
            *from = Value::Object(Map::new());
        }
        let fail = |reason| Err(CaseError::OverridePath { path: self.path.clone(), reason });
        match from {
            Value::Object(map) => Ok(map.entry(key.to_owned()).or_insert(Value::Null)),
            Value::Array(list) => {
                let length = list.len();
                match key.parse::<usize>() {
                    Ok(index) if index < length => Ok(&mut list[index]),
                    Ok(index) => fail(format!("the list has {length} entries, none at {index}")),
                    Err(_) => fail(format!("\"{key}\" is no index into a list")),
                }
            }
            other => fail(format!("{other} has no part \"{key}\"")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn applied(text: &str) -> Result<Value, CaseError> {
        let mut value = json!({ "a": { "b": [1, { "c": 2 }] }, "n": 5 });
        Override::parse(text)?.apply(&mut value)?;
        Ok(value)
    }

    #[test]
    fn values_are_json_or_text() {
        assert_eq!(applied("n=6").expect("set")["n"], json!(6));
        assert_eq!(applied("n=2*year").expect("set")["n"], json!("2*year"));
        assert_eq!(applied("n=[1,2]").expect("set")["n"], json!([1, 2]));
        assert_eq!(applied("a.b.1.c=x=3").expect("set")["a"]["b"][1]["c"], json!("x=3"));
        assert_eq!(applied("a.b[1].c=7").expect("set")["a"]["b"][1]["c"], json!(7));
        assert_eq!(applied("p.q.r=1").expect("set")["p"], json!({ "q": { "r": 1 } }));
    }

    #[test]
    fn bad_overrides_name_themselves() {
        let message = |text| applied(text).expect_err(text).to_string();
        assert!(message("n").starts_with("\"n\": an override is written"));
        assert!(message("=3").starts_with("\"=3\":"));
        assert!(message("a..b=3").starts_with("\"a..b=3\":"));
        assert!(message("a.b.2=3").starts_with("a.b.2: cannot be set: the list has 2 entries"));
        assert!(message("a.b.c=3").contains("\"c\" is no index"));
        assert!(message("n.m=3").contains("5 has no part \"m\""));
    }
}
