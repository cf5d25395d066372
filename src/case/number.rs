//! Numbers and points of a case file, and what their expressions may use.

use glam::DVec3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::error::CaseError;
use super::expression::{Expression, Meaning, function_names};
use crate::model::ScalarField;

/// Names of the axes.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

const CONSTANTS: [(&str, f64); 4] =
    [("pi", std::f64::consts::PI), ("year", 31_536_000.0), ("day", 86_400.0), ("hour", 3_600.0)];

/// A JSON number or an expression, kept as written. Its type is checked where it is evaluated, so
/// that the message can name the path even inside a tagged object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Number(pub(super) Value);

impl From<f64> for Number {
    fn from(value: f64) -> Self {
        Self(value.into())
    }
}

impl JsonSchema for Number {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Number".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": format!(
                "A number in SI units, or an expression as a string: + - * / ^ and parentheses; \
                 pi, year (31536000 s), day, hour, spacing (m); x y z (m) and t (s) where the \
                 value may depend on them; functions {}.",
                function_names()
            ),
            "type": ["number", "string"]
        })
    }
}

/// A point or vector, kept as written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Point(pub(super) Value);

impl JsonSchema for Point {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Point".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A point or vector: one number for each of the case's dimensions.",
            "type": "array",
            "items": generator.subschema_for::<Number>(),
            "minItems": 1,
            "maxItems": 3
        })
    }
}

/// What a number may depend on.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Dependence {
    Nothing,
    Position,
    PositionAndTime,
    Temperature,
}

impl Dependence {
    fn is_on_position(self) -> bool {
        matches!(self, Self::Position | Self::PositionAndTime)
    }
}

/// A number that may depend on temperature, K.
pub(super) enum OfTemperature {
    /// It does not.
    Constant(f64),
    /// What it is at a temperature, which need not be finite.
    Function(Box<dyn Fn(f64) -> f64>),
}

/// Turns what is written into numbers, with the names that the case gives a meaning to.
#[derive(Clone, Copy)]
pub(super) struct Evaluator {
    /// 1, 2 or 3.
    pub(super) dimension: usize,
    /// Value of `spacing`, m; `None` while the spacing itself is read.
    pub(super) spacing: Option<f64>,
}

impl Evaluator {
    /// A number that depends on nothing.
    pub(super) fn number(&self, path: &str, number: &Number) -> Result<f64, CaseError> {
        let value = match &number.0 {
            Value::String(text) => {
                let expression = self.parse(path, text, Dependence::Nothing)?;
                expression.eval(DVec3::ZERO, 0.0)
            }
            other => literal(path, other)?,
        };
        self.finite(path, &number.0, value, Dependence::Nothing)
    }

    /// A positive number.
    pub(super) fn positive(&self, path: &str, number: &Number) -> Result<f64, CaseError> {
        let value = self.number(path, number)?;
        in_range(path, value, value > 0.0, "positive")
    }

    /// A number that is not negative.
    pub(super) fn not_negative(&self, path: &str, number: &Number) -> Result<f64, CaseError> {
        let value = self.number(path, number)?;
        in_range(path, value, value >= 0.0, "zero or positive")
    }

    /// A point or vector of the case's dimension; the other axes are 0.
    pub(super) fn point(&self, path: &str, point: &Point) -> Result<DVec3, CaseError> {
        let Value::Array(entries) = &point.0 else {
            return Err(wrong_type(path, "a list of numbers", &point.0));
        };
        if entries.len() != self.dimension {
            let (path, found) = (path.to_owned(), entries.len());
            return Err(CaseError::Components { path, found, dimension: self.dimension });
        }
        let mut vector = DVec3::ZERO;
        for (axis, entry) in entries.iter().enumerate() {
            vector[axis] = self.number(&format!("{path}[{axis}]"), &Number(entry.clone()))?;
        }
        Ok(vector)
    }

    /// A number that may depend on position.
    pub(super) fn field(&self, path: &str, number: &Number) -> Result<Field, CaseError> {
        self.field_of(path, number, Dependence::Position)
    }

    /// A number that may depend on position and time.
    pub(super) fn field_in_time(&self, path: &str, number: &Number) -> Result<Field, CaseError> {
        self.field_of(path, number, Dependence::PositionAndTime)
    }

    /// A number that may depend on temperature.
    pub(super) fn of_temperature(
        &self,
        path: &str,
        number: &Number,
    ) -> Result<OfTemperature, CaseError> {
        let Value::String(text) = &number.0 else {
            return Ok(OfTemperature::Constant(self.number(path, number)?));
        };
        let expression = self.parse(path, text, Dependence::Temperature)?;
        Ok(match expression.constant() {
            Some(_) => OfTemperature::Constant(self.number(path, number)?),
            None => OfTemperature::Function(Box::new(move |temperature| {
                expression.eval(DVec3::ZERO, temperature)
            })),
        })
    }

