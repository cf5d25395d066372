//! The `sources` section.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::boundary::select;
use super::error::CaseError;
use super::number::{Field, Number};
use super::shape::ShapeSpec;
use super::wall::Body;
use crate::model::{ScalarField, Source};

/// What particles get a second beside what flows between them: `rate` + `linear` x value, at least one of
/// the two. Where several sources act they add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
#[schemars(extend("anyOf" = [{ "required": ["rate"] }, { "required": ["linear"] }]))]
pub(super) struct SourceSpec {
    /// Value a second, which may depend on x y z t; 0 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rate: Option<Number>,
    /// Factor of the value, 1/s, which may depend on x y z: negative for what is lost in proportion to the
    /// value, positive for what grows; 0 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    linear: Option<Number>,
    /// Where it acts; everywhere where absent. Held particles keep their value.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    selection: Option<ShapeSpec>,
}

/// The sources of a case; `end` (s) is that of the simulated time.
pub(super) fn resolve(
    sources: &[SourceSpec],
    body: &Body,
    end: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Source>, CaseError> {
    let resolve = |(index, spec): (usize, &SourceSpec)| {
        spec.resolve(body, &format!("sources[{index}]"), end, warnings)
    };
    sources.iter().enumerate().map(resolve).collect()
}

impl SourceSpec {
    fn resolve(
        &self,
        body: &Body,
        path: &str,
        end: f64,
        warnings: &mut Vec<String>,
    ) -> Result<Source, CaseError> {
        if self.rate.is_none() && self.linear.is_none() {
            return Err(CaseError::MissingKey { path: format!("{path}.rate") });
        }
        let evaluator = body.evaluator;
        let rate = self.rate.as_ref();
        let rate =
            rate.map(|rate| evaluator.field_in_time(&format!("{path}.rate"), rate)).transpose()?;
        let linear = self.linear.as_ref();
        let linear =
            linear.map(|linear| evaluator.field(&format!("{path}.linear"), linear)).transpose()?;
        let select = |spec: &ShapeSpec| {
            let path = format!("{path}.where");
            let shape = spec.resolve(evaluator, &path)?;
            select(body.particles, &shape, body.spacing, &path)
        };
        let mut source = Source {
            name: path.to_owned(),
            particles: self.selection.as_ref().map(select).transpose()?,
            rate: ScalarField::constant(0.0),
            linear: ScalarField::constant(0.0),
        };
        if let Some(rate) = rate {
            check(&rate, &source, body)?;
            source.rate = rate.scalar;
        }
        if let Some(linear) = linear {
            let most = check(&linear, &source, body)?;
            if most > 0.0 {
                warnings.push(format!(
                    "{}: up to {most:.3e} /s, which is positive: the value grows there by itself, by a \
                     factor of up to {:.3e} until time.end, and so does every error in it",
                    linear.path(),
                    (most * end).exp()
                ));
            }
            source.linear = linear.scalar;
        }
        Ok(source)
    }
}

/// Refuses a field that is not finite where the source acts at t = 0; returns its largest value there.
fn check(field: &Field, source: &Source, body: &Body) -> Result<f64, CaseError> {
    if let Some(value) = field.constant {
        return Ok(value);
    }
    let position = &body.particles.position;
    let particles = source.indices(position.len());
    particles
        .map(|particle| field.at(position[particle], 0.0))
        .try_fold(f64::NEG_INFINITY, |most, value| Ok(most.max(value?)))
}
