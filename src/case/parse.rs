//! Text to JSON to the typed case, with errors that name the path.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, de};
use serde_json::{Map, Value};

use super::error::{CaseError, nearest};
use super::schema::Case;

/// Parses strict JSON: a key that an object has twice is an error.
pub(super) fn parse(text: &str) -> Result<Value, CaseError> {
    let failed = |path: String, reason: String| CaseError::Json { path, reason };
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(&mut deserializer, &mut track);
    let value = StrictSeed
        .deserialize(tracked)
        .map_err(|error| failed(written(&track.path()), error.to_string()))?;
    deserializer.end().map_err(|error| failed(String::new(), error.to_string()))?;
    Ok(value)
}

/// Reads the typed case.
pub(super) fn read(json: &Value) -> Result<Case, CaseError> {
    serde_path_to_error::deserialize(json)
        .map_err(|error| explain(json, &written(error.path()), &error.inner().to_string()))
}

/// A path as messages write it; empty at the top.
fn written(path: &serde_path_to_error::Path) -> String {
    let text = path.to_string();
    if text == "." { String::new() } else { text }
}

/// Turns serde's message into an error with values. What serde puts between backquotes are the
/// offending name and then the known ones.
fn explain(json: &Value, path: &str, message: &str) -> CaseError {
    let quoted: Vec<String> = message.split('`').skip(1).step_by(2).map(str::to_owned).collect();
    let first = quoted.first().cloned().unwrap_or_default();
    let known: Vec<String> = quoted.iter().skip(1).cloned().collect();
    let nearest = nearest(&first, &known, 1);
    if message.starts_with("unknown field") {
        let path = match only_inside(json, path, &|key, _| key == first) {
            Some(inside) => inside,
            None => below(path, &first),
        };
        return CaseError::UnknownKey { path, nearest, known };
    }
    if message.starts_with("missing field") {
        return CaseError::MissingKey { path: join(path, &first) };
    }
    if message.starts_with("unknown variant") {
        let found = lookup(json, path);
        if found.is_some_and(|value| value.get(&first).is_some()) {
            return CaseError::UnknownKey { path: join(path, &first), nearest, known };
        }
        let tagged = found.and_then(|value| value.get("name")).is_some_and(|tag| *tag == *first);
        let path = match only_inside(json, path, &|_, value| *value == *first) {
            _ if tagged => join(path, "name"),
            Some(inside) => inside,
            None => path.to_owned(),
        };
        return CaseError::UnknownName { path, text: first, nearest, known };
    }
    wrong_type(path, message)
}

/// A value of the wrong type. A name that stands alone where it must be the key of an object, and
/// one that is a key where it must stand alone, are known to serde by the path of that key.
fn wrong_type(path: &str, message: &str) -> CaseError {
    if let Some((parent, name)) = path.rsplit_once('.') {
        let path = parent.to_owned();
        if message.starts_with("invalid type: unit variant") {
            let reason = format!("\"{name}\" cannot stand alone: write {{\"{name}\": ...}}");
            return CaseError::WrongType { path, reason };
        }
        if message.ends_with("expected unit") {
            let reason = format!("\"{name}\" takes nothing: write \"{name}\"");
            return CaseError::WrongType { path, reason };
        }
    }
    let path = if path.is_empty() { "case" } else { path }.to_owned();
    let reason = match message.ends_with("expected map with a single key") {
        true => "expected one key, found several or none".to_owned(),
        false => message.replace('`', ""),
    };
    CaseError::WrongType { path, reason }
}

/// The path of the only key and value inside of the value at `path` that are `wanted`: serde knows what is
/// in a tagged object by the path of that object.
fn only_inside(json: &Value, path: &str, wanted: &dyn Fn(&str, &Value) -> bool) -> Option<String> {
    let mut found = Vec::new();
    search(lookup(json, path)?, path, wanted, &mut found);
    if found.len() == 1 { found.pop() } else { None }
}

fn search(
    value: &Value,
    path: &str,
    wanted: &dyn Fn(&str, &Value) -> bool,
    found: &mut Vec<String>,
) {
    match value {
        Value::Object(entries) => {
            for (key, entry) in entries {
                let path = join(path, key);
                search(entry, &path, wanted, found);
                if wanted(key, entry) {
                    found.push(path);
                }
            }
        }
        Value::Array(entries) => {
            for (index, entry) in entries.iter().enumerate() {
                search(entry, &format!("{path}[{index}]"), wanted, found);
            }
        }
        _ => {}
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// `path.key`, unless the path ends with the key already.
fn below(path: &str, key: &str) -> String {
    let ends_with_key = path.rsplit('.').next() == Some(key);
    if ends_with_key { path.to_owned() } else { join(path, key) }
}

fn lookup<'a>(json: &'a Value, path: &str) -> Option<&'a Value> {
    let path = path.replace('[', ".").replace(']', "");
    path.split('.').filter(|segment| !segment.is_empty()).try_fold(json, |value, segment| {
        match segment.parse::<usize>() {
            Ok(index) if value.is_array() => value.get(index),
            _ => value.get(segment),
        }
    })
}

/// A JSON value whose objects have no key twice.
struct Strict(Value);

struct StrictSeed;

impl<'de> DeserializeSeed<'de> for StrictSeed {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        Strict::deserialize(deserializer).map(|strict| strict.0)
    }
}

impl<'de> Deserialize<'de> for Strict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StrictVisitor).map(Strict)
    }
}

struct StrictVisitor;

impl<'de> Visitor<'de> for StrictVisitor {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E: de::Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E: de::Error>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Strict(value)) = access.next_element()? {
            list.push(value);
        }
        Ok(list.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some((key, Strict(value))) = access.next_entry::<String, Strict>()? {
            if map.contains_key(&key) {
                return Err(A::Error::custom(format!("the key \"{key}\" is given twice")));
            }
            map.insert(key, value);
        }
        Ok(map.into())
    }
}