    fn field_of(
        &self,
        path: &str,
        number: &Number,
        dependence: Dependence,
    ) -> Result<Field, CaseError> {
        let source = Source { path: path.to_owned(), evaluator: *self, dependence };
        let (scalar, constant) = match &number.0 {
            Value::String(text) => {
                let expression = self.parse(path, text, dependence)?;
                let constant = expression.constant();
                let (position, time) =
                    (expression.depends_on_position(), expression.depends_on_time());
                let scalar = ScalarField::new(text.as_str(), move |x, t| expression.eval(x, t));
                (scalar.depending_on(position, time), constant)
            }
            other => {
                let value = literal(path, other)?;
                let scalar = ScalarField::new(other.to_string(), move |_, _| value);
                (scalar.depending_on(false, false), Some(value))
            }
        };
        if let Some(value) = constant {
            self.finite(path, &number.0, value, dependence)?;
        }
        Ok(Field { scalar, constant, source })
    }

    fn parse(
        &self,
        path: &str,
        text: &str,
        dependence: Dependence,
    ) -> Result<Expression, CaseError> {
        let meaning = |name: &str| self.meaning(name, dependence);
        Expression::parse(text, &meaning)
            .map_err(|reason| self.error(path, text, reason, dependence))
    }

    fn meaning(&self, name: &str, dependence: Dependence) -> Result<Meaning, String> {
        if let Some((_, value)) = CONSTANTS.iter().find(|constant| constant.0 == name) {
            return Ok(Meaning::Constant(*value));
        }
        let axis = AXES.iter().position(|axis| *axis == name);
        match (name, axis, self.spacing) {
            ("spacing", _, Some(spacing)) => Ok(Meaning::Constant(spacing)),
            ("t", ..) if dependence == Dependence::PositionAndTime => Ok(Meaning::Time),
            // An expression has one variable that is no coordinate, whatever it is called.
            ("T", ..) if dependence == Dependence::Temperature => Ok(Meaning::Time),
            (_, Some(axis), _) if dependence.is_on_position() && axis < self.dimension => {
                Ok(Meaning::Coordinate(axis))
            }
            ("T" | "t" | "x" | "y" | "z" | "spacing", ..) => {
                Err(format!("\"{name}\" has no meaning here"))
            }
            _ => Err(format!("unknown name \"{name}\"")),
        }
    }

    fn allowed(&self, dependence: Dependence) -> String {
        let mut names: Vec<&str> = CONSTANTS.iter().map(|constant| constant.0).collect();
        if self.spacing.is_some() {
            names.push("spacing");
        }
        if dependence.is_on_position() {
            names.extend(&AXES[..self.dimension]);
        }
        if dependence == Dependence::PositionAndTime {
            names.push("t");
        }
        if dependence == Dependence::Temperature {
            names.push("T");
        }
        format!("{}; functions {}", names.join(" "), function_names())
    }

    fn error(&self, path: &str, text: &str, reason: String, dependence: Dependence) -> CaseError {
        let (path, text) = (path.to_owned(), text.to_owned());
        CaseError::Expression { path, text, reason, allowed: self.allowed(dependence) }
    }

    fn finite(
        &self,
        path: &str,
        written: &Value,
        value: f64,
        dependence: Dependence,
    ) -> Result<f64, CaseError> {
        if value.is_finite() {
            return Ok(value);
        }
        let text = written.as_str().map_or_else(|| written.to_string(), str::to_owned);
        Err(self.error(path, &text, format!("gives {value}"), dependence))
    }
}

/// A number that may depend on position and time, with where it came from.
pub(super) struct Field {
    /// The function.
    pub(super) scalar: ScalarField,
    /// The value, if it depends on neither position nor time.
    pub(super) constant: Option<f64>,
    source: Source,
}

struct Source {
    path: String,
    evaluator: Evaluator,
    dependence: Dependence,
}

impl Field {
    /// Where it stands in the case file.
    pub(super) fn path(&self) -> &str {
        &self.source.path
    }

    /// The value at `x` (m) and `t` (s), which must be finite.
    pub(super) fn at(&self, x: DVec3, t: f64) -> Result<f64, CaseError> {
        if let Some(value) = self.constant {
            return Ok(value);
        }
        let value = self.scalar.at(x, t);
        if value.is_finite() {
            return Ok(value);
        }
        let place = show(x, self.source.evaluator.dimension);
        let reason = match self.source.dependence {
            Dependence::PositionAndTime => format!("gives {value} at {place}, t = {t} s"),
            _ => format!("gives {value} at {place}"),
        };
        let Source { path, evaluator, dependence } = &self.source;
        Err(evaluator.error(path, self.scalar.text(), reason, *dependence))
    }
}

/// `value` if `holds`, else an error that says what it must be.
pub(super) fn in_range(
    path: &str,
    value: f64,
    holds: bool,
    requirement: &str,
) -> Result<f64, CaseError> {
    if holds {
        return Ok(value);
    }
    let (path, requirement) = (path.to_owned(), requirement.to_owned());
    Err(CaseError::Range { path, value, requirement })
}

/// A position in a message: its first `dimension` coordinates.
pub(super) fn show(x: DVec3, dimension: usize) -> String {
    let coordinates: Vec<String> =
        x.to_array()[..dimension].iter().map(|value| value.to_string()).collect();
    format!("[{}]", coordinates.join(", "))
}

fn literal(path: &str, value: &Value) -> Result<f64, CaseError> {
    value.as_f64().ok_or_else(|| wrong_type(path, "a number or an expression", value))
}

fn wrong_type(path: &str, expected: &str, found: &Value) -> CaseError {
    let reason = format!("expected {expected}, found {found}");
    CaseError::WrongType { path: path.to_owned(), reason }
}
